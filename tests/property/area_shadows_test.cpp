// SPDX-License-Identifier: Apache-2.0
// Remembered shadows of planar lights among random triangles: proofs hold for every segment, lists lack nothing, and
// what is remembered does not depend on the order in which points are asked.

#include "area_light/area_shadows.h"

#include <gtest/gtest.h>

#include "area_light/visible_cells.h"
#include "ray/origin.h"
#include "soup.h"

namespace gnomon::area_light {
namespace {

using shadow_culling::ShadowPoint;
using visibility::StaticTriangles;
using visibility::TriangleId;

LightPolygon random_polygon(Random& random)
{
    const auto any = [&](float reach) {
        return glm::vec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
    };
    LightPolygon light;
    const float size = random.below(3) == 0 ? 0.02f : random.below(2) ? 0.3f : 1.5f;
    const glm::vec3 at = any(2.5f), u = size * any(1), v = size * any(1);
    light.corner = {at, at + u, at + u + v, at + v};
    light.corners = random.below(3) == 0 ? 3 : 4;
    light.normal = glm::normalize(glm::cross(u, v));
    return light;
}

struct World {
    std::shared_ptr<const scene::Scene> scene;
    scene::SceneState state;
    ray::RayScene rays;
    StaticTriangles triangles;

    explicit World(std::uint64_t seed) : scene(Soup(seed).take()), state(scene, 0), rays(state), triangles(state, rays)
    {
    }
    TriangleId id_of(const ShadowPoint& p) const { return triangles.first_of(p.object) + p.triangle; }
};

// The places that count for a point: clearly above its horizon, and facing it.
PlaceMask places_of(const ShadowPoint& p, const LightPlaces& places)
{
    PlaceMask mask{};
    for (int r = 0; r < k_rows; ++r)
        for (int i = 0; i < k_row_places; ++i) {
            const glm::vec3 way = places.position(r, i) - p.origin;
            constexpr float k_clear = 1e-4f;
            if (glm::dot(way, p.normal) > k_clear * glm::length(way) &&
                glm::dot(way, places.polygon().normal) < -k_clear * glm::length(way))
                mask[static_cast<std::size_t>(r)] |= places.inside()[static_cast<std::size_t>(r)] & std::uint64_t{1}
                                                                                                        << i;
        }
    return mask;
}

struct Tally {
    std::uint64_t points[5]{};   // by state
    std::uint64_t wrong = 0;     // places
    std::uint64_t segments = 0, wrong_segments = 0;
};

// Compares remembered answers with all triangles, place by place, and with rays to random points of the light.
void compare(std::uint64_t seed, const AreaOptions& options, Tally& tally, int segments = 32)
{
    World world(seed);
    if (world.triangles.size() == 0) return;
    Random random(seed * 977 + 5);
    const LightPolygon light = random_polygon(random);
    if (!(glm::length(light.normal) > 0.5f)) return;
    AreaShadows shadows(world.triangles, light, options);
    TriangleList everything;
    for (TriangleId id = 0; id < world.triangles.size(); ++id) everything.push(world.triangles[id].p);
    everything.pad();
    for (const ShadowPoint& p : random_points(*world.scene, world.rays, random, 60)) {
        if (glm::dot(light.normal, p.origin - light.corner[0]) <= 1e-4f) continue;
        const Part part = shadows.part_at(world.id_of(p), p.front, p.u, p.v);
        ++tally.points[static_cast<std::size_t>(part.state)];
        const PlaceMask counted = places_of(p, shadows.places());
        if (part.state == PartState::open) continue;
        PlaceMask truth{}, answer{};
        add_blocked(p.origin, everything, shadows.places(), truth);
        if (part.state == PartState::dark) answer.fill(~std::uint64_t{0});
        if (part.state == PartState::listed) {
            TriangleList list;
            for (const TriangleId id : *part.list) list.push(world.triangles[id].p);
            list.pad();
            add_blocked(p.origin, list, shadows.places(), answer);
        }
        if (part.state == PartState::unlit) {
            EXPECT_EQ(count_places(counted), 0) << "seed " << seed;
            continue;
        }
        for (std::size_t r = 0; r < truth.size(); ++r)
            tally.wrong += static_cast<std::uint64_t>(std::popcount((truth[r] ^ answer[r]) & counted[r]));
        if (part.state == PartState::listed) continue;
        for (int s = 0; s < segments; ++s) {
            const int row = static_cast<int>(random.below(k_rows)),
                      place = static_cast<int>(random.below(k_row_places));
            if ((counted[static_cast<std::size_t>(row)] >> place & 1) == 0) continue;
            const bool blocked =
                world.rays.occluded_single(p.origin, 0, shadows.places().position(row, place) - p.origin,
                                           ray::k_shadow_ray_end, ray::Against::static_only);
            ++tally.segments;
            tally.wrong_segments += blocked != (part.state == PartState::dark);
        }
    }
}

void expect_right(std::uint64_t first, std::uint64_t last)
{
    Tally tally;
    for (std::uint64_t seed = first; seed <= last; ++seed) compare(seed, {}, tally);
    EXPECT_EQ(tally.wrong, 0u);
    EXPECT_EQ(tally.wrong_segments, 0u) << "of " << tally.segments;
    for (const PartState state : {PartState::unlit, PartState::lit, PartState::listed})
        EXPECT_GT(tally.points[static_cast<std::size_t>(state)], 20u) << static_cast<int>(state);
    EXPECT_GT(tally.points[static_cast<std::size_t>(PartState::dark)], 0u);
}

TEST(AreaShadows, AnswersAreThoseOfAllTrianglesInRandomSoups)
{
    expect_right(1, 150);
}

TEST(AreaShadowsFull, AnswersAreThoseOfAllTrianglesInTenThousandRandomSoups)
{
    expect_right(151, 10150);
}

TEST(AreaShadows, AnswersDoNotDependOnTheOrderInWhichPointsAreAsked)
{
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        World world(seed);
        if (world.triangles.size() == 0) continue;
        Random random(seed);
        const LightPolygon light = random_polygon(random);
        AreaShadows kept(world.triangles, light);
        const std::vector<ShadowPoint> points = random_points(*world.scene, world.rays, random, 60);
        for (const ShadowPoint& p : points) kept.part_at(world.id_of(p), p.front, p.u, p.v);
        for (std::size_t k = points.size(); k-- > 0;) {
            const ShadowPoint& p = points[k];
            std::vector<TriangleId> list;
            const Part fresh = kept.judged_anew(world.id_of(p), p.front, p.u, p.v, list);
            const Part remembered = kept.part_at(world.id_of(p), p.front, p.u, p.v);
            ASSERT_EQ(fresh.state, remembered.state) << "seed " << seed;
            if (fresh.list) EXPECT_EQ(*fresh.list, *remembered.list) << "seed " << seed;
        }
    }
}

}   // namespace
}   // namespace gnomon::area_light
