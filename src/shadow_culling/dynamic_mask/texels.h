// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which texel of a light's plane every point lies in, many points at a time (Highway).
//
// The plane is divided into 2^level texels a side, the level so that a texel is about as wide as the pixels that the
// point is seen through; blocks of 32 x 32 texels are what masks are drawn in. Single precision, in one order: every
// instruction set finds the same texels. The twin for one point is LightSpace::project and level_of below.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shadow_culling/certified/shadow_point.h"
#include "shadow_culling/dynamic_mask/light_space.h"

namespace gnomon::shadow_culling {

inline constexpr std::uint32_t k_block_bits = 5;
inline constexpr std::uint32_t k_block_side = 1u << k_block_bits;   // a row of texels is the bits of a word
inline constexpr std::uint32_t k_max_mask_level = 20;

/// What a block is called: its level, face and place.
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
/// Of points that a directional light's plane does not hold, and such in a lamp.
inline constexpr BlockKey k_no_block = ~BlockKey{0};

/// The level for a point seen from a distance: of texels `texel_pixels` pixels wide.
std::uint32_t level_of(const LightSpace& space, const CullingView& view, float texel_pixels, const glm::vec3& point,
                       float depth);

/// What is known of a point and something that lies over texels. `maybe_self`: unknown for what begins first alone,
/// which may be what the point is on.
enum class MaskAnswer : std::uint8_t { not_drawn, unknown, free, occluded, maybe_self };

/// Points and their texels, by point; arrays are padded.
struct Texels {
    std::vector<float> x, y, z;             // places, in
    std::vector<float> depth;               // out
    std::vector<std::uint32_t> high, low;   // halves of the block's key
    std::vector<std::uint32_t> texel;       // in the block: row * 32 + column
    std::size_t count = 0;

    /// Padded by at least a step.
    void resize(std::size_t points);
    BlockKey key(std::size_t point) const { return static_cast<BlockKey>(high[point]) << 32 | low[point]; }
};

/// Fills what is out.
void find_texels(const LightSpace& space, const CullingView& view, float texel_pixels, Texels& points);

/// What lies over the texels of a block, by its number there: some objects between light and scene, each of which
/// begins and ends at some depth.
struct MaskTexels {
    static constexpr std::uint32_t k_numbers = 256;
    /// By number: depths; number 0 is nothing, and begins and ends nowhere.
    std::vector<float> begins, ends;
    /// By texel, row by row: bits 0-7 what begins first, 8-15 what begins next, 16-23 what covers all of it.
    std::array<std::uint32_t, k_block_side * k_block_side> texel;

    std::uint32_t first(std::uint32_t at) const { return texel[at] & 255; }
    std::uint32_t next(std::uint32_t at) const { return texel[at] >> 8 & 255; }
    std::uint32_t full(std::uint32_t at) const { return texel[at] >> 16 & 255; }
};

/// answer[i] for points [first, end) of one block: occluded behind what covers the texel, free before anything begins,
/// else unknown; of points that move, unknown or maybe_self. Arrays may be read and written up to a step beyond the
/// end.
/// @param moving  by point: 1 where it is on something that moves
/// @param still   the depth at which anything static begins
/// @param clear   by point: 1 where it moves and is nearer than that
void compare_depths(const Texels& points, std::size_t first, std::size_t end, const MaskTexels& over,
                    const std::uint8_t* moving, float still, MaskAnswer* answer, std::uint8_t* clear);

}   // namespace gnomon::shadow_culling
