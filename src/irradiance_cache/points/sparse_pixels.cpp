// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/sparse_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace gnomon::irradiance_cache {

namespace {

// Points lie in one plane if their normals are this close, and their distance from it is below this many pixels.
constexpr float k_same_normal = 0.9999f, k_off_plane = 0.25f;
// Size of both normals, object and triangle.
constexpr std::size_t k_plane_bytes = 2 * sizeof(glm::vec3) + 2 * sizeof(std::uint32_t);

bool in_plane(const IndirectPoint& a, const IndirectPoint& b)
{
    return glm::dot(a.geometric_normal, b.geometric_normal) > k_same_normal &&
           glm::dot(a.normal, b.normal) > k_same_normal &&
           std::abs(glm::dot(b.position - a.position, a.geometric_normal)) < k_off_plane * a.width;
}

// Index of a pixel in the tile.
constexpr std::size_t place_of(int x, int y)
{
    return static_cast<std::size_t>(y) * SparsePixels::k_side + static_cast<std::size_t>(x);
}

// Interpolates values between those at the corners of blocks of pixels.
// @param point     the number of the point at a pixel
// @param computed  whether it has its value
template <class Blocks, class Point, class Computed, class Value>
void fill_between(const Blocks& blocks, const Point& point, const Computed& computed, Value* values)
{
    for (const auto& b : blocks) {
        const Value low0 = values[point(b.x0, b.y0)], low1 = values[point(b.x1, b.y0)],
                    high0 = values[point(b.x0, b.y1)], high1 = values[point(b.x1, b.y1)];
        const float per_x = 1 / static_cast<float>(b.x1 - b.x0), per_y = 1 / static_cast<float>(b.y1 - b.y0);
        for (int y = b.y0; y <= b.y1; ++y) {
            const float v = static_cast<float>(y - b.y0) * per_y;
            const Value left = low0 + v * (high0 - low0), right = low1 + v * (high1 - low1);
            for (int x = b.x0; x <= b.x1; ++x) {
                const std::size_t i = point(x, y);
                if (computed(x, y, i)) continue;
                values[i] = left + static_cast<float>(x - b.x0) * per_x * (right - left);
            }
        }
    }
}

}   // namespace

// Gives neighbouring pixels in a row or a column that lie in one plane the same number.
void SparsePixels::number_planes(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt)
{
    at_.fill(-1);
    plane_.fill(-1);
    first_of_plane_.clear();
    direct_.assign(points.size(), 0);
    // Compare the members that define a plane at once; they are adjacent in memory.
    static_assert(offsetof(IndirectPoint, triangle) + sizeof(IndirectPoint::triangle) ==
                  offsetof(IndirectPoint, geometric_normal) + k_plane_bytes);
    const auto plane_bytes = [](const IndirectPoint& p) {
        return reinterpret_cast<const unsigned char*>(&p) + offsetof(IndirectPoint, geometric_normal);
    };
    const auto same = [&](std::int16_t plane, const IndirectPoint& p) {
        if (plane < 0) return false;
        const IndirectPoint& first = points[first_of_plane_[static_cast<std::size_t>(plane)]];
        return std::memcmp(plane_bytes(first), plane_bytes(p), k_plane_bytes) == 0 || in_plane(first, p);
    };
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const IndirectPoint& p = points[i];
        const bool inside = p.x >= 0 && p.y >= 0 && p.x < k_side && p.y < k_side;
        const auto place = place_of(p.x, p.y);
        if (!inside || at_[place] >= 0) {
            direct_[i] = 1;
            continue;
        }
        at_[place] = static_cast<std::int32_t>(i);
        if (exempt[i]) continue;
        const std::int16_t left = p.x > 0 ? plane_[place - 1] : std::int16_t{-1};
        const std::int16_t above = p.y > 0 ? plane_[place - k_side] : std::int16_t{-1};
        std::int16_t& plane = plane_[place];
        if (same(left, p)) {
            plane = left;
        } else if (above != left && same(above, p)) {
            plane = above;
        } else {
            plane = static_cast<std::int16_t>(first_of_plane_.size());
            first_of_plane_.push_back(i);
        }
    }
    for (std::size_t row = 0; row < plane_.size(); row += k_side) {
        run_[row + k_side - 1] = 1;
        for (std::size_t place = row + k_side - 1; place-- > row;)
            run_[place] =
                plane_[place] == plane_[place + 1] ? static_cast<std::int16_t>(run_[place + 1] + 1) : std::int16_t{1};
    }
}

// Selects the corners of a block if all its pixels lie in one plane.
bool SparsePixels::take(int x0, int y0, int step)
{
    const Block b{x0, y0, std::min(x0 + step, k_side - 1), std::min(y0 + step, k_side - 1)};
    const auto first = place_of(x0, y0);
    if (plane_[first] < 0) return false;
    for (int y = y0; y <= b.y1; ++y) {
        const auto row = place_of(x0, y);
        if (plane_[row] != plane_[first] || run_[row] < b.x1 - x0 + 1) return false;
    }
    blocks_.push_back(b);
    for (const int y : {y0, b.y1})
        for (const int x : {x0, b.x1}) direct_[static_cast<std::size_t>(at_[place_of(x, y)])] = 1;
    return true;
}

void SparsePixels::choose(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt)
{
    blocks_.clear();
    computed_.clear();
    number_planes(points, exempt);
    for (int y = 0; y < k_side; y += k_step)
        for (int x = 0; x < k_side; x += k_step) {
            if (take(x, y, k_step)) continue;
            for (const int y0 : {y, y + k_least_step})
                for (const int x0 : {x, x + k_least_step})
                    if (!take(x0, y0, k_least_step)) compute_all(x0, y0);
        }
    for (std::uint32_t i = 0; i < direct_.size(); ++i)
        if (direct_[i]) computed_.push_back(i);
}

// Selects all pixels of a block without its far row and column, which belong to the next blocks.
void SparsePixels::compute_all(int x0, int y0)
{
    for (int y = y0; y < y0 + k_least_step; ++y)
        for (int x = x0; x < x0 + k_least_step; ++x)
            if (const std::int32_t i = at_[place_of(x, y)]; i >= 0) direct_[static_cast<std::size_t>(i)] = 1;
}

template <class Value>
void SparsePixels::fill(Value* values) const
{
    const auto point = [&](int x, int y) { return static_cast<std::size_t>(at_[place_of(x, y)]); };
    fill_between(
        blocks_, point, [&](int, int, std::size_t i) { return direct_[i] != 0; }, values);
}

RememberedPixels SparsePixels::remembered() const
{
    RememberedPixels result;
    if (blocks_.empty()) return result;
    result.point_.resize(k_pixels);
    for (std::size_t place = 0; place < k_pixels; ++place) {
        if (at_[place] < 0) continue;
        const bool computed = direct_[static_cast<std::size_t>(at_[place])] != 0;
        result.point_[place] = static_cast<std::uint16_t>(at_[place] | (computed ? RememberedPixels::k_computed : 0));
    }
    result.blocks_.reserve(blocks_.size());
    const auto byte = [](std::int32_t at) { return static_cast<std::uint8_t>(at); };
    for (const Block& b : blocks_) result.blocks_.push_back({byte(b.x0), byte(b.y0), byte(b.x1), byte(b.y1)});
    return result;
}

template <class Value>
void RememberedPixels::fill(Value* values) const
{
    const auto point = [&](int x, int y) {
        return static_cast<std::size_t>(point_[place_of(x, y)] & ~std::uint32_t{k_computed});
    };
    fill_between(
        blocks_, point, [&](int x, int y, std::size_t) { return (point_[place_of(x, y)] & k_computed) != 0; }, values);
}

template void SparsePixels::fill(float*) const;
template void SparsePixels::fill(glm::vec3*) const;
template void SparsePixels::fill(glm::vec4*) const;
template void RememberedPixels::fill(float*) const;
template void RememberedPixels::fill(glm::vec3*) const;
template void RememberedPixels::fill(glm::vec4*) const;

}   // namespace gnomon::irradiance_cache
