// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cut through a light map's quad-tree [Ki and Oh 2007, 3.2]: the clusters that all receivers gather.
//
// The traversal goes from the start level down to the limit level. A valid node becomes a cluster; an invalid node is
// replaced by its four children; at the limit level every node becomes a cluster. A node that is valid in part
// (Validity::margin) becomes a cluster with its share of the light, and its children have the rest. Validity depends on
// the lights only, so one cut serves all receivers, while the published method finds it again at every receiver, level
// by level (gather_as_printed). Of separate trees (LightMapOptions::separate_trees) the cut of static objects comes
// first, and stays as it is while the lights stay, but for the flux of its clusters.
//
// DEVIATION(Ki 2007, 3.2): the cut is computed once per light and frame and stored as a list. The sums are the same,
// bit for bit.

#include <array>
#include <vector>

#include "light_quadtree/light_map.h"

namespace gnomon::light_quadtree {

/// Converts a level of the paper, from 1 (the finest, 512 texels a side) to 10, to the number of halvings of a side.
inline constexpr int grid_of_paper_level(int level)
{
    return 10 - level;
}

struct CutLevels {
    int start = 7;   // 8 nodes a side, as in the paper
    int limit = 5;   // 32 nodes a side; 6: 16, 4: 64, 1: 512
};

/// The clusters as a structure of arrays. Units: a receiver at distance d gets irradiance r,g,b * cosine at the cluster
/// * cosine at the receiver / (d^2 + disk), in scene units.
struct Clusters {
    std::vector<float> x, y, z;
    std::vector<float> nx, ny, nz;    // shorter than 1 where normals vary
    std::vector<float> disk;          // area / pi
    std::vector<float> r, g, b;       // flux / pi
    std::vector<std::size_t> node;    // LightMap::number()
    std::vector<std::uint8_t> grid;   // log2 of the nodes a side of its level

    std::size_t size() const { return x.size(); }
    void clear();
    /// @param part  of the node's light
    void push(const LightNode& light, std::size_t id, int at_grid, float part = 1);
};

/// Finds the cut level by level, breadth first, views in order; nodes without flux are omitted.
void find_clusters(const LightMap& map, const CutLevels& levels, Clusters& out);
/// Every texel as a cluster, in the order of the map: the sum that a cut approximates.
void all_texels(const LightMap& map, Clusters& out);

}   // namespace gnomon::light_quadtree
