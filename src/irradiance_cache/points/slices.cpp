// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/slices.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_slender = 8;   // least ratio of a slender triangle's longest side to its height

std::uint32_t halvings_of_height(const SlenderTriangle& triangle, std::uint32_t level)
{
    return level > triangle.levels ? level - triangle.levels : 0;
}

// The cell of 2^level that holds a coordinate from 0 to 1.
std::uint32_t cell_of(float x, std::uint32_t level)
{
    const auto cells = static_cast<float>(1u << level);
    return static_cast<std::uint32_t>(std::clamp(x * cells, 0.0f, cells - 1));   // of NaN: 0
}

float middle_of(std::uint32_t cell, std::uint32_t level)
{
    return (static_cast<float>(cell) + 0.5f) / static_cast<float>(1u << level);
}

// The third corner's largest weight, from 0 to 1, where a line across the longest side leaves the triangle.
float top_at(const SlenderTriangle& triangle, float along)
{
    if (along < triangle.foot) return along / triangle.foot;
    return triangle.foot < 1 ? (1 - along) / (1 - triangle.foot) : 1.0f;
}

// Where barycentric coordinates lie along the longest side, 0 to 1, and in which row of slices.
struct PlaceInSlender {
    float along;
    std::uint32_t row;
};
PlaceInSlender place_in(const SlenderTriangle& triangle, std::uint32_t level, float u, float v)
{
    const float weight[3]{1 - u - v, u, v};
    const float third = weight[(triangle.first + 2) % 3];
    const float along = std::clamp(weight[(triangle.first + 1) % 3] + triangle.foot * third, 0.0f, 1.0f);
    const float top = top_at(triangle, along);
    return {along, top > 0 ? cell_of(third / top, halvings_of_height(triangle, level)) : 0};
}

}   // namespace

SlenderTriangle slender_triangle(const glm::vec3 corner[3])
{
    SlenderTriangle triangle;
    float longest = 0;
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 side = corner[(i + 1) % 3] - corner[i];
        const float square = glm::dot(side, side);
        if (square > longest) longest = square, triangle.first = i;
    }
    if (!(longest > 0)) return triangle;
    const glm::vec3 from = corner[triangle.first], side = corner[(triangle.first + 1) % 3] - from,
                    third = corner[(triangle.first + 2) % 3] - from;
    triangle.length = std::sqrt(longest);
    triangle.height = glm::length(glm::cross(side, third)) / triangle.length;
    triangle.foot = std::clamp(glm::dot(third, side) / longest, 0.0f, 1.0f);
    // A triangle is half as wide in the mean.
    const float ratio = 2 * triangle.length / triangle.height;
    triangle.levels = ratio > 1 ? static_cast<std::uint32_t>(std::clamp(detail_of(ratio).level, 0, 32)) : 0;
    return triangle;
}

bool is_slender(const SlenderTriangle& triangle)
{
    return triangle.height > 0 && triangle.length > k_slender * triangle.height;
}

AnchorKey slice_key(const SlenderTriangle& triangle, std::uint32_t scene_triangle, bool front, std::uint32_t level,
                    float u, float v)
{
    const auto [along, row] = place_in(triangle, level, u, v);
    return key_of(Part{scene_triangle, front, level, (row << level) | cell_of(along, level), true});
}

SlicesAround slices_around(const SlenderTriangle& triangle, std::uint32_t scene_triangle, bool front,
                           std::uint32_t level, float u, float v)
{
    const auto [along, row] = place_in(triangle, level, u, v);
    const auto last = static_cast<float>((1u << level) - 1);
    const float x = std::clamp(along * (last + 1) - 0.5f, 0.0f, last), first = std::min(std::floor(x), last);
    const auto key = [&, row = row](float cell) {
        return key_of(Part{scene_triangle, front, level, (row << level) | static_cast<std::uint32_t>(cell), true});
    };
    return {{key(first), key(std::min(first + 1, last))}, {1 - (x - first), x - first}};
}

SliceMiddle middle_of_slice(const SlenderTriangle& triangle, const Part& part)
{
    const std::uint32_t across = halvings_of_height(triangle, part.level);
    const float along = middle_of(part.index & ((1u << part.level) - 1), part.level);
    const float third = middle_of(part.index >> part.level, across) * top_at(triangle, along);
    SliceMiddle middle{};
    middle.weight[static_cast<std::size_t>((triangle.first + 2) % 3)] = third;
    const float second = along - triangle.foot * third;
    middle.weight[static_cast<std::size_t>((triangle.first + 1) % 3)] = second;
    middle.weight[static_cast<std::size_t>(triangle.first)] = 1 - second - third;
    middle.size = std::sqrt(0.5f * triangle.length * triangle.height / static_cast<float>(1u << (part.level + across)));
    return middle;
}

}   // namespace gnomon::irradiance_cache
