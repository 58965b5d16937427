// SPDX-License-Identifier: Apache-2.0
#pragma once
// Addresses, parents and corners of the 4^k equal parts of a triangle, subdivided as for opacity micromaps.
//
// Level k divides both barycentric axes by n = 2^k. A part is (i, j, upper): lower parts have corners (i, j), (i+1, j),
// (i, j+1) over n, upper ones (i+1, j+1), (i, j+1), (i+1, j). The n * n parts of a level fill a square array without
// gaps: an upper part is stored where the mirror image of its cell would be.

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/math.h"

namespace gnomon {

struct MicroTriangle {
    std::uint32_t i = 0, j = 0;
    std::uint32_t upper = 0;   // 0 or 1
    friend constexpr bool operator==(const MicroTriangle&, const MicroTriangle&) = default;
};

/// Number of parts before level k in a pyramid: (4^k - 1) / 3.
constexpr std::uint32_t pyramid_offset(std::uint32_t level)
{
    return ((1u << (2 * level)) - 1) / 3;
}
/// Number of parts of a pyramid with levels 0 ... k.
constexpr std::uint32_t pyramid_size(std::uint32_t level)
{
    return pyramid_offset(level + 1);
}

constexpr std::uint32_t micro_index(const MicroTriangle& m, std::uint32_t level)
{
    const std::uint32_t n = 1u << level;
    return m.upper ? (n - 1 - m.j) * n + (n - 1 - m.i) : m.j * n + m.i;
}

constexpr MicroTriangle micro_at(std::uint32_t index, std::uint32_t level)
{
    const std::uint32_t n = 1u << level;
    const std::uint32_t i = index & (n - 1), j = index >> level;
    return i + j < n ? MicroTriangle{i, j, 0} : MicroTriangle{n - 1 - i, n - 1 - j, 1};
}

/// The part that contains (u, v). Both are at least 0; points with u + v > 1 are moved back into the triangle.
inline MicroTriangle micro_part_at(float u, float v, std::uint32_t level)
{
    const auto n = static_cast<std::int32_t>(1u << level);
    const float x = u * static_cast<float>(n), y = v * static_cast<float>(n);
    auto i = static_cast<std::int32_t>(x), j = static_cast<std::int32_t>(y);
    std::int32_t upper = (x - static_cast<float>(i)) + (y - static_cast<float>(j)) > 1.0f;
    // Rounding may put a point on the long edge into a cell beyond it. Move it back.
    if (i + j + upper >= n) {
        i = std::min(i, n - 1);
        j = std::min(j, n - 1 - i);
        upper = 0;
    }
    return {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(upper)};
}
inline std::uint32_t micro_index_at(float u, float v, std::uint32_t level)
{
    return micro_index(micro_part_at(u, v, level), level);
}

constexpr MicroTriangle parent_of(const MicroTriangle& m)
{
    return {m.i >> 1, m.j >> 1, ((m.i & 1) + (m.j & 1) + m.upper) >= 2 ? 1u : 0u};
}

/// The part that contains a part, so many levels up: parent_of() as often.
constexpr MicroTriangle ancestor_of(const MicroTriangle& m, std::uint32_t levels)
{
    const std::uint32_t low = (1u << levels) - 1;
    return {m.i >> levels, m.j >> levels, (m.i & low) + (m.j & low) + m.upper > low ? 1u : 0u};
}

/// The four parts of the next level into which a part is divided.
constexpr void children_of(const MicroTriangle& m, MicroTriangle (&child)[4])
{
    const std::uint32_t i = 2 * m.i, j = 2 * m.j;
    if (!m.upper) {
        child[0] = {i, j, 0}, child[1] = {i + 1, j, 0}, child[2] = {i, j + 1, 0}, child[3] = {i, j, 1};
    } else {
        child[0] = {i + 1, j + 1, 1}, child[1] = {i, j + 1, 1}, child[2] = {i + 1, j, 1}, child[3] = {i + 1, j + 1, 0};
    }
}

/// The parts of every level that contain a point. Each is the parent of the next, however the coordinates round.
struct MicroPath {
    std::array<MicroTriangle, 16> at;

    MicroPath(float u, float v, int levels)
    {
        auto level = static_cast<std::size_t>(levels);
        at[level] =
            micro_at(micro_index_at(u, v, static_cast<std::uint32_t>(levels)), static_cast<std::uint32_t>(levels));
        for (; level > 0; --level) at[level - 1] = parent_of(at[level]);
    }
    /// Which quarter of the part of this level the next one is, in the order of children_of().
    std::size_t quarter(std::size_t level) const
    {
        const MicroTriangle& next = at[level + 1];
        if (next.upper != at[level].upper) return 3;
        const std::size_t i = next.i & 1, j = next.j & 1;
        return next.upper ? (1 - i) + 2 * (1 - j) : i + 2 * j;
    }
};

/// Barycentric (u, v) of a part's corners.
inline void corners_of(const MicroTriangle& m, std::uint32_t level, glm::dvec2 (&corner)[3])
{
    const double scale = 1.0 / static_cast<double>(1u << level);
    const double i = m.i, j = m.j;
    if (!m.upper)
        corner[0] = {i, j}, corner[1] = {i + 1, j}, corner[2] = {i, j + 1};
    else
        corner[0] = {i + 1, j + 1}, corner[1] = {i, j + 1}, corner[2] = {i + 1, j};
    for (glm::dvec2& c : corner) c *= scale;
}

}   // namespace gnomon
