// SPDX-License-Identifier: Apache-2.0
#pragma once
// Selects the pixels of a tile whose irradiance is computed, and interpolates the others between them on the screen.
//
// Cache points are at least 12 pixels apart, so on a plane the irradiance of neighbouring pixels is nearly linear.
// Where all pixels of a small block lie in one plane, only its corners are computed. The selection depends on the tile
// alone.
//
// Cost: one comparison per pixel, and four multiplications per colour for those that are interpolated.

#include <array>
#include <span>
#include <vector>

#include "irradiance_cache/points/anchors.h"

namespace gnomon::irradiance_cache {

/// Pixels that are interpolated on the screen, in little memory.
class RememberedPixels {
 public:
    /// Interpolates their values between those of the others: numbers, or vectors of three or four.
    template <class Value>
    void fill(Value* values) const;
    std::size_t bytes() const { return point_.capacity() * sizeof(std::uint16_t) + blocks_.capacity() * sizeof(Block); }

 private:
    friend class SparsePixels;
    struct Block {
        std::uint8_t x0, y0, x1, y1;   // its corners' pixels
    };
    static constexpr std::uint16_t k_computed = 1u << 15;   // marks points
    std::vector<std::uint16_t> point_;                      // by pixel; empty without blocks
    std::vector<Block> blocks_;
};

class SparsePixels {
 public:
    static constexpr int k_side = 32;   // of a tile, in pixels
    static constexpr int k_step = 4;    // between the corners of a block; or, if the block is not planar,
    static constexpr int k_least_step = 2;
    /// Selects among points in any order. Points without a place in the tile, or with one that is taken, are computed.
    /// @param exempt  by point: must not be interpolated
    void choose(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt);
    /// The points to compute, in rising order.
    const std::vector<std::uint32_t>& computed() const { return computed_; }
    /// Interpolates the values of the others, likewise.
    template <class Value>
    void fill(Value* values) const;
    /// What fill() needs. The points are fewer than 2^15.
    RememberedPixels remembered() const;

 private:
    struct Block {
        std::int32_t x0, y0, x1, y1;   // its corners' pixels
    };
    void number_planes(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt);
    bool take(int x0, int y0, int step);
    void compute_all(int x0, int y0);

    static constexpr std::size_t k_pixels = static_cast<std::size_t>(k_side) * k_side;
    std::array<std::int32_t, k_pixels> at_;      // point by pixel, -1: none
    std::array<std::int16_t, k_pixels> plane_;   // number by pixel, -1: must not be interpolated
    std::array<std::int16_t, k_pixels> run_;     // number of pixels from here on, in the row, in the same plane
    std::vector<std::uint32_t> first_of_plane_;
    std::vector<std::uint8_t> direct_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> computed_;
};

}   // namespace gnomon::irradiance_cache
