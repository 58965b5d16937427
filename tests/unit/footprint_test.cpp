// SPDX-License-Identifier: Apache-2.0
// Texture lookups over elongated footprints, and their purpose: floors at grazing angles.
#include "scene/footprint.h"

#include <gtest/gtest.h>

#include "floor_scene.h"

namespace gnomon::scene {
namespace {

using test::squares;

constexpr int k_size = test::k_squares_size;

glm::vec2 texels(float u, float v)
{
    return glm::vec2(u, v) / static_cast<float>(k_size);
}

TEST(Footprint, RoundFootprintTakesOneSample)
{
    const Texture texture = squares(3, 5);
    for (const glm::vec2 uv : {glm::vec2(0.3f, 0.6f), glm::vec2(0.91f, -0.2f)}) {
        for (const float width : {0.0f, 0.5f, 1.0f, 2.0f, 8.0f, 200.0f})   // one level of the mipmap
            EXPECT_EQ(sample_ellipse(texture, uv, texels(width, 0), texels(0, width)), texture.sample(uv, width));
        for (float width = 1; width < 64; width *= 1.1f) {
            const float found = sample_ellipse(texture, uv, texels(width, 0), texels(0, width)).x;
            const float level = std::exp2(std::floor(std::log2(width)));
            const float fine = texture.sample(uv, level).x, coarse = texture.sample(uv, 2 * level).x;
            EXPECT_GE(found, std::min(fine, coarse) - 1e-6f) << width;
            EXPECT_LE(found, std::max(fine, coarse) + 1e-6f) << width;
            // Up to twice as long as wide, it equals the sample of the same area.
            const float longer = std::sqrt(2.0f) * 0.99f;
            EXPECT_NEAR(sample_ellipse(texture, uv, texels(longer * width, 0), texels(0, width / longer)).x, found,
                        1e-5f)
                << width;
        }
    }
}

// The range of values found along a line.
template <typename Sample>
float range_of(const Sample& sample)
{
    float low = 1, high = 0;
    for (float u = 0; u < 1; u += 0.003f) {
        const float value = sample(glm::vec2(u, 0.3f));
        low = std::min(low, value), high = std::max(high, value);
    }
    return high - low;
}

// Along the footprint everything is averaged; across it, details wider than the footprint are preserved.
TEST(Footprint, LongFootprintFiltersAlongItsAxisOnly)
{
    const Texture fine = squares(2, k_size), wide = squares(k_size, 16);
    for (const float length : {8.0f, 12.0f})
        for (const bool swapped : {false, true}) {
            const auto sample = [&](const Texture& texture, const glm::vec2& uv) {
                const glm::vec2 along = texels(length, 0), across = texels(0, 1);
                return sample_ellipse(texture, uv, swapped ? across : along, swapped ? along : across).x;
            };
            const float mixed = range_of([&](const glm::vec2& uv) { return sample(fine, uv); });
            EXPECT_LT(mixed, 0.1f) << length;
            // A single sample of the same area would vary here.
            const float single = range_of([&](const glm::vec2& uv) { return fine.sample(uv, std::sqrt(length)).x; });
            EXPECT_GT(single, 2 * mixed) << length;
            for (float u = 0; u < 1; u += 0.01f) {
                EXPECT_LT(sample(wide, {u, 8 / 64.0f}), 0.01f) << u;
                EXPECT_GT(sample(wide, {u, 24 / 64.0f}), 0.99f) << u;
            }
        }
}

// No discontinuity is visible where another sample is added.
TEST(Footprint, ChangesSmoothlyWithItsLength)
{
    const Texture texture = squares(5, 7);
    float before = -1;
    for (float length = 0.5f; length < 40; length *= 1.002f) {
        const float value = sample_ellipse(texture, {0.37f, 0.52f}, texels(length, 0.3f * length), texels(0, 1.3f)).x;
        if (before >= 0) {
            EXPECT_NEAR(value, before, 0.06f) << length;
        }
        before = value;
    }
}

TEST(Footprint, IsFiniteForAnySize)
{
    const Texture texture = squares(3, 5);
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float a : {0.0f, 1e-30f, 1.0f, 1e30f, inf, nan})
        for (const float b : {0.0f, 1e-30f, 1.0f, 1e30f, inf, nan})
            for (const glm::vec2 uv : {glm::vec2(0.4f), glm::vec2(nan, 1e30f)})
                EXPECT_TRUE(is_finite(glm::vec3(sample_ellipse(texture, uv, {a, b}, {b, -a}))));
}

TEST(Footprint, StepsEqualDifferencesOfCoordinates)
{
    for (const float rotation : {0.0f, 0.7f}) {
        TextureUse use;
        use.offset = {3, 4}, use.scale = {2, -0.5f}, use.rotation = rotation;
        const glm::vec2 from(0.2f, 0.7f), step(0.25f, -0.125f);
        const glm::vec2 expected = use.apply(from + step) - use.apply(from), found = apply_to_step(use, step);
        EXPECT_NEAR(found.x, expected.x, 1e-6f);
        EXPECT_NEAR(found.y, expected.y, 1e-6f);
    }
}

// One sample per pixel approximates many: no moire and no grey band near the horizon.
TEST(Footprint, OneSampleApproximatesSupersampling)
{
    const gnomon::Scene scene = test::floor_to_the_horizon();
    const auto image = [&](int samples) {
        return Renderer({.size = {160, 120},
                         .samples = samples,
                         .shadow_culling = ShadowCulling::off,
                         .indirect = Indirect::off})
            .render(scene, 1)
            .layers[0]
            .copy();
    };
    const std::vector<float> one = image(1), many = image(256);
    // From just below the horizon to the nearest squares, which are several pixels wide.
    double square = 0, mean = 0;
    std::size_t count = 0;
    for (std::size_t i = std::size_t{160} * 64 * 3; i < one.size(); ++i, ++count) {
        square += (one[i] - many[i]) * (one[i] - many[i]);
        mean += many[i];
    }
    EXPECT_LT(std::sqrt(square / count) / (mean / count), 0.15);
}

}   // namespace
}   // namespace gnomon::scene
