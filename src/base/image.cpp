// SPDX-License-Identifier: Apache-2.0
#include "base/image.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gnomon {

float srgb_from_linear(float linear)
{
    if (!(linear > 0.0f)) return 0.0f;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

namespace {

// Where the codes of 8-bit sRGB begin, and the code at the beginning of each of many equal steps from 0 to 1.
struct Codes {
    static constexpr int k_steps = 4096;
    std::array<float, 257> begin{};
    std::array<std::uint8_t, k_steps> at{};

    Codes()
    {
        const auto code = [](float linear) { return static_cast<int>(255 * srgb_from_linear(linear) + 0.5f); };
        // The bits of floats from 0 on are in their order.
        begin[0] = 0, begin[256] = std::numeric_limits<float>::infinity();
        for (int k = 1; k < 256; ++k) {
            std::uint32_t below = 0, from = std::bit_cast<std::uint32_t>(1.0f);
            while (from - below > 1) {
                const std::uint32_t middle = below + (from - below) / 2;
                (code(std::bit_cast<float>(middle)) < k ? below : from) = middle;
            }
            begin[static_cast<std::size_t>(k)] = std::bit_cast<float>(from);
        }
        for (int i = 0; i < k_steps; ++i)
            at[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(code(static_cast<float>(i) / k_steps));
    }
};

}   // namespace

std::uint8_t srgb8_from_linear(float linear)
{
    static const Codes codes;
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    std::size_t code = codes.at[static_cast<std::size_t>(linear * Codes::k_steps)];
    while (linear >= codes.begin[code + 1]) ++code;
    return static_cast<std::uint8_t>(code);
}

float linear_from_srgb(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

const float* linear_from_srgb8()
{
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values{};
        for (int i = 0; i < 256; ++i) values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
        return values;
    }();
    return table.data();
}

}   // namespace gnomon
