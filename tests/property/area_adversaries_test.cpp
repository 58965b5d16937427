// SPDX-License-Identifier: Apache-2.0
// Proofs of lit and dark parts against segments between corners, edges and middles of parts and lights, in worlds made
// to break them: sheets that are folded, holed, slit, crossing, flush with the light or with the receiver, and lights
// whose plane cuts the receiver.

#include <gtest/gtest.h>

#include "area_light/area_shadows.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"
#include "trap.h"

namespace gnomon::area_light {
namespace {

using visibility::StaticTriangles;
using visibility::TriangleId;

struct Count {
    std::uint64_t segments = 0, wrong = 0, rounded = 0, parts[5]{};   // rounded: contradictions by the kernel
};

void attack(std::uint64_t seed, int parts, Count& count)
{
    Trap trap(seed);
    const LightPolygon light = trap.light();
    if (!(glm::length(light.normal) > 0.5f)) return;
    const auto scene = trap.take();
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    const StaticTriangles triangles(state, rays);
    AreaShadows shadows(triangles, light);
    Random random(seed * 31 + 7);
    const std::vector<glm::vec3> targets = places_on(light.corner.data(), light.corners, random);
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::shadow;
    std::vector<std::uint8_t> expected, occluded;
    for (int n = 0; n < parts; ++n) {
        // Mostly on the receiver.
        const TriangleId id =
            random.below(4) ? random.below(2) : random.below(static_cast<std::uint32_t>(triangles.size()));
        const bool front = random.below(2);
        float u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        AreaShadows::LastPart last;
        const Part part = shadows.part_at(id, front, u, v, last);
        ++count.parts[static_cast<std::size_t>(part.state)];
        if (part.state != PartState::lit && part.state != PartState::dark) continue;
        // The corners of the part that the proof is about.
        glm::dvec2 uv[3] = {{0, 0}, {1, 0}, {0, 1}};
        if (last.owner) corners_of(last.place, last.level, uv);
        const visibility::StaticTriangle& t = triangles[id];
        const glm::vec3 cross = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
        if (!(glm::length(cross) > 0)) continue;
        const glm::vec3 normal = glm::normalize(front ? cross : -cross);
        glm::vec3 corner[3];
        for (int c = 0; c < 3; ++c)
            corner[c] = (1 - static_cast<float>(uv[c].x) - static_cast<float>(uv[c].y)) * t.p[0] +
                        static_cast<float>(uv[c].x) * t.p[1] + static_cast<float>(uv[c].y) * t.p[2] +
                        ray::origin_lift(t.p) * normal;
        for (const glm::vec3& from : places_on(corner, 3, random))
            for (const glm::vec3& to : targets) {
                const glm::vec3 way = to - from;
                constexpr float k_clear = 1e-4f;   // what is seen edge-on may lie on either side
                if (!(glm::dot(way, normal) > k_clear * glm::length(way)) ||
                    !(glm::dot(way, light.normal) < -k_clear * glm::length(way)))
                    continue;
                queue.push(from, 0, way, ray::k_shadow_ray_end);
                expected.push_back(part.state == PartState::dark);
            }
    }
    occluded.resize(queue.size() + ray::k_packet_pad);
    rays.occluded(queue, 0, queue.size(), occluded.data(), ray::Against::static_only);
    for (std::size_t r = 0; r < expected.size(); ++r) {
        ++count.segments;
        if ((occluded[r] != 0) == (expected[r] != 0)) continue;
        count.wrong += crosses_any(triangles, glm::dvec3(queue.origin(r)), glm::dvec3(queue.direction(r)),
                                   static_cast<double>(ray::k_shadow_ray_end)) != (expected[r] != 0);
        ++count.rounded;
    }
}

void expect_none_wrong(std::uint64_t first, std::uint64_t last, int parts)
{
    Count count;
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        const std::uint64_t before = count.wrong;
        attack(seed, parts, count);
        EXPECT_EQ(count.wrong, before) << "seed " << seed;
        if (count.wrong > 0) break;
    }
    for (const PartState state : {PartState::lit, PartState::dark, PartState::listed})
        EXPECT_GT(count.parts[static_cast<std::size_t>(state)], 100u) << static_cast<int>(state);
    EXPECT_GT(count.segments, 10000u);
    testing::Test::RecordProperty("segments", std::to_string(count.segments));
}

TEST(AreaAdversaries, NoSegmentContradictsAProof)
{
    expect_none_wrong(1, 300, 60);
}

TEST(AreaAdversariesFull, NoneOfAHundredMillionSegmentsContradictsAProof)
{
    Count count;
    for (std::uint64_t seed = 301; count.segments < 100'000'000; ++seed) {
        attack(seed, 400, count);
        ASSERT_EQ(count.wrong, 0u) << "seed " << seed;
    }
    EXPECT_LE(count.rounded, count.segments / 20'000);
}

}   // namespace
}   // namespace gnomon::area_light
