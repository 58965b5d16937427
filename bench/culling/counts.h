// SPDX-License-Identifier: Apache-2.0
#pragma once
// Counts the kd-tree nodes and triangle tests of the shadow rays that each method of bench culling traces.

#include <span>
#include <vector>

#include "base/tasks.h"
#include "bench/core/bench_points.h"
#include "bench/culling/bench.h"
#include "ray/kdtree/kdtree.h"

namespace gnomon::bench {

/// A reading of the published method: by [light][point] its results, and the rays that it cast: 1: a ray against
/// everything; 2: against dynamic objects only.
struct ReadingTile {
    std::vector<std::uint8_t> occluded, rays;
};

/// The points of one tile, and by [light][point] the results and rays of each method.
struct CullingTile : BenchPoints {
    std::vector<std::uint8_t> facing;                  // 1 where the surface faces the light, within its cone
    std::vector<std::uint8_t> off, paper, certified;   // 1 where occluded or facing away
    std::vector<std::uint8_t> paper_rays,
        certified_rays;   // 1: a ray against everything; 2: against dynamic objects only
    std::vector<ReadingTile> readings;
};

/// The last static triangle that occluded a ray from a primitive to a light [Haines and Greenberg 1986]: asked first
/// where the published method traces a ray against everything, which it does where primitives are hidden or shadowed in
/// part [Nah 2009, 4]. A hit proves the shadow at the cost of one triangle test. Never wrong, because the triangle is
/// tested where it is now.
///
/// In the order of tiles and of points within a tile, because each ray reads what the one before it found.
class OccluderCache {
 public:
    OccluderCache(std::size_t primitives, std::size_t lights)
        : lights_(lights), object_(primitives * lights, scene::none), triangle_(primitives * lights)
    {
    }
    scene::ObjectId& object(std::size_t primitive, std::size_t light) { return object_[primitive * lights_ + light]; }
    std::uint32_t& triangle(std::size_t primitive, std::size_t light) { return triangle_[primitive * lights_ + light]; }

 private:
    std::size_t lights_;
    std::vector<scene::ObjectId> object_;   // by primitive and light; none: no occluder known
    std::vector<std::uint32_t> triangle_;
};

/// Traverses the counting kd-tree with every ray that each method traced, and fills in `nodes` and `tests` of the
/// record.
/// @param caches  by reading: null, or the cache of its last occluders, with the culling that numbers its primitives
struct ReadingCache {
    OccluderCache* occluders = nullptr;
    const shadow_culling::PaperCulling* culling = nullptr;
};
void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state, const ray::RayScene& rays,
                     const CullingBenchOptions& options, const std::vector<CullingTile>& tiles,
                     std::span<const ReadingCache> caches, Tasks& tasks, CullingFrame& record);

}   // namespace gnomon::bench
