// SPDX-License-Identifier: Apache-2.0
// Half precision: exact both ways for all halves, and rounded to the nearest, ties to even, between them.
#include "base/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace gnomon {
namespace {

constexpr std::uint32_t k_infinite = 0x7c00;

// The value of a half by its definition; of finite ones.
double value_of(std::uint32_t half)
{
    const int exponent = static_cast<int>(half >> 10 & 0x1f), fraction = static_cast<int>(half & 0x3ff);
    const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
    return half & 0x8000 ? -size : size;
}

TEST(Half, RoundTripOfAll65536)
{
    for (std::uint32_t half = 0; half < 65536; ++half) {
        const float value = float_from_half(static_cast<std::uint16_t>(half));
        if ((half & 0x7fff) > k_infinite) {
            EXPECT_TRUE(std::isnan(value)) << half;
            EXPECT_EQ(half_from_float(value) & ~0x200u, half & ~0x200u) << half;   // the quiet bit may be set
            continue;
        }
        constexpr float infinity = std::numeric_limits<float>::infinity();
        if ((half & 0x7fff) == k_infinite) {
            EXPECT_EQ(value, half & 0x8000 ? -infinity : infinity);
        } else {
            EXPECT_EQ(static_cast<double>(value), value_of(half)) << half;
        }
        EXPECT_EQ(std::signbit(value), half >= 0x8000) << half;
        EXPECT_EQ(half_from_float(value), half);
    }
}

// Between each two neighbouring halves: their mean goes to the even one, and the floats beside the mean to the nearest.
TEST(Half, RoundsToNearestTiesToEven)
{
    for (std::uint32_t low = 0; low < k_infinite; ++low) {
        const std::uint32_t high = low + 1;
        const double above = high == k_infinite ? 65536 : value_of(high);
        const auto tie = static_cast<float>((value_of(low) + above) / 2);
        ASSERT_EQ(static_cast<double>(tie), (value_of(low) + above) / 2);
        EXPECT_EQ(half_from_float(tie), low % 2 == 0 ? low : high) << low;
        EXPECT_EQ(half_from_float(std::nextafter(tie, 0.0f)), low) << low;
        EXPECT_EQ(half_from_float(std::nextafter(tie, 1e9f)), high) << low;
        EXPECT_EQ(half_from_float(-tie), 0x8000u | (low % 2 == 0 ? low : high)) << low;
    }
    for (const float large : {65520.0f, 65535.0f, 65536.0f, 1e30f, std::numeric_limits<float>::max()})
        EXPECT_EQ(half_from_float(large), k_infinite) << large;
    EXPECT_EQ(half_from_float(65519.99f), 0x7bff);
    for (const float tiny : {0x1p-26f, 0x1p-149f, 0x1p-126f}) EXPECT_EQ(half_from_float(-tiny), 0x8000) << tiny;
}

TEST(Half, RandomBitsRoundToTheNearest)
{
    Random random(1);
    for (int i = 0; i < 200'000; ++i) {
        const std::uint32_t exponent = 127 - 30 + random.below(50);
        const float value = std::bit_cast<float>(exponent << 23 | random.below(1u << 23));
        const std::uint32_t half = half_from_float(value);
        if (half == k_infinite) {
            EXPECT_GE(value, 65520.0f);
            continue;
        }
        const double error = std::abs(value_of(half) - static_cast<double>(value));
        if (half > 0) {
            EXPECT_LE(error, std::abs(value_of(half - 1) - static_cast<double>(value)));
        }
        if (half + 1 < k_infinite) {
            EXPECT_LE(error, std::abs(value_of(half + 1) - static_cast<double>(value)));
        }
    }
}

}   // namespace
}   // namespace gnomon
