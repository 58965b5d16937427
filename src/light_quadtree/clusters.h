// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cut through a light map's pyramid [Ki and Oh 2007, 3.2]: the lights that all receivers read.
//
// From the start level down to the limit level: a valid node lights; of an invalid one the four children are looked at;
// at the limit level every node lights. Validity depends on the lights alone, so the cut is found once for all
// receivers: the published method finds it again at every receiver, level by level (gather_as_printed).
//
// DEVIATION(Ki 2007, 3.2): the cut is found once for each light and frame and kept as a list. The sums are the same, to
// the bit.

#include <array>
#include <vector>

#include "light_quadtree/light_map.h"

namespace gnomon::light_quadtree {

/// The paper counts levels from 1, the finest of 512 texels a side, to 10; ours is the number of halvings of a side.
inline constexpr int grid_of_paper_level(int level)
{
    return 10 - level;
}

struct CutLevels {
    int start = 7;   // 8 nodes a side, as in the paper
    int limit = 5;   // 32 nodes a side; 6: 16, 4: 64
};

/// Lights, side by side as the gather reads them. Units: E of a receiver at distance d is
/// r,g,b * cosine there * cosine here / (d^2 + disk), scene units.
struct Clusters {
    std::vector<float> x, y, z;
    std::vector<float> nx, ny, nz;    // shorter than 1 where normals differ
    std::vector<float> disk;          // area / pi
    std::vector<float> r, g, b;       // flux / pi
    std::vector<std::size_t> node;    // of the light map
    std::vector<std::uint8_t> grid;   // log2 of the nodes a side of its level

    std::size_t size() const { return x.size(); }
    void clear();
    void push(const LightNode& light, std::size_t id, int at_grid);
};

/// Level by level, breadth first, views in order; nodes without flux are left out.
void find_clusters(const LightMap& map, const CutLevels& levels, Clusters& out);
/// Every texel, in the order of the map: the sum that clusters approximate.
void all_texels(const LightMap& map, Clusters& out);

}   // namespace gnomon::light_quadtree
