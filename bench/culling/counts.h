// SPDX-License-Identifier: Apache-2.0
#pragma once
// Counts the kd-tree nodes and triangle tests of the shadow rays that each method of bench culling traces.

#include <vector>

#include "base/tasks.h"
#include "bench/core/bench_points.h"
#include "bench/culling/bench.h"
#include "ray/kdtree/kdtree.h"

namespace gnomon::bench {

/// The points of one tile, and by [light][point] the results and rays of each method.
struct CullingTile : BenchPoints {
    std::vector<std::uint8_t> facing;                  // 1 where the surface faces the light, within its cone
    std::vector<std::uint8_t> off, paper, certified;   // 1 where occluded or facing away
    std::vector<std::uint8_t> paper_rays,
        certified_rays;   // 1: a ray against everything; 2: against dynamic objects only
};

/// Traverses the counting kd-tree with every ray that each method traced, and fills in `nodes` and `tests` of the
/// record.
void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state,
                     const std::vector<CullingTile>& tiles, Tasks& tasks, CullingFrame& record);

}   // namespace gnomon::bench
