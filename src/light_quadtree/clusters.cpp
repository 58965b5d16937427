// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/clusters.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::light_quadtree {

void Clusters::clear()
{
    for (auto* lane : {&x, &y, &z, &nx, &ny, &nz, &disk, &r, &g, &b}) lane->clear();
    node.clear();
    grid.clear();
}

void Clusters::push(const LightNode& light, std::size_t id, int at_grid, float part)
{
    constexpr auto k_per_pi = static_cast<float>(1 / k_pi);
    x.push_back(light.position.x), y.push_back(light.position.y), z.push_back(light.position.z);
    nx.push_back(light.normal.x), ny.push_back(light.normal.y), nz.push_back(light.normal.z);
    disk.push_back(light.area * k_per_pi);
    const float power = k_per_pi * part;
    r.push_back(light.flux.x * power), g.push_back(light.flux.y * power), b.push_back(light.flux.z * power);
    node.push_back(id);
    grid.push_back(static_cast<std::uint8_t>(at_grid));
}

void find_clusters(const LightMap& map, const CutLevels& levels, Clusters& out)
{
    struct Place {
        const LightMap::View* view;
        int x, y;
        float rest;   // of the light, left by the nodes above
    };
    out.clear();
    std::vector<Place> here, below;
    const int start = grid_of_paper_level(levels.start);
    GNOMON_CHECK(start >= 0 && levels.limit <= levels.start && (1 << start) <= map.options().least_side);
    for (const LightMap::Tree tree : map.trees()) {
        for (const LightMap::View& view : map.views()) {
            if (!view.on) continue;
            for (int y = 0; y < 1 << start; ++y)
                for (int x = 0; x < 1 << start; ++x) here.push_back({&view, x, y, 1});
        }
        for (int grid = start; !here.empty(); ++grid) {
            below.clear();
            for (const Place& place : here) {
                // The cut of a map smaller than the limit level ends at its texels.
                const LightMap::View& view = *place.view;
                const int limit = std::min(grid_of_paper_level(levels.limit), view.levels);
                const Share share = grid < limit ? map.share(tree, view, grid, place.x, place.y) : k_whole_share;
                if (share < k_whole_share) {
                    const float rest = place.rest * left_by(share);
                    for (int child = 0; child < 4; ++child)
                        below.push_back({&view, 2 * place.x + child % 2, 2 * place.y + child / 2, rest});
                }
                const LightNode light = map.node(tree, view, grid, place.x, place.y);
                if (share > 0 && light.flux != glm::vec3(0))
                    out.push(light, map.number(tree, view.node(grid, place.x, place.y)), grid,
                             place.rest * taken_by(share));
            }
            std::swap(here, below);
        }
    }
}

void all_texels(const LightMap& map, Clusters& out)
{
    out.clear();
    for (const LightMap::View& view : map.views()) {
        if (!view.on) continue;
        const std::size_t first = view.node(view.levels, 0, 0), end = view.node(view.levels + 1, 0, 0);
        for (std::size_t id = first; id < end; ++id)
            if (map.node(id).flux != glm::vec3(0)) out.push(map.node(id), id, view.levels);
    }
}

}   // namespace gnomon::light_quadtree
