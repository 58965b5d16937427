// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "base/image.h"

namespace gnomon {
namespace {

std::uint8_t rounded(float linear)
{
    return static_cast<std::uint8_t>(255 * srgb_from_linear(linear) + 0.5f);
}

TEST(Srgb, CodesFromTheTableAreThoseOfTheFormula)
{
    for (int i = 0; i <= 1 << 20; ++i) {
        const float linear = static_cast<float>(i) / (1 << 20);
        ASSERT_EQ(srgb8_from_linear(linear), rounded(linear)) << linear;
    }
    for (float linear = 1; linear > 1e-9f; linear *= 0.9997f)
        ASSERT_EQ(srgb8_from_linear(linear), rounded(linear)) << linear;
}

TEST(Srgb, CodesChangeWhereTheFormulasDo)
{
    for (int code = 1; code < 256; ++code) {
        const double encoded = (code - 0.5) / 255;
        const auto about =
            static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
        const auto bits = std::bit_cast<std::uint32_t>(about);
        for (std::uint32_t near = bits - 200; near <= bits + 200; ++near) {
            const float linear = std::bit_cast<float>(near);
            ASSERT_EQ(srgb8_from_linear(linear), rounded(linear)) << code << ' ' << linear;
        }
    }
}

TEST(Srgb, EveryCodeIsItsOwn)
{
    for (int code = 0; code < 256; ++code) EXPECT_EQ(srgb8_from_linear(linear_from_srgb8()[code]), code);
    EXPECT_EQ(srgb8_from_linear(-1), 0);
    EXPECT_EQ(srgb8_from_linear(7), 255);
}

}   // namespace
}   // namespace gnomon
