// SPDX-License-Identifier: Apache-2.0
// What points see of flat lights among random triangles, some of which move: place by place that of all triangles,
// frame after frame.
#include "area_light/area_visibility.h"

#include <gtest/gtest.h>

#include <numeric>

#include "scene_helpers.h"
#include "soup.h"

namespace gnomon::area_light {
namespace {

using shadow_culling::ShadowPoint;

AreaLight random_light(Random& random)
{
    const auto any = [&](float reach) {
        return glm::vec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
    };
    const float size = random.below(2) ? 0.3f : 1.5f;
    const glm::vec3 at = any(2.5f), u = size * any(1), v = size * any(1);
    LightPolygon outline{{at, at + u, at + u + v, at + v}, 4, glm::normalize(glm::cross(u, v))};
    AreaLight light;
    light.shape = outline;
    // Half of them are two triangles of the four that the outline's diagonals make.
    if (random.below(2)) {
        const glm::vec3 middle = at + 0.5f * (u + v);
        light.shape.faces = {{{at, at + u, middle, middle}, 3, outline.normal},
                             {{at + u + v, at + v, middle, middle}, 3, outline.normal}};
    }
    light.two_sided = random.below(2);
    return light;
}

struct Tally {
    std::uint64_t lit = 0, dark = 0, partial = 0, places = 0, different = 0;
};

// Compares an answer with the places that all triangles leave visible.
void compare(const AreaVisibility& visibility, const LightPlaces& places, const ShadowPoint& p, bool back,
             const TriangleList& everything, AreaVisibility::Answer answer, const VisibleCells* cells, Tally& tally)
{
    const glm::vec3 normal = (back ? -1.0f : 1.0f) * visibility.cells(0, false).normal();
    PlaceMask counted{};   // clearly above the horizons
    for (int r = 0; r < k_rows; ++r)
        for (int i = 0; i < k_row_places; ++i) {
            const glm::vec3 way = places.position(r, i) - p.origin;
            constexpr float k_clear = 1e-4f;
            if (glm::dot(way, p.normal) > k_clear * glm::length(way) &&
                glm::dot(way, normal) < -k_clear * glm::length(way))
                counted[static_cast<std::size_t>(r)] |= std::uint64_t{1} << i;
        }
    PlaceMask blocked{}, others{};
    add_blocked(p.origin, everything, places, blocked);
    for (std::size_t r = 0; r < blocked.size(); ++r) blocked[r] &= counted[r], others[r] = ~counted[r];
    VisibleCells most, least;   // with and without places that do not count
    count_visible(places, blocked, most);
    for (std::size_t r = 0; r < blocked.size(); ++r) blocked[r] |= others[r];
    count_visible(places, blocked, least);
    const LightCells& of = visibility.cells(0, back);
    for (int c = 0; c < k_cells; ++c) {
        const auto at = static_cast<std::size_t>(c);
        const int got = answer == AreaVisibility::Answer::lit    ? of.count(c)
                        : answer == AreaVisibility::Answer::dark ? 0
                                                                 : (*cells)[at];
        tally.places += least[at] > 0 || most[at] < of.count(c);
        tally.different += got < least[at] || got > most[at];
    }
}

void follow(std::uint64_t seed, int dynamic_objects, int frames, Tally& tally)
{
    const auto scene = Soup(seed, dynamic_objects).take();
    scene::SceneState state(scene, 0);
    Random random(seed * 17 + 3);
    const AreaLight light = random_light(random);
    if (!(glm::length(light.shape.outline.normal) > 0.5f)) return;
    // What moves once is dynamic from then on.
    move_last(*scene, state, random, static_cast<std::size_t>(dynamic_objects));
    state.advance(0);
    ray::RayScene rays(state);
    // Some forget everything after each frame.
    AreaOptions options;
    if (seed % 3 == 0) options.most_bytes = 1;
    AreaVisibility visibility(state, rays, options);
    AreaVisibility::Scratch scratch;
    for (int f = 0; f < frames; ++f) {
        if (f > 0) {
            move_last(*scene, state, random, static_cast<std::size_t>(dynamic_objects));
            state.advance(0);
            rays.update(state);
        }
        visibility.follow(state, rays, {&light, 1});
        // Rays decide about what is singular, or nearly so.
        bool listed = true;
        for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
            listed = listed && (!state.is_dynamic(o) || rays.meeting(o) != ray::Meeting::roughly);
        if (!listed) continue;
        TriangleList everything;
        for (scene::ObjectId o = 0; o < scene->objects.size(); ++o) {
            const ray::ObjectGeometry& geometry = rays.geometry(o);
            for (std::uint32_t t = 0; t < geometry.mesh->triangles.size(); ++t) {
                glm::vec3 corner[3];
                geometry.corners(t, corner);
                everything.push(corner);
            }
        }
        everything.pad();
        const std::vector<ShadowPoint> points = random_points(*scene, rays, random, 60);
        std::vector<std::uint32_t> asked;
        for (std::uint32_t p = 0; p < points.size(); ++p)
            // Points that move are answered by rays, to the middles of cells.
            if (!state.is_dynamic(points[p].object)) asked.push_back(p);
        AreaVisibility::Answers answers;
        visibility.find(scratch, points, asked, 0, answers);
        const LightPlaces front(light.shape);
        for (std::size_t k = 0; k < asked.size(); ++k) {
            if (answers.state[k] == PartState::open || answers.state[k] == PartState::unlit || answers.back[k])
                continue;
            const ShadowPoint& p = points[asked[k]];
            const float height = glm::dot(light.shape.outline.normal, p.origin - light.shape.outline.corner[0]);
            if (!(height > 1e-4f)) continue;
            tally.lit += answers.answer[k] == AreaVisibility::Answer::lit;
            tally.dark += answers.answer[k] == AreaVisibility::Answer::dark;
            tally.partial += answers.answer[k] == AreaVisibility::Answer::partial;
            compare(visibility, front, p, false, everything, answers.answer[k], answers.cells.data() + answers.at[k],
                    tally);
        }
    }
}

void expect_right(std::uint64_t first, std::uint64_t last)
{
    Tally tally;
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        const std::uint64_t before = tally.different;
        follow(seed, 3, 4, tally);
        EXPECT_EQ(tally.different, before) << "seed " << seed;
    }
    EXPECT_GT(tally.lit, 100u);
    EXPECT_GT(tally.dark, 100u);
    EXPECT_GT(tally.partial, 100u);
}

TEST(AreaVisibility, SeesPastWhatMovesAsPastAllTriangles)
{
    expect_right(1, 60);
}

// A floor under a chessboard of holes and a square light: what is looked up is what rays find, place by place.
TEST(AreaVisibility, LooksUpTheHolesThatRaysPassThrough)
{
    scene::Scene scene;
    test::add_materials(scene);
    const auto add_square = [&](float half, float height, scene::MaterialId material) {
        scene::Mesh mesh;
        mesh.positions = {{-half, height, -half}, {-half, height, half}, {half, height, half}, {half, height, -half}};
        mesh.texcoords[0] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{material, 0, 2}};
        scene.meshes.push_back(std::move(mesh));
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1));
    };
    add_square(2, 0, test::two_sided);
    add_square(1, 0.6f, test::cut_out);
    scene.finish();
    const auto finished = std::make_shared<const scene::Scene>(std::move(scene));
    const scene::SceneState state(finished, 0);
    const ray::RayScene rays(state);
    AreaLight light;
    light.shape =
        LightPolygon{{{{-0.4f, 2, -0.4f}, {0.4f, 2, -0.4f}, {0.4f, 2, 0.4f}, {-0.4f, 2, 0.4f}}}, 4, {0, -1, 0}};
    AreaVisibility visibility(state, rays);
    visibility.follow(state, rays, {&light, 1});
    Random random(3);
    std::vector<ShadowPoint> points;
    for (const ShadowPoint& p : random_points(*finished, rays, random, 400))
        if (p.object == 0 && p.normal.y > 0) points.push_back(p);
    std::vector<std::uint32_t> asked(points.size());
    std::iota(asked.begin(), asked.end(), 0u);
    AreaVisibility::Scratch scratch;
    AreaVisibility::Answers answers;
    visibility.find(scratch, points, asked, 0, answers);
    EXPECT_EQ(scratch.counters.rays, 0u);
    const LightPlaces places(light.shape);
    double squares = 0, holed = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        int seen = 0, expected = 0;
        if (answers.answer[k] == AreaVisibility::Answer::lit) seen = places.count();
        if (answers.answer[k] == AreaVisibility::Answer::partial)
            for (const std::uint8_t count : answers.cells[answers.at[k]]) seen += count;
        for (int r = 0; r < k_rows; ++r)
            for (int i = 0; i < k_row_places; ++i)
                if (places.inside()[static_cast<std::size_t>(r)] >> i & 1)
                    expected += !rays.occluded_single(points[k].origin, 0, places.position(r, i) - points[k].origin,
                                                      ray::k_shadow_ray_end, ray::Against::static_only);
        const double difference = static_cast<double>(seen - expected) / places.count();
        EXPECT_LE(std::abs(difference), 0.002) << k;
        squares += difference * difference;
        holed += expected > 0 && expected < places.count();
    }
    EXPECT_GT(holed, 20);
    EXPECT_LE(std::sqrt(squares / static_cast<double>(points.size())), 0.0003);
}

TEST(AreaVisibilityFull, SeesPastWhatMovesAsPastAllTrianglesInAThousandSoups)
{
    expect_right(61, 1060);
}

}   // namespace
}   // namespace gnomon::area_light
