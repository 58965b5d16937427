// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/anchors.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/micro_triangles.h"
#include "gnomon/error.h"

namespace gnomon::irradiance_cache {

namespace {

// Lattice: bit 63 set | level + 32 (6 bits) | axis and sign (3) | i, j, k + 2^17 (18 each).
constexpr int k_bias = 1 << 17;
constexpr std::uint64_t k_coordinate = (1u << 18) - 1;
constexpr int k_level_bias = 32;
// Part: bit 62: front | bit 61: near field | bit 60: slice | bit 59: corner | level (4 bits) | triangle (32) | index
// (16).
constexpr int k_triangle_shift = 16, k_level_shift = 48, k_slice_shift = 60, k_corner_shift = 59;
constexpr std::uint32_t k_corner_row = 1u << 8;   // the index of a corner is i + k_corner_row j

// The lattice is offset by these fractions of its spacing along the axes. Walls often stand at round coordinates, and
// for a line within the plane of a wall, hits would depend on rounding.
constexpr float k_offset[3] = {0.3819660f, 0.2360680f, 0.1458980f};

int axis_of(const glm::vec3& n)
{
    const glm::vec3 a = glm::abs(n);
    return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

}   // namespace

float spacing_of(int level)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(level + 127) << 23);
}

Detail detail_of(float spacing)
{
    const auto bits = std::bit_cast<std::uint32_t>(spacing);
    const auto mantissa = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u);
    return {static_cast<int>(bits >> 23) - 127, mantissa - 1};
}

LatticeCursor::Step LatticeCursor::go(const IndirectPoint& point, int level)
{
    if (level < -k_level_bias || level >= k_level_bias) return Step::outside;
    const glm::vec3 n = point.geometric_normal;
    const bool other = !any_ || level != level_ || n != normal_;
    if (other) {
        any_ = false;   // until this step is complete
        level_ = level, normal_ = n;
        per_h_ = spacing_of(-level);
        axis_ = axis_of(n), b_ = (axis_ + 1) % 3, c_ = (axis_ + 2) % 3;
        slope_b_ = -n[b_] / n[axis_], slope_c_ = -n[c_] / n[axis_];
    }
    const float x = point.position[b_] * per_h_ - k_offset[b_], y = point.position[c_] * per_h_ - k_offset[c_];
    const float i = std::floor(x), j = std::floor(y);
    if (!(std::abs(i) < k_bias - 2 && std::abs(j) < k_bias - 2)) return Step::outside;
    const float fx = x - i, fy = y - j;
    // Intersect the point's plane with the lines, in spacings.
    const float height = point.position[axis_] * per_h_ - k_offset[axis_] + 0.5f - fx * slope_b_ - fy * slope_c_;
    float k[4];
    for (int corner = 0; corner < 4; ++corner) {
        k[corner] = std::floor(height + (corner & 1 ? slope_b_ : 0) + (corner >> 1 ? slope_c_ : 0));
        if (!(std::abs(k[corner]) < k_bias - 2)) return Step::outside;
    }
    cell_.x = fx, cell_.y = fy;
    if (!other && i == i_ && j == j_ && std::equal(k, k + 4, k_)) return Step::same;
    any_ = true;
    i_ = i, j_ = j;
    std::copy(k, k + 4, k_);
    const std::uint64_t head = (1ull << 63) | (static_cast<std::uint64_t>(level + k_level_bias) << 57) |
                               (static_cast<std::uint64_t>(2 * axis_ + (n[axis_] < 0 ? 1 : 0)) << 54);
    const auto bits = [](float f) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(f) + k_bias) & k_coordinate;
    };
    for (int corner = 0; corner < 4; ++corner)
        cell_.key[corner] = head | (bits(i + static_cast<float>(corner & 1)) << 36) |
                            (bits(j + static_cast<float>(corner >> 1)) << 18) | bits(k[corner]);
    return Step::other;
}

bool lattice_cell(const IndirectPoint& point, int level, LatticeCell& cell)
{
    LatticeCursor cursor;
    if (cursor.go(point, level) == LatticeCursor::Step::outside) return false;
    cell = cursor.cell();
    return true;
}

LatticeLine lattice_line(AnchorKey key)
{
    const float h = lattice_spacing(key);
    const int code = static_cast<int>((key >> 54) & 7), axis = code / 2;
    const float sign = code & 1 ? -1.0f : 1.0f;
    const auto coordinate = [&](int shift, int along) {
        return (static_cast<float>(static_cast<int>((key >> shift) & k_coordinate) - k_bias) + k_offset[along]) * h;
    };
    LatticeLine line{glm::vec3(0), glm::vec3(0)};
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    line.from[b] = coordinate(36, b);
    line.from[c] = coordinate(18, c);
    line.from[axis] = coordinate(0, axis) + sign * h;
    line.direction[axis] = -2 * sign * h;
    return line;
}

float lattice_spacing(AnchorKey key)
{
    return spacing_of(static_cast<int>((key >> 57) & 63) - k_level_bias);
}

int lattice_axis(AnchorKey key)
{
    return static_cast<int>((key >> 54) & 7) / 2;
}

bool is_lattice(AnchorKey key)
{
    return (key >> 63) != 0;
}

PartDetail part_detail(float triangle_area, float spacing)
{
    const float size = std::sqrt(triangle_area) / spacing;
    if (!(size > 1)) return {0, 1};   // NaN, too
    const Detail detail = detail_of(size);
    if (detail.level >= static_cast<int>(k_part_levels)) return {k_part_levels, 1};
    if (detail.fraction == 0) return {static_cast<std::uint32_t>(detail.level), 1};
    return {static_cast<std::uint32_t>(detail.level) + 1, detail.fraction};
}

AnchorKey part_key(std::uint32_t scene_triangle, bool front, std::uint32_t level, float u, float v)
{
    return key_of(
        {scene_triangle, front, level, micro_index_at(std::clamp(u, 0.0f, 1.0f), std::clamp(v, 0.0f, 1.0f), level)});
}

AnchorKey key_of(const Part& part)
{
    return (static_cast<std::uint64_t>(part.front) << 62) | (static_cast<std::uint64_t>(part.slice) << k_slice_shift) |
           (static_cast<std::uint64_t>(part.corner) << k_corner_shift) |
           (static_cast<std::uint64_t>(part.level) << k_level_shift) |
           (static_cast<std::uint64_t>(part.triangle) << k_triangle_shift) | part.index;
}

Part part_of(AnchorKey key)
{
    return {static_cast<std::uint32_t>(key >> k_triangle_shift),
            ((key >> 62) & 1) != 0,
            static_cast<std::uint32_t>((key >> k_level_shift) & 15),
            static_cast<std::uint32_t>(key & 0xffff),
            ((key >> k_slice_shift) & 1) != 0,
            ((key >> k_corner_shift) & 1) != 0};
}

AnchorKey corner_key(std::uint32_t scene_triangle, bool front, std::uint32_t level, std::uint32_t i, std::uint32_t j)
{
    return key_of({scene_triangle, front, level, i + k_corner_row * j, false, true});
}

glm::vec2 place_of_corner(const Part& part, float inset)
{
    const glm::vec2 at(part.index % k_corner_row, part.index / k_corner_row);
    const float n = std::exp2(static_cast<float>(part.level)), moved = inset / n;
    return moved + (1 - 3 * moved) / n * at;
}

std::vector<std::uint32_t> first_triangles(const scene::Scene& scene)
{
    std::vector<std::uint32_t> first;
    first.reserve(scene.objects.size());
    std::uint64_t triangles = 0;
    for (const scene::Object& object : scene.objects) {
        first.push_back(static_cast<std::uint32_t>(triangles));
        triangles += scene.meshes[object.mesh].triangles.size();
    }
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (triangles > most)
        throw MissingError(
            fmt::format("{} triangles, those of all instances, are more than bounced light can tell apart "
                        "({})",
                        triangles, most));
    return first;
}

}   // namespace gnomon::irradiance_cache
