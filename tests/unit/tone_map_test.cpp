// SPDX-License-Identifier: Apache-2.0
#include "image/tone_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/image.h"
#include "base/random.h"

namespace gnomon::image {
namespace {

constexpr ToneMap k_all[] = {ToneMap::none, ToneMap::neutral, ToneMap::agx, ToneMap::aces};

TEST(ToneMap, IsMonotonicForGreysAndStaysInRange)
{
    for (const ToneMap curve : k_all) {
        float before = -1;
        for (float stop = -12; stop < 10; stop += 0.05f) {
            const glm::vec3 shown = tone_map(curve, glm::vec3(std::exp2(stop)));
            // The fits of AgX and ACES keep greys neutral up to the rounding of their matrices.
            EXPECT_NEAR(shown.x, shown.y, 1e-3f);
            EXPECT_NEAR(shown.x, shown.z, 1e-3f);
            EXPECT_GE(shown.y, before - 1e-6f) << "curve " << static_cast<int>(curve) << " at " << stop << " stops";
            EXPECT_LE(shown.y, 1.0f);
            before = shown.y;
        }
        EXPECT_GT(before, 0.95f) << "curve " << static_cast<int>(curve);
        EXPECT_LT(tone_map(curve, glm::vec3(0)).y, 0.5f / 255 / 12.92f) << "curve " << static_cast<int>(curve);
    }
}

TEST(ToneMap, NeutralSubtractsOnlyTheReflectionBelowTheShoulder)
{
    for (const float grey : {0.1f, 0.18f, 0.4f, 0.79f})
        EXPECT_NEAR(tone_map(ToneMap::neutral, glm::vec3(grey)).x, grey - 0.04f, 1e-6f);
    // Colour differences are preserved as well.
    const glm::vec3 shown = tone_map(ToneMap::neutral, {0.5f, 0.3f, 0.2f});
    EXPECT_NEAR(shown.x - shown.y, 0.2f, 1e-6f);
    EXPECT_NEAR(shown.y - shown.z, 0.1f, 1e-6f);
}

TEST(ToneMap, NeutralFollowsItsFormulaAboveTheShoulder)
{
    // peak 1.96 after the offset: 1 - 0.24^2 / (1.96 + 0.24 - 0.76)
    EXPECT_NEAR(tone_map(ToneMap::neutral, glm::vec3(2)).x, 1 - 0.0576f / 1.44f, 1e-6f);
}

// Greys, muted and saturated colours, dark and far too bright, computed in double precision from the published formulas
// (Khronos PBR Neutral; AgX's fit by Wrensch; ACES' fit by Hill).
TEST(ToneMap, EqualsTabulatedColours)
{
    struct Row {
        glm::vec3 linear, neutral, agx, aces;
    };
    constexpr Row k_rows[] = {
        {{0.18f, 0.18f, 0.18f}, {0.14f, 0.14f, 0.14f}, {0.21447f, 0.21453f, 0.21454f}, {0.10559f, 0.10559f, 0.10559f}},
        {{0.5f, 0.3f, 0.2f}, {0.46f, 0.26f, 0.16f}, {0.43375f, 0.31392f, 0.23827f}, {0.36772f, 0.21701f, 0.13617f}},
        {{2, 0.5f, 0.1f}, {0.96f, 0.32114f, 0.15077f}, {0.80729f, 0.44962f, 0.21069f}, {0.9015f, 0.41869f, 0.105f}},
        {{0.05f, 0.4f, 8},
         {0.50824f, 0.52955f, 0.99226f},
         {0.46599f, 0.56235f, 0.9901f},
         {0.39692f, 0.36087f, 0.99737f}},
        {{0.01f, 0.02f, 0.03f},
         {0.00063f, 0.01063f, 0.02062f},
         {0.00651f, 0.01841f, 0.0328f},
         {0.00108f, 0.00319f, 0.00572f}},
        {{20, 15, 1}, {0.99704f, 0.93207f, 0.75017f}, {1, 1, 0.78706f}, {1, 0.98869f, 0.88306f}}};
    for (const Row& row : k_rows)
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(tone_map(ToneMap::neutral, row.linear)[c], row.neutral[c], 2e-5f) << row.linear[0] << c;
            EXPECT_NEAR(tone_map(ToneMap::agx, row.linear)[c], row.agx[c], 2e-5f) << row.linear[0] << c;
            EXPECT_NEAR(tone_map(ToneMap::aces, row.linear)[c], row.aces[c], 2e-5f) << row.linear[0] << c;
        }
}

TEST(ToneMap, SurvivesNonFiniteColours)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const ToneMap curve : k_all) {
        for (const float value : {nan, -1.0f, k_infinity, -k_infinity, 1e38f}) {
            const glm::vec3 shown = tone_map(curve, {value, 0.5f, value});
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(shown[c], 0.0f);
                EXPECT_LE(shown[c], 1.0f);
            }
        }
    }
}

TEST(AutoExposure, MapsGreyToMiddleGrey)
{
    for (const float light : {1e-5f, 0.18f, 3.0f, 2e4f}) {
        const std::vector<float> rgb(3 * 1000, light);
        const auto factor = static_cast<float>(std::exp2(auto_exposure(rgb)));
        EXPECT_NEAR(tone_map(ToneMap::neutral, glm::vec3(light * factor)).x, 0.18f, 0.035f) << light;
    }
}

TEST(AutoExposure, IgnoresUnlitPixelsAndFewBrightOnes)
{
    std::vector<float> rgb(3 * 1000, 0.25f);
    const double alone = auto_exposure(rgb);
    rgb.insert(rgb.end(), 3 * 5000, 0.0f);
    EXPECT_EQ(auto_exposure(rgb), alone);
    for (int i = 0; i < 3 * 10; ++i) rgb[static_cast<std::size_t>(i)] = 1e5f;
    EXPECT_NEAR(auto_exposure(rgb), alone, 0.01);
}

TEST(AutoExposure, DoesNotDependOnPixelPositions)
{
    Random random(7);
    std::vector<float> rgb;
    for (int i = 0; i < 3 * 4096; ++i) rgb.push_back(random.uniform(0, 4));
    const double forward = auto_exposure(rgb);
    std::vector<float> turned;
    for (std::size_t i = rgb.size(); i > 0; i -= 3)
        turned.insert(turned.end(), rgb.begin() + static_cast<std::ptrdiff_t>(i) - 3,
                      rgb.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_EQ(auto_exposure(turned), forward);
}

TEST(AutoExposure, IsFiniteForExtremes)
{
    EXPECT_EQ(auto_exposure({}), 0.0);
    EXPECT_EQ(auto_exposure(std::vector<float>(300, 0.0f)), 0.0);
    for (const float value : {1e-38f, k_infinity, 1e38f}) {
        const double stops = auto_exposure(std::vector<float>(300, value));
        EXPECT_TRUE(std::abs(stops) <= 20.0) << value << " gives " << stops;
    }
}

TEST(EncodeSrgb8, RoundsExactly)
{
    Random random(3);
    std::vector<float> rgb;
    for (int i = 0; i < 3 * 20000; ++i) rgb.push_back(random.uniform(-0.05f, 1.1f));
    for (int i = 0; i < 256; ++i) rgb.insert(rgb.end(), 3, linear_from_srgb8()[i]);
    std::vector<std::uint8_t> bytes(rgb.size());
    encode_srgb8(rgb, 0, ToneMap::none, bytes);
    int off = 0;
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        const long expected = std::lround(255.0f * srgb_from_linear(std::clamp(rgb[i], 0.0f, 1.0f)));
        // The two roundings may differ at a tie in the last bit of a float.
        ASSERT_LE(std::abs(expected - bytes[i]), 1) << rgb[i];
        off += expected != bytes[i];
    }
    EXPECT_LE(off, 2);
    for (int i = 0; i < 256; ++i) EXPECT_EQ(bytes[bytes.size() - 3 * 256 + 3 * static_cast<std::size_t>(i)], i);
}

TEST(EncodeSrgb8, ExposureIsInStops)
{
    const std::vector<float> rgb{0.1f, 0.1f, 0.1f}, twice{0.2f, 0.2f, 0.2f};
    std::vector<std::uint8_t> a(3), b(3);
    encode_srgb8(rgb, 1, ToneMap::agx, a);
    encode_srgb8(twice, 0, ToneMap::agx, b);
    EXPECT_EQ(a, b);
}

}   // namespace
}   // namespace gnomon::image
