// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the files of CellVisibility (cell_visibility.cpp, cell_parts.cpp, cell_stand_ins.cpp) share.

#include <algorithm>
#include <bit>

#include "environment_light/cell_visibility.h"

namespace gnomon::environment_light {

inline constexpr std::size_t k_rays_at_once = 1 << 14;
inline constexpr std::size_t k_block = 16;   // points whose rays in one direction are neighbours
// Of a ray's direction above the surface, least sine: below, the mean direction of the cell stands in.
inline constexpr float k_least_sine = 1e-3f;
// Points in the dark look for windows in one of so many sets of directions.
inline constexpr std::size_t k_window_kinds = 2;
// In the memory of a point in the dark: a leaf with this bit is one of which a part shows the sky; the last entry says
// which parts the point looked at.
inline constexpr std::uint32_t k_glimpse = 0x80000000, k_last_glimpse = 0xffffffff;
inline constexpr std::uint32_t k_no_glance = 0xffffffff;

template <class Body>
void for_each_bit(std::span<const std::uint64_t> mask, const Body& body)
{
    for (std::size_t w = 0; w < mask.size(); ++w)
        for (std::uint64_t word = mask[w]; word != 0; word &= word - 1)
            body(64 * w + static_cast<std::size_t>(std::countr_zero(word)));
}

inline bool has(std::span<const std::uint64_t> mask, std::size_t leaf)
{
    return (mask[leaf / 64] >> (leaf % 64) & 1) != 0;
}

inline void set(std::span<std::uint64_t> mask, std::size_t leaf, bool value)
{
    const std::uint64_t bit = std::uint64_t{1} << (leaf % 64);
    mask[leaf / 64] = value ? mask[leaf / 64] | bit : mask[leaf / 64] & ~bit;
}

// Calls body(word, bits) for the words of a mask with some leaves in a row.
template <class Body>
void for_each_word(std::size_t first, std::size_t count, const Body& body)
{
    for (std::size_t at = first; at < first + count;) {
        const std::size_t bits = std::min(64 - at % 64, first + count - at);
        body(at / 64, (bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0}) << (at % 64));
        at += bits;
    }
}

// The arguments of one call.
struct CellVisibility::Query {
    Scratch& scratch;
    std::span<const visibility::ShadowPoint> points;
    std::span<const std::uint32_t> asked;
    std::span<const Guides> guides;
    SeenCells& seen;
    std::size_t first = 0;   // the points before it are answered

    static constexpr int k_answered = 255;   // in place of a pass
    std::size_t count() const { return asked.size(); }
    const visibility::ShadowPoint& point(std::size_t k) const { return points[asked[k]]; }
    std::vector<char> is_coarse = {};   // by asked point; empty: none
    bool rough = false;                 // so are all
    bool coarse(std::size_t k) const { return k >= first && !is_coarse.empty() && is_coarse[k] != 0; }
    int pass(std::size_t k) const { return k < first ? k_answered : guides.empty() ? 0 : guides[k].pass; }
    std::span<std::uint64_t> of(std::vector<std::uint64_t>& masks, std::size_t k) const
    {
        return {masks.data() + k * seen.words, seen.words};
    }
};

}   // namespace gnomon::environment_light
