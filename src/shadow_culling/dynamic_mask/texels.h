// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds the texel of a light's plane for many points at a time, and compares depths there (Highway).
//
// The plane is divided into 2^level texels per side; the level is chosen so that a texel is about as wide as the pixels
// that show the point. Masks are drawn in blocks of 32 x 32 texels. Single precision, in one order, so that every
// instruction set finds the same texels. The reference implementation for one point is LightSpace::project and
// level_of.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shadow_culling/certified/shadow_point.h"
#include "shadow_culling/dynamic_mask/light_space.h"

namespace gnomon::shadow_culling {

inline constexpr std::uint32_t k_block_bits = 5;
inline constexpr std::uint32_t k_block_side = 1u << k_block_bits;   // a row of texels is one word of bits
inline constexpr std::uint32_t k_max_mask_level = 20;

/// Identifies a block by level, face and position.
using BlockKey = std::uint64_t;
constexpr BlockKey block_key(std::uint32_t level, std::uint32_t face, std::uint32_t x, std::uint32_t y)
{
    return static_cast<BlockKey>(level << 3 | face) << 32 | (x << 16 | y);
}
constexpr std::uint32_t level_of(BlockKey key)
{
    return static_cast<std::uint32_t>(key >> 35);
}
constexpr std::uint32_t face_of(BlockKey key)
{
    return static_cast<std::uint32_t>(key >> 32) & 7;
}
constexpr std::uint32_t x_of(BlockKey key)
{
    return static_cast<std::uint32_t>(key) >> 16;
}
constexpr std::uint32_t y_of(BlockKey key)
{
    return static_cast<std::uint32_t>(key) & 0xffff;
}
/// Of points outside a directional light's plane, and of points at a light's own position.
inline constexpr BlockKey k_no_block = ~BlockKey{0};

/// The level at which texels are about `texel_pixels` pixels wide for this point in the view.
std::uint32_t level_of(const LightSpace& space, const CullingView& view, float texel_pixels, const glm::vec3& point,
                       float depth);

/// The result of a comparison with the objects over a texel. `maybe_self`: unknown only because of the first object,
/// which may be the one that the point is on.
enum class MaskAnswer : std::uint8_t { not_drawn, unknown, free, occluded, maybe_self };

/// Points and their texels, by point; arrays are padded.
struct Texels {
    std::vector<float> x, y, z;             // positions: input
    std::vector<float> depth;               // output, as all below
    std::vector<std::uint32_t> high, low;   // halves of the block's key
    std::vector<std::uint32_t> texel;       // in the block: row * 32 + column
    std::size_t count = 0;

    /// Padded by at least a step.
    void resize(std::size_t points);
    BlockKey key(std::size_t point) const { return static_cast<BlockKey>(high[point]) << 32 | low[point]; }
};

/// Computes the output arrays.
void find_texels(const LightSpace& space, const CullingView& view, float texel_pixels, Texels& points);

/// The objects over the texels of a block, numbered within it; each begins and ends at some depth.
struct MaskTexels {
    static constexpr std::uint32_t k_numbers = 256;
    /// Depths by number; number 0 stands for no object, and its depths are infinite.
    std::vector<float> begins, ends;
    /// By texel, row by row. Bits 0-7: the object that begins first; 8-15: next; 16-23: one that covers the texel.
    std::array<std::uint32_t, k_block_side * k_block_side> texel;

    std::uint32_t first(std::uint32_t at) const { return texel[at] & 255; }
    std::uint32_t next(std::uint32_t at) const { return texel[at] >> 8 & 255; }
    std::uint32_t full(std::uint32_t at) const { return texel[at] >> 16 & 255; }
};

/// Sets answer[i] for points [first, end) of one block: occluded behind the object that covers the texel, free before
/// the first object begins, else unknown; or maybe_self for points on dynamic objects. Arrays may be read and written
/// up to a step beyond the end.
/// @param moving  by point: 1 where it is on a dynamic object
/// @param still   the depth at which static geometry begins
/// @param clear   by point: set to 1 where `moving` is 1 and the point is nearer than `still`
void compare_depths(const Texels& points, std::size_t first, std::size_t end, const MaskTexels& over,
                    const std::uint8_t* moving, float still, MaskAnswer* answer, std::uint8_t* clear);

}   // namespace gnomon::shadow_culling
