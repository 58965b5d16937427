// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/counts.h"

#include "ray/origin.h"

namespace gnomon::bench {

void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state,
                     const std::vector<CullingTile>& tiles, Tasks& tasks, CullingFrame& record)
{
    const scene::Scene& scene = state.scene();
    struct Sums {
        ray::KdCounts off, paper, certified;
    };
    const auto add = [](ray::KdCounts& sum, const ray::KdCounts& part) {
        sum.nodes += part.nodes;
        sum.tests += part.tests;
    };

    // Count for each tile.
    std::vector<Sums> sums(tiles.size());
    tasks.for_each(tiles.size(), [&](std::size_t t, int) {
        const CullingTile& tile = tiles[t];
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
            const bool directional = scene.lights[l].type == scene::LightType::directional;
            const float end = directional ? k_infinity : ray::k_shadow_ray_end;
            for (std::size_t p = 0; p < tile.points.size(); ++p) {
                const std::size_t at_point = l * tile.points.size() + p;
                if (!tile.facing[at_point]) continue;
                const auto& point = tile.points[p];
                const glm::vec3 d = directional ? -at.direction : at.position - point.origin;
                ray::KdCounts all, dynamic_objects;
                tree.occluded(point.origin, 0, d, end, ray::Against::everything, all);
                const int paper = tile.paper_rays[at_point], certified = tile.certified_rays[at_point];
                if (paper == 2 || certified == 2)
                    tree.occluded(point.origin, 0, d, end, ray::Against::dynamic_only, dynamic_objects);
                add(sums[t].off, all);
                if (paper) add(sums[t].paper, paper == 1 ? all : dynamic_objects);
                if (certified) add(sums[t].certified, certified == 1 ? all : dynamic_objects);
            }
        }
    });

    // Sum over the tiles.
    for (const Sums& s : sums) {
        record.off.nodes += s.off.nodes, record.off.tests += s.off.tests;
        record.paper.nodes += s.paper.nodes, record.paper.tests += s.paper.tests;
        record.certified.nodes += s.certified.nodes, record.certified.tests += s.certified.tests;
    }
}

}   // namespace gnomon::bench
