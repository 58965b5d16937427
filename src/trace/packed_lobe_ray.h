// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rays of lobes as the lobe filter keeps them until all tiles are traced, in half of their bytes.
//
// Directions are points of an octahedron's faces, on a grid of triangles: less than 5e-5 from the direction, and those
// along axes exact. Colours are three numbers of 13 bits with one exponent, rounded to nearest: less than .02 % of the
// largest from the colour. Fewer bits would not do: each ray of a saturated metal would have the same error in the
// channels of which it reflects little.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "trace/lobe_filter.h"

namespace gnomon::trace {

using PackedDirection = std::array<std::int16_t, 2>;
using PackedColor = std::array<std::uint16_t, 3>;

/// @param v  of any length; that of 0 is read as one along z
inline PackedDirection pack_direction(const glm::vec3& v)
{
    constexpr int k_steps = 32767;
    const glm::vec3 size = glm::abs(v);
    const float sum = size.x + size.y + size.z;
    if (!(sum > 0)) return {0, 0};
    // Round to numbers whose sum is that of the face: correct the one that is rounded most.
    const glm::vec3 exact = size * (static_cast<float>(k_steps) / sum);
    std::array<int, 3> at{};
    int all = 0, most = 0;
    for (int k = 0; k < 3; ++k) {
        at[static_cast<std::size_t>(k)] = static_cast<int>(exact[k] + 0.5f);
        all += at[static_cast<std::size_t>(k)];
        const auto error = [&](int i) {
            return std::abs(exact[i] - static_cast<float>(at[static_cast<std::size_t>(i)]));
        };
        if (error(k) > error(most)) most = k;
    }
    at[static_cast<std::size_t>(most)] += k_steps - all;
    // The lower half lies outside the square of the upper one, folded over its sides.
    const int x = v.z < 0 ? k_steps - at[1] : at[0], y = v.z < 0 ? k_steps - at[0] : at[1];
    return {static_cast<std::int16_t>(v.x < 0 ? -x : x), static_cast<std::int16_t>(v.y < 0 ? -y : y)};
}

inline glm::vec3 unpack_direction(const PackedDirection& packed)
{
    constexpr int k_steps = 32767;
    int x = std::abs(static_cast<int>(packed[0])), y = std::abs(static_cast<int>(packed[1]));
    const int z = k_steps - x - y;
    if (z < 0) {
        const int folded = k_steps - y;
        y = k_steps - x, x = folded;
    }
    const glm::vec3 v(packed[0] < 0 ? -x : x, packed[1] < 0 ? -y : y, z);
    return v * (1 / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
}

// Two to an exponent from -126 to 127.
inline float power_of_two(int exponent)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(exponent + 127) << 23);
}

inline constexpr int k_color_bits = 13, k_least_exponent = -100;   // below, numbers lose bits

inline PackedColor pack_color(const glm::vec3& color)
{
    const float largest = std::min(std::max({color.x, color.y, color.z}), 3e38f);
    if (!(largest > 0)) return {0, 0, 0};
    // Such that the largest, divided by two to it, is from 1/2 to 1, also once rounded.
    int exponent = std::max(static_cast<int>(std::bit_cast<std::uint32_t>(largest) >> 23) - 126, k_least_exponent);
    const auto rounded = [&](float value) {
        return static_cast<std::uint64_t>(
            std::min(std::max(value, 0.0f), largest) * power_of_two(k_color_bits - exponent) + 0.5f);
    };
    if (rounded(largest) >> k_color_bits != 0) ++exponent;
    const std::uint64_t bits = rounded(color.x) | rounded(color.y) << k_color_bits |
                               rounded(color.z) << 2 * k_color_bits |
                               static_cast<std::uint64_t>(exponent - k_least_exponent) << 3 * k_color_bits;
    return {static_cast<std::uint16_t>(bits), static_cast<std::uint16_t>(bits >> 16),
            static_cast<std::uint16_t>(bits >> 32)};
}

inline glm::vec3 unpack_color(const PackedColor& packed)
{
    const std::uint64_t bits = packed[0] | std::uint64_t{packed[1]} << 16 | std::uint64_t{packed[2]} << 32;
    const int exponent = static_cast<int>(bits >> 3 * k_color_bits) + k_least_exponent;
    const float scale = power_of_two(exponent - k_color_bits);
    const auto number = [&](int k) {
        return static_cast<float>(bits >> k * k_color_bits & ((std::uint64_t{1} << k_color_bits) - 1)) * scale;
    };
    return {number(0), number(1), number(2)};
}

struct PackedLobeRay {
    float nearness = 0, density = 0;   // as those of LobeRay
    PackedDirection direction{}, normal{};
    PackedColor light{}, weight{};
};
static_assert(sizeof(PackedLobeRay) == 28);

inline PackedLobeRay packed(const LobeRay& ray)
{
    return {ray.nearness,          ray.density,           pack_direction(ray.direction), pack_direction(ray.normal),
            pack_color(ray.light), pack_color(ray.weight)};
}

inline LobeRay unpacked(const PackedLobeRay& ray)
{
    return {unpack_direction(ray.direction), ray.nearness, unpack_direction(ray.normal), unpack_color(ray.light),
            unpack_color(ray.weight),        ray.density};
}

}   // namespace gnomon::trace
