// SPDX-License-Identifier: Apache-2.0
#pragma once
// On a plane, indirect light of neighbouring pixels differs by next to nothing: points of it lie 12 pixels apart. So of
// a tile's pixels in a plane only the corners of small blocks are reckoned, and what lies between is interpolated on
// the screen. A function of the tile alone.
//
// Cost: a look at every point, and four multiplications a colour for those interpolated.

#include <span>
#include <vector>

#include "light_quadtree/anchors.h"

namespace gnomon::light_quadtree {

class SparsePixels {
 public:
    static constexpr int k_side = 32;   // of a tile, in pixels
    static constexpr int k_step = 4;    // between the corners of a block
    /// Points in any order. Those without a place in a tile, and those of which a tile has two, are all reckoned.
    /// @param exempt  by point: not to be interpolated
    void choose(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt);
    /// Points to reckon, rising.
    const std::vector<std::uint32_t>& reckoned() const { return reckoned_; }
    /// Fills in the others.
    void fill(glm::vec3* irradiance) const;

 private:
    struct Block {
        std::int32_t x0, y0, x1, y1;   // its corners' pixels
    };
    std::vector<std::int32_t> at_;   // point by pixel, -1: none
    std::vector<std::uint8_t> direct_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> reckoned_;
};

}   // namespace gnomon::light_quadtree
