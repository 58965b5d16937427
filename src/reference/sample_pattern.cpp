// SPDX-License-Identifier: Apache-2.0
#include "reference/sample_pattern.h"

#include <algorithm>

#include "base/morton.h"
#include "base/sobol.h"

namespace gnomon::reference {

const std::vector<SamplePattern::Point>& SamplePattern::points(int count)
{
    std::vector<Point>& points = kept_[count];
    if (!points.empty()) return points;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i)
        points.emplace_back(reversed_bits(i), second_dimension(i));
    const auto morton = [](const Point& p) { return morton_code(p.second, p.first); };
    std::sort(points.begin(), points.end(), [&](const Point& a, const Point& b) { return morton(a) < morton(b); });
    return points;
}

namespace {

// Scrambles the bits of a fraction, each by those above it [Laine and Karras 2011]. The bits are in reverse.
std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

}   // namespace

std::uint32_t PathNumbers::shuffled(std::uint64_t seed) const
{
    return reversed_bits(scramble_reversed(reversed_bits(index_), static_cast<std::uint32_t>(seed)));
}

glm::vec2 PathNumbers::pair(std::uint32_t decision) const
{
    const std::uint64_t seed = mix(seed_, decision);
    const auto low = static_cast<std::uint32_t>(seed), high = static_cast<std::uint32_t>(seed >> 32);
    // Shuffle the sequence, so that decisions are independent of each other.
    const std::uint32_t index = shuffled(seed);
    const std::uint32_t u = scramble_reversed(index, high);
    const std::uint32_t v =
        scramble_reversed(reversed_bits(second_dimension(index)), (low ^ 0x85ebca6bu) * 0xc2b2ae35u + high);
    return {unit_fraction(reversed_bits(u)), unit_fraction(reversed_bits(v))};
}

float PathNumbers::one(std::uint32_t decision) const
{
    const std::uint64_t seed = mix(seed_, decision);
    return unit_fraction(reversed_bits(scramble_reversed(shuffled(seed), static_cast<std::uint32_t>(seed >> 32))));
}

glm::vec3 cosine_direction(const glm::vec3& n, float u, float v)
{
    // Fold the square onto the disk, ring by ring.
    const float a = 2 * u - 1, b = 2 * v - 1;
    constexpr auto quarter = static_cast<float>(k_pi / 4);
    const bool wide = std::abs(a) > std::abs(b);
    const float radius = wide ? a : b;
    if (radius == 0) return n;
    // Sine and cosine of an angle up to an eighth of a turn by their series, to the rounding of float.
    const float angle = quarter * ((wide ? b : a) / radius), square = angle * angle;
    const float sine =
        angle * (1 + square * (-1.0f / 6 + square * (1.0f / 120 + square * (-1.0f / 5040 + square * (1.0f / 362880)))));
    const float cosine = 1 + square * (-0.5f + square * (1.0f / 24 + square * (-1.0f / 720 + square * (1.0f / 40320))));
    const float x = radius * (wide ? cosine : sine), y = radius * (wide ? sine : cosine);
    const float z = std::sqrt(std::max(0.0f, 1 - x * x - y * y));
    glm::vec3 s, t;
    make_basis(n, s, t);
    return x * s + y * t + z * n;
}

// Applies the finaliser of SplitMix64 [Steele, Lea and Flood 2014] to both.
std::uint64_t mix(std::uint64_t a, std::uint64_t b)
{
    std::uint64_t z = a + 0x9e3779b97f4a7c15ull * (b + 1);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

}   // namespace gnomon::reference
