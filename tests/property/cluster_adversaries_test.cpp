// SPDX-License-Identifier: Apache-2.0
// Proofs of lit and dark parts for clusters of polygons, against segments between corners, edges and middles of parts
// and faces, in worlds made to break them (trap.h): the cluster is a solid, or some of its faces, dented or convex.

#include <gtest/gtest.h>

#include "area_light/cluster_shadows.h"
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

void attack(std::uint64_t seed, int parts, Count& count, ClusterCheck left_out = ClusterCheck::none)
{
    Trap trap(seed, true);
    const Cluster cluster{trap.faces(), false};
    if (cluster.faces.empty()) return;
    const auto scene = trap.take();
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    const StaticTriangles triangles(state, rays);
    AreaOptions options;
    options.least_part = 0;   // of every size
    ClusterShadows shadows(triangles, cluster, options, left_out);
    Random random(seed * 31 + 7);
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
        PartTree::LastPart last;
        const Part part = shadows.part_at(id, front, u, v, last);
        ++count.parts[static_cast<std::size_t>(part.state)];
        if (part.state == PartState::open) continue;
        // The corners of the part that the proof is about.
        const visibility::StaticTriangle& t = triangles[id];
        const Piece piece(t, front, last.owner ? last.place : MicroTriangle{}, last.owner ? last.level : 0);
        if (!piece.has_area()) continue;
        const glm::vec3 normal(piece.normal);
        glm::vec3 corner[3];
        for (int c = 0; c < 3; ++c) corner[c] = glm::vec3(piece.corner[c] + piece.lift * piece.normal);
        const LightPolygon& face = cluster.faces[random.below(static_cast<std::uint32_t>(cluster.faces.size()))];
        for (const glm::vec3& from : places_on(corner, 3, random))
            for (const glm::vec3& to : places_on(face.corner.data(), face.corners, random)) {
                // A place in single precision may lie behind its own face, which then hides it from a point beside it.
                constexpr float k_rounding = 4e-6f;
                const glm::vec3 way = to + k_rounding * face.normal - from;
                constexpr float k_clear = 1e-4f;   // what is seen edge-on may lie on either side
                if (!(glm::dot(way, normal) > k_clear * glm::length(way)) ||
                    !(glm::dot(way, face.normal) < -k_clear * glm::length(way)))
                    continue;
                count.wrong += part.state == PartState::unlit;
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

TEST(ClusterAdversaries, NoSegmentContradictsAProof)
{
    Count count;
    for (std::uint64_t seed = 1; seed <= 600; ++seed) {
        attack(seed, 60, count);
        ASSERT_EQ(count.wrong, 0u) << "seed " << seed;
    }
    for (const PartState state : {PartState::unlit, PartState::lit, PartState::dark, PartState::open})
        EXPECT_GT(count.parts[static_cast<std::size_t>(state)], 100u) << static_cast<int>(state);
    EXPECT_GT(count.segments, 10'000u);
}

TEST(ClusterAdversaries, EachCheckIsNeeded)
{
    for (const ClusterCheck check :
         {ClusterCheck::behind_all, ClusterCheck::clear_of_part, ClusterCheck::clear_of_cluster,
          ClusterCheck::no_open_edge, ClusterCheck::crosses}) {
        Count count;
        for (std::uint64_t seed = 1; seed <= 2000 && count.wrong == 0; ++seed) attack(seed, 60, count, check);
        EXPECT_GT(count.wrong, 0u) << "check " << static_cast<int>(check);
    }
}

TEST(ClusterAdversariesFull, NoneOfAHundredMillionSegmentsContradictsAProof)
{
    Count count;
    for (std::uint64_t seed = 601; count.segments < 100'000'000; ++seed) {
        attack(seed, 400, count);
        ASSERT_EQ(count.wrong, 0u) << "seed " << seed;
    }
    EXPECT_LE(count.rounded, count.segments / 20'000);
}

}   // namespace
}   // namespace gnomon::area_light
