// SPDX-License-Identifier: Apache-2.0
// Definitions that several rooms use and that must agree: Morton codes, luminance, clocks, and which points a light can
// reach.
#include <gtest/gtest.h>

#include <random>

#include "base/clocks.h"
#include "base/luminance_shared.h"
#include "base/math.h"
#include "base/morton.h"
#include "scene/light_reach.h"

namespace gnomon {
namespace {

TEST(Morton, CodesTakeBitsInTurnAndReadBack)
{
    EXPECT_EQ(morton_code(0b1011, 0b0110), 0b01101101u);
    EXPECT_EQ(morton_code(0xffffffffu, 0), 0x5555555555555555ull);
    EXPECT_EQ(morton_code(0, 0xffffffffu), 0xaaaaaaaaaaaaaaaaull);
    std::mt19937 random(1);
    for (int i = 0; i < 1000; ++i) {
        const std::uint32_t x = random() & 0xffff, y = random() & 0xffff;
        const auto code = static_cast<std::uint32_t>(morton_code(x, y));
        ASSERT_EQ(even_bits(code), x);
        ASSERT_EQ(even_bits(code >> 1), y);
    }
}

TEST(Luminance, OfWhiteIsOneInBothPrecisions)
{
    EXPECT_NEAR(luminance(glm::vec3(1)), 1, 1e-6);
    EXPECT_NEAR(luminance(glm::dvec3(1)), 1, 1e-15);
    EXPECT_EQ(luminance(glm::vec3(0, 1, 0)), 0.7152f);
    EXPECT_EQ(luminance(glm::dvec3(1, 2, 3)),
              GNOMON_LUMINANCE_RED + GNOMON_LUMINANCE_GREEN * 2 + GNOMON_LUMINANCE_BLUE * 3);
}

TEST(Clocks, CountWorkOfTheThreadAndTheProcess)
{
    const double wall = wall_ms(), cpu = cpu_ms(), thread = thread_cpu_ms();
    while (thread_cpu_ms() - thread < 2) {
    }
    EXPECT_GE(cpu_ms() - cpu, 2);
    EXPECT_GE(wall_ms() - wall, 2);
}

// Points that `illuminate` lights are never taken for dark, and well outside the cone both tests say dark.
TEST(LightReach, AgreesWithTheLightItself)
{
    scene::Light light;
    light.type = scene::LightType::spot;
    light.outer_angle = 0.5f;
    scene::LightState at;
    at.position = {0, 3, 0};
    const scene::LightReach reach(light, at);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> within(-4, 4);
    int lit = 0, dark = 0;
    for (int i = 0; i < 10000; ++i) {
        const glm::vec3 point(within(random), within(random), within(random));
        const bool black = scene::illuminate(light, at, point).irradiance == glm::vec3(0);
        const glm::vec3 to_light = reach.from(point);
        ASSERT_EQ(to_light, at.position - point);
        ASSERT_EQ(reach.dark_at(point), black);
        ASSERT_TRUE(black || !reach.outside_cone(to_light)) << i;
        (black ? dark : lit) += 1;
        const float cosine = -glm::dot(glm::normalize(to_light), at.direction);
        ASSERT_TRUE(cosine >= std::cos(0.51f) || (black && reach.outside_cone(to_light))) << i;
    }
    EXPECT_GT(lit, 100);
    EXPECT_GT(dark, 100);
}

TEST(LightReach, DirectionalLightsComeFromOneDirection)
{
    scene::Light light;
    light.type = scene::LightType::directional;
    scene::LightState at;
    const scene::LightReach reach(light, at);
    EXPECT_TRUE(reach.directional());
    EXPECT_EQ(reach.from({5, 6, 7}), glm::vec3(0, 1, 0));
    EXPECT_FALSE(reach.dark_at({5, 6, 7}));
    EXPECT_TRUE(scene::LightReach::faces({0, 1, 0}, {0.1f, 0.1f, 0}));
    EXPECT_FALSE(scene::LightReach::faces({0, 1, 0}, {1, 0, 0}));
    EXPECT_FALSE(scene::LightReach::faces({0, 1, 0}, glm::vec3(std::nanf(""))));
}

}   // namespace
}   // namespace gnomon
