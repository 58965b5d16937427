// SPDX-License-Identifier: Apache-2.0
// The elementary functions that replace the C library's.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "base/hash.h"
#include "base/random.h"

namespace gnomon::test {
namespace {

constexpr double k_inf = std::numeric_limits<double>::infinity();

// Arguments that the compiler cannot see, so that it does not compute the result itself.
template <class T>
T hidden(T x)
{
    volatile T v = x;
    return v;
}

struct Function {
    const char* name;
    std::function<double(double)> of;
    std::function<float(float)> of_float;
    std::function<long double(long double)> truth;   // the C library's, with 64 bits, whose symbols are not replaced
    double low, high;
};

std::vector<Function> functions()
{
#define GNOMON_FUNCTION(name, low, high)                                                                               \
    {                                                                                                                  \
#name,                                                                                                         \
            [](double x) { return std::name(x); },                                                                     \
                                                [](float                                                               \
                                                       x) { return std::name(x); },                                    \
                                                                                 [](long double                        \
                                                                                        x) { return std::name(x); },   \
                                                                                                                  low, \
                                                                                                                  high \
    }
    return {GNOMON_FUNCTION(sin, -30, 30),   GNOMON_FUNCTION(cos, -30, 30),    GNOMON_FUNCTION(tan, -30, 30),
            GNOMON_FUNCTION(exp, -80, 80),   GNOMON_FUNCTION(exp2, -100, 100), GNOMON_FUNCTION(log, 1e-9, 20),
            GNOMON_FUNCTION(log2, 1e-9, 20), GNOMON_FUNCTION(log10, 1e-9, 20), GNOMON_FUNCTION(acos, -1, 1),
            GNOMON_FUNCTION(asin, -1, 1),    GNOMON_FUNCTION(atan, -20, 20),   GNOMON_FUNCTION(cbrt, -20, 20)};
#undef GNOMON_FUNCTION
}

TEST(Elementary, NearlyAllResultsAreCorrectlyRounded)
{
    constexpr int k_count = 20000;
    for (const Function& f : functions()) {
        Random random(7);
        int wrong = 0, wrong_floats = 0;
        for (int i = 0; i < k_count; ++i) {
            const double x = f.low + (f.high - f.low) * static_cast<double>(random.uniform(0, 1));
            wrong += f.of(x) != static_cast<double>(f.truth(x));
            const auto single = static_cast<float>(x);
            wrong_floats += f.of_float(single) != static_cast<float>(f.truth(single));
        }
        // The truth itself is rounded twice.
        EXPECT_LE(wrong, k_count / 500) << f.name;
        EXPECT_LE(wrong_floats, 2) << f.name;
    }
}

TEST(Elementary, PowersAndAnglesAreCorrectlyRounded)
{
    constexpr int k_count = 20000;
    Random random(9);
    int powers = 0, angles = 0, float_powers = 0, float_angles = 0;
    for (int i = 0; i < k_count; ++i) {
        const float x = random.uniform(0, 10), y = random.uniform(-10, 10), z = random.uniform(-10, 10);
        const double a = static_cast<double>(x) * 1.0000001, b = static_cast<double>(y) * 0.9999999;
        powers +=
            std::pow(a, b) != static_cast<double>(std::pow(static_cast<long double>(a), static_cast<long double>(b)));
        float_powers +=
            std::pow(x, y) != static_cast<float>(std::pow(static_cast<long double>(x), static_cast<long double>(y)));
        angles += std::atan2(b, static_cast<double>(z)) !=
                  static_cast<double>(std::atan2(static_cast<long double>(b), static_cast<long double>(z)));
        float_angles += std::atan2(y, z) !=
                        static_cast<float>(std::atan2(static_cast<long double>(y), static_cast<long double>(z)));
    }
    EXPECT_LE(powers, k_count / 500);
    EXPECT_LE(angles, k_count / 500);
    EXPECT_LE(float_powers, 2);
    EXPECT_LE(float_angles, 2);
}

// These take a shorter way.
TEST(Elementary, FlatAnglesAreCorrectlyRounded)
{
    constexpr int k_count = 50000;
    Random random(10);
    int wrong = 0;
    for (int i = 0; i < k_count; ++i) {
        const double x = 0.5 + static_cast<double>(random.uniform(0, 1)) * 1.0000001;
        const double y = x * std::ldexp(static_cast<double>(random.uniform(0.5f, 1)) * 0.9999999, -5 - i % 40);
        const auto truth = static_cast<double>(std::atan2(static_cast<long double>(y), static_cast<long double>(x)));
        wrong += std::atan2(y, x) != truth || std::atan2(-y, x) != -truth;
    }
    EXPECT_LE(wrong, k_count / 500);
}

TEST(Elementary, SpecialValuesAreThoseOfTheStandard)
{
    const double zero = hidden(0.0), one = hidden(1.0), inf = hidden(k_inf), nan = hidden(std::nan(""));
    EXPECT_TRUE(std::signbit(std::sin(-zero)) && std::signbit(std::tan(-zero)) && std::signbit(std::atan(-zero)));
    EXPECT_EQ(std::cos(zero), 1);
    for (const double x : {inf, -inf, nan}) EXPECT_TRUE(std::isnan(std::sin(x)) && std::isnan(std::cos(x)));
    EXPECT_EQ(std::exp(-inf), 0);
    EXPECT_EQ(std::exp(inf), k_inf);
    EXPECT_EQ(std::exp(hidden(-746.0)), 0);
    EXPECT_EQ(std::exp(hidden(710.0)), k_inf);
    EXPECT_EQ(std::exp2(hidden(-1074.0)), std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(std::log(zero), -k_inf);
    for (const double x : {std::log(inf), std::log2(inf), std::log10(inf)}) EXPECT_EQ(x, k_inf);
    EXPECT_TRUE(std::isnan(std::log(nan)) && std::isnan(std::log2(nan)) && std::isnan(std::log10(nan)));
    EXPECT_TRUE(std::isnan(std::log(-one)) && std::isnan(std::acos(hidden(1.5))) &&
                std::isnan(std::asin(hidden(-2.0))));
    EXPECT_EQ(std::log2(hidden(8.0)), 3);
    EXPECT_EQ(std::log10(hidden(1000.0)), 3);
    EXPECT_EQ(std::acos(one), 0);
    EXPECT_EQ(std::atan2(zero, -one), std::acos(-one));
    EXPECT_EQ(std::atan2(-zero, -one), -std::acos(-one));
    EXPECT_EQ(std::atan2(one, zero), std::asin(one));
    EXPECT_EQ(std::pow(nan, zero), 1);
    EXPECT_EQ(std::pow(-hidden(2.0), hidden(3.0)), -8);
    EXPECT_EQ(std::pow(zero, -one), k_inf);
    EXPECT_EQ(std::pow(-zero, -one), -k_inf);
    EXPECT_EQ(std::pow(hidden(10.0), hidden(15.0)), 1e15);
    EXPECT_TRUE(std::isnan(std::pow(-one, hidden(0.5))));
    EXPECT_EQ(std::cbrt(hidden(-27.0)), -3);
}

// The bits of the results, which must be these on every processor and in every build.
TEST(Elementary, ResultsAreTheseBits)
{
    std::uint64_t hash = hash_bytes(nullptr, 0);
    const auto add = [&](auto value) { hash = hash_bytes(&value, sizeof value, hash); };
    for (const Function& f : functions()) {
        Random random(3);
        for (int i = 0; i < 5000; ++i) {
            const double x = f.low + (f.high - f.low) * static_cast<double>(random.uniform(0, 1));
            add(f.of(x)), add(f.of_float(static_cast<float>(x)));
        }
    }
    Random random(5);
    for (int i = 0; i < 5000; ++i) {
        const float x = random.uniform(0, 10), y = random.uniform(-10, 10);
        add(std::pow(x, y)), add(std::pow(static_cast<double>(x), static_cast<double>(y)));
        add(std::atan2(y, x)), add(std::atan2(static_cast<double>(y), static_cast<double>(x)));
    }
    EXPECT_EQ(hash, 0xb3e8d8c32619790bu);
}

}   // namespace
}   // namespace gnomon::test
