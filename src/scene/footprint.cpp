// SPDX-License-Identifier: Apache-2.0
#include "scene/footprint.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace gnomon::scene {

namespace {

constexpr float k_no_sample_more = GNOMON_FOOTPRINT_NO_SAMPLE_MORE;   // in samples; keeps rounding from adding one
// This near to a level's texel size, in octaves, one level suffices.
constexpr float k_one_level = GNOMON_FOOTPRINT_ONE_LEVEL;
// Periods or texels; beyond, floats have too few bits left for steps.
constexpr float k_far = GNOMON_FOOTPRINT_FAR;

using Four = float __attribute__((vector_size(16)));   // a colour in a register

// Spreads a texel's four bytes over four colours, whose sum is the texel. This avoids moves between registers.
struct Decoder {
    std::array<std::array<Four, 256>, 4> byte{};

    explicit Decoder(bool srgb)
    {
        for (std::size_t i = 0; i < 256; ++i) {
            const float value = static_cast<float>(i) * (1.0f / 255.0f), light = srgb ? linear_from_srgb8()[i] : value;
            byte[0][i] = Four{light, 0, 0, 0}, byte[1][i] = Four{0, light, 0, 0}, byte[2][i] = Four{0, 0, light, 0};
            byte[3][i] = Four{0, 0, 0, value};
        }
    }
    [[gnu::always_inline]] Four operator()(const std::uint8_t* p) const
    {
        return (byte[0][p[0]] + byte[1][p[1]]) + (byte[2][p[2]] + byte[3][p[3]]);
    }
};

const Decoder& decoder(bool srgb)
{
    static const Decoder encoded(true), plain(false);
    return srgb ? encoded : plain;
}

// log2 in single precision, by the series of the inverse hyperbolic tangent; wrong by at most 3e-7.
// @param x  at least 1, finite
float octaves(float x)
{
    constexpr std::uint32_t k_root_of_half = 0x3f3504f3, k_mantissa = 0x7fffff;
    constexpr float k_two_per_ln2 = 2.88539008f;
    // Divide by a power of two, which leaves the square root of 1/2 to that of 2.
    const std::uint32_t beyond = std::bit_cast<std::uint32_t>(x) - k_root_of_half;
    const auto rest = std::bit_cast<float>((beyond & k_mantissa) + k_root_of_half);
    const float t = (rest - 1) / (rest + 1), square = t * t;
    const float series = 1 + square * (1 / 3.0f + square * (1 / 5.0f + square * (1 / 7.0f + square * (1 / 9.0f))));
    return static_cast<float>(beyond >> 23) + k_two_per_ln2 * t * series;
}

// The two texels of `size` that enclose a coordinate, and the weight of the second; the first has 1 minus that. The
// coordinate must be finite and small enough to have a fraction.
struct Between {
    int first, second;
    float weight;
};

// std::floor without a call; |x| must fit into an int by a wide margin.
[[gnu::always_inline]] inline int whole_below(float x)
{
    const int i = static_cast<int>(x);
    return i - (static_cast<float>(i) > x);
}

[[gnu::always_inline]] inline Between between(float x, int size, Wrap wrap)
{
    if (wrap == Wrap::clamp) x = std::clamp(x, -1.0f, 2.0f);
    if (wrap == Wrap::repeat) x -= static_cast<float>(whole_below(x));
    if (wrap == Wrap::mirror) x -= static_cast<float>(2 * whole_below(0.5f * x));
    const float at = x * static_cast<float>(size) - 0.5f;
    const int low = whole_below(at);
    int i = low, j = i + 1;
    if (wrap == Wrap::repeat) {
        i = i < 0 ? i + size : std::min(i, size - 1);
        j = j >= size ? j - size : j;
    } else {
        const auto inside = [size, wrap](int k) {
            if (wrap == Wrap::mirror && k >= size) k = 2 * size - 1 - k;
            if (wrap == Wrap::mirror && k < 0) k = -1 - k;
            return std::clamp(k, 0, size - 1);
        };
        i = inside(i), j = inside(j);
    }
    return {i, std::min(j, size - 1), at - static_cast<float>(low)};
}

// The mean of several bilinear look-ups in one level, evenly spaced along the diameter.
Four mean_of_row(const Texture& texture, std::size_t level, glm::vec2 uv, const glm::vec2& diameter, int count)
{
    const Image8& image = texture.levels()[level];
    const Sampler& sampler = texture.sampler();
    const Decoder& decode = decoder(texture.srgb());
    glm::vec2 step(0);
    float weight = 1;
    if (count > 1) {
        weight = 1.0f / static_cast<float>(count);
        step = diameter * weight;
        uv -= 0.5f * static_cast<float>(count - 1) * step;
    }
    Four sum{};
    for (int i = 0; i < count; ++i, uv += step) {
        const Between x = between(uv.x, image.width, sampler.wrap_u), y = between(uv.y, image.height, sampler.wrap_v);
        const std::uint8_t *const upper = image.pixel(0, y.first), *const lower = image.pixel(0, y.second);
        const auto texel = [&](const std::uint8_t* row, int at) {
            return decode(row + 4 * static_cast<std::ptrdiff_t>(at));
        };
        const Four top = texel(upper, x.first) * (1 - x.weight) + texel(upper, x.second) * x.weight;
        const Four bottom = texel(lower, x.first) * (1 - x.weight) + texel(lower, x.second) * x.weight;
        sum += top * (1 - y.weight) + bottom * y.weight;
    }
    return sum * weight;
}

}   // namespace

glm::vec4 sample_ellipse(const Texture& texture, glm::vec2 uv, glm::vec2 diameter, glm::vec2 other)
{
    // Measure the ellipse in texels of the finest level.
    const glm::vec2 size(texture.width(), texture.height());
    const glm::vec2 along = diameter * size, across = other * size;
    const float area = std::abs(along.x * across.y - along.y * across.x);
    float square = glm::dot(along, along);
    if (const float of_other = glm::dot(across, across); of_other > square) {
        square = of_other;
        diameter = other;
    }
    const float far = std::abs(uv.x) + std::abs(uv.y);
    if (!(far < k_far && square < k_far * k_far)) return texture.sample(uv, std::sqrt(square));   // also for NaN

    // Choose the footprint of each sample, and as many samples as reach from end to end. All lengths here are
    // squared.
    constexpr float k_longest = k_stretch * k_stretch;
    float footprint = square;
    int count = 1;
    if (square > 1 && texture.levels().size() > 1) {
        footprint = area;
        if (square > k_longest * area) {
            footprint = std::max(k_longest * area * area, square * square / (k_most_samples * k_most_samples)) / square;
            const float wanted = std::sqrt(square / std::max(1.0f, footprint));
            count = static_cast<int>(
                std::clamp(std::ceil(wanted - k_no_sample_more), 1.0f, static_cast<float>(k_most_samples)));
        }
    }
    const Filter filter = footprint > 1 ? texture.sampler().minify : texture.sampler().magnify;
    if (filter == Filter::nearest) return texture.sample(uv, std::sqrt(footprint));

    // Blend the two levels whose texel sizes enclose the footprint's, unless one of them nearly equals it. Space
    // samples in the coarser level as far apart as its texels: half as many samples, or all of them if its texels have
    // the footprint's size.
    const float coarsest = static_cast<float>(texture.levels().size() - 1);
    const float lod = footprint > 1 ? std::min(0.5f * octaves(footprint), coarsest) : 0.0f;
    const auto fine = static_cast<std::size_t>(lod);
    const float beyond = lod - static_cast<float>(fine);
    const float blend = std::clamp((beyond - k_one_level) / (1 - 2 * k_one_level), 0.0f, 1.0f);
    Four sum{};
    if (blend < 1) sum = mean_of_row(texture, fine, uv, diameter, count);
    if (blend > 0) {
        const float needed = std::ceil(0.5f * (1 + beyond) * static_cast<float>(count) - k_no_sample_more);
        const Four coarse = mean_of_row(texture, fine + 1, uv, diameter, static_cast<int>(needed));
        sum = sum * (1 - blend) + coarse * blend;
    }
    return {sum[0], sum[1], sum[2], sum[3]};
}

}   // namespace gnomon::scene
