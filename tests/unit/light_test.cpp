// SPDX-License-Identifier: Apache-2.0
#include "scene/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon::scene {
namespace {

LightState above(float height)
{
    LightState state;
    state.position = {0, height, 0}, state.direction = {0, -1, 0};
    return state;
}

float irradiance(const Light& light, const LightState& state, const glm::vec3& point)
{
    return illuminate(light, state, point).irradiance.x;
}

TEST(Illuminate, FallsWithTheSquareOfTheDistanceOrNotAtAll)
{
    Light light;
    light.color = glm::vec3(8);
    EXPECT_FLOAT_EQ(irradiance(light, above(2), {0, 0, 0}), 2);
    EXPECT_FLOAT_EQ(irradiance(light, above(4), {0, 0, 3}), 8.0f / 25);
    light.falloff = Falloff::constant;
    EXPECT_FLOAT_EQ(irradiance(light, above(4), {0, 0, 3}), 8);
}

// KHR_lights_punctual: 1 - (distance / range)^4, between 0 and 1, over the square of the distance.
TEST(Illuminate, FadesOutTowardsItsRange)
{
    Light light;
    light.range = 4;
    for (const float distance : {0.5f, 1.0f, 2.0f, 3.0f, 3.9f})
        EXPECT_NEAR(irradiance(light, above(distance), {0, 0, 0}),
                    (1 - std::pow(distance / 4, 4.0f)) / (distance * distance), 1e-6f)
            << distance;
    EXPECT_EQ(irradiance(light, above(4), {0, 0, 0}), 0);
    EXPECT_EQ(irradiance(light, above(5), {0, 0, 0}), 0);
}

// KHR_lights_punctual: the square of how far the cosine is between those of the two angles.
TEST(Illuminate, SpotsFadeBetweenTheirAngles)
{
    Light light;
    light.type = LightType::spot;
    light.falloff = Falloff::constant;
    light.inner_angle = 0.3f, light.outer_angle = 0.8f;
    const auto at_angle = [&](float angle) { return irradiance(light, above(1), {std::tan(angle), 0, 0}); };
    EXPECT_FLOAT_EQ(at_angle(0), 1);
    EXPECT_FLOAT_EQ(at_angle(0.29f), 1);
    for (const float angle : {0.4f, 0.55f, 0.7f}) {
        const float fade = (std::cos(angle) - std::cos(0.8f)) / (std::cos(0.3f) - std::cos(0.8f));
        EXPECT_NEAR(at_angle(angle), fade * fade, 1e-5f) << angle;
    }
    EXPECT_EQ(at_angle(0.81f), 0);
    light.profile = SpotProfile::cosine;
    EXPECT_NEAR(at_angle(0.55f), std::cos(0.55f), 1e-6f);
    EXPECT_EQ(at_angle(0.81f), 0);
    light.profile = SpotProfile::smooth_cosine;
    for (const float angle : {0.1f, 0.4f, 0.7f}) {
        const float fade = std::min(1.0f, (std::cos(angle) - std::cos(0.8f)) / (std::cos(0.3f) - std::cos(0.8f)));
        EXPECT_NEAR(at_angle(angle), std::cos(angle) * fade * fade * (3 - 2 * fade), 1e-5f) << angle;
    }
}

}   // namespace
}   // namespace gnomon::scene
