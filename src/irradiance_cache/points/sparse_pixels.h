// SPDX-License-Identifier: Apache-2.0
#pragma once
// On a plane, indirect light of neighbouring pixels differs by next to nothing: points of it lie 12 pixels apart. So of
// a tile's pixels in a plane only the corners of small blocks are reckoned, and what lies between is interpolated on
// the screen. A function of the tile alone.
//
// Cost: a look at every point, and four multiplications a colour for those interpolated.

#include <array>
#include <span>
#include <vector>

#include "irradiance_cache/points/anchors.h"

namespace gnomon::irradiance_cache {

class SparsePixels {
 public:
    static constexpr int k_side = 32;   // of a tile, in pixels
    static constexpr int k_step = 4;    // between the corners of a block, or, where that is not of one plane,
    static constexpr int k_least_step = 2;
    /// Points in any order. Those without a place in a tile, and those of which a tile has two, are all reckoned.
    /// @param exempt  by point: not to be interpolated
    void choose(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt);
    /// Points to reckon, rising.
    const std::vector<std::uint32_t>& computed() const { return computed_; }
    /// Fills in the others.
    void fill(glm::vec3* values) const;
    void fill(float* values) const;

 private:
    struct Block {
        std::int32_t x0, y0, x1, y1;   // its corners' pixels
    };
    void number_planes(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt);
    template <class Value>
    void fill_blocks(Value* values) const;
    bool take(int x0, int y0, int step);
    void compute_all(int x0, int y0);

    static constexpr std::size_t k_pixels = static_cast<std::size_t>(k_side) * k_side;
    std::array<std::int32_t, k_pixels> at_;      // point by pixel, -1: none
    std::array<std::int16_t, k_pixels> plane_;   // number by pixel, -1: not to be interpolated
    std::array<std::int16_t, k_pixels> run_;     // how many pixels from here on, in the row, lie in the same plane
    std::vector<std::uint32_t> first_of_plane_;
    std::vector<std::uint8_t> direct_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> computed_;
};

}   // namespace gnomon::irradiance_cache
