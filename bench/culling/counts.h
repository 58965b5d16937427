// SPDX-License-Identifier: Apache-2.0
#pragma once
// What bench culling notes of each tile, and what its rays cost on the counting kd-tree.

#include <vector>

#include "base/tasks.h"
#include "bench/core/bench_points.h"
#include "bench/culling/bench.h"
#include "ray/kdtree/kdtree.h"

namespace gnomon::bench {

/// The points of one tile, and by [light][point] what each method said and did about them.
struct CullingTile : BenchPoints {
    std::vector<std::uint8_t> asked;                   // 1 where the light shines on the surface
    std::vector<std::uint8_t> off, paper, certified;   // 1 occluded or behind
    std::vector<std::uint8_t> paper_rays,
        certified_rays;   // 1 a ray against everything, 2 against dynamic objects alone
};

/// Walks the counting kd-tree with every ray that each method traced, and fills in nodes and tests of the record.
void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state,
                     const std::vector<CullingTile>& tiles, Tasks& tasks, CullingFrame& record);

}   // namespace gnomon::bench
