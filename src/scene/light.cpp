// SPDX-License-Identifier: Apache-2.0
#include "scene/light_cone.h"

#include <algorithm>

#include "base/bits.h"
#include "scene/environment.h"
#include "scene/light_shared.h"

namespace gnomon::scene {

namespace {

constexpr float k_least_square = GNOMON_LEAST_SQUARE;   // of a squared distance; its inverse is finite
static_assert(k_most_irradiance == GNOMON_MOST_IRRADIANCE);

// Clamps irradiance to 0 ... k_most_irradiance; NaN becomes 0 because it compares false.
glm::vec3 bounded(const glm::vec3& irradiance)
{
    return glm::min(glm::vec3(k_most_irradiance), irradiance);
}

}   // namespace

bool same_reach(const Light& a, const Light& b)
{
    return a.type == b.type && a.falloff == b.falloff && a.profile == b.profile &&
           same_bits(a.inner_angle, b.inner_angle) && same_bits(a.outer_angle, b.outer_angle) &&
           same_bits(a.range, b.range);
}

LightCone cone_of(const Light& light)
{
    if (light.type != LightType::spot) return {};
    return {std::cos(light.outer_angle), std::cos(std::min(light.inner_angle, light.outer_angle))};
}

LightSample illuminate(const Light& light, const LightState& state, const glm::vec3& point)
{
    return illuminate(light, state, cone_of(light), point);
}

LightSample illuminate(const Light& light, const LightState& state, const LightCone& cone, const glm::vec3& point)
{
    LightSample sample;
    if (!state.visible) return sample;
    if (light.type == LightType::directional) {
        sample.to_light = -state.direction;
        sample.distance = k_infinity;
        sample.irradiance = bounded(light.color);
        return sample;
    }
    const glm::vec3 offset = state.position - point;
    const float square = glm::dot(offset, offset);
    if (!(square > 0)) return sample;
    sample.distance = std::sqrt(square);
    sample.to_light = offset / sample.distance;
    float strength = light.falloff == Falloff::inverse_square ? 1.0f / std::max(square, k_least_square) : 1.0f;

    // Apply the range of KHR_lights_punctual, a smooth fade-out.
    if (light.range > 0) {
        const float ratio = square / (light.range * light.range);
        const float window = std::clamp(1.0f - ratio * ratio, 0.0f, 1.0f);
        strength *= window;
    }
    if (light.type == LightType::spot) {
        const float cosine = -glm::dot(sample.to_light, state.direction);
        if (cosine <= cone.outer) return {sample.to_light, sample.distance, glm::vec3(0)};
        strength *= share_of_spot(cosine, cone, light.profile);
    }
    sample.irradiance = bounded(light.color * strength);
    return sample;
}

glm::vec3 Background::radiance(const glm::vec3& direction) const
{
    if (kind == Kind::color) return color;
    if (kind == Kind::image) return environment->radiance(direction);
    const float y = std::clamp(direction.y, -1.0f, 1.0f);
    glm::vec3 result;
    if (y >= 0) {
        // The haze at the horizon decreases quickly with elevation.
        const float t = std::pow(y, 0.5f);
        result = glm::mix(horizon, zenith, t);
    } else {
        constexpr float haze_depth = GNOMON_SKY_HAZE_DEPTH;
        result = glm::mix(horizon, ground, std::min(1.0f, -y / haze_depth));
    }
    if (sun_radiance != glm::vec3(0)) {
        const float cosine = glm::dot(direction, sun_direction);
        constexpr float disc = GNOMON_SUN_DISC, glow_power = GNOMON_SUN_GLOW_POWER, glow = GNOMON_SUN_GLOW;
        if (cosine > disc)
            result += sun_radiance;
        else if (cosine > 0)
            result += glow * horizon * std::pow(cosine, glow_power);
    }
    return result;
}

glm::vec3 Background::ambient(const glm::vec3& normal) const
{
    if (kind == Kind::color) return glm::vec3(0);
    if (kind == Kind::image) return environment->ambient(normal);
    // A surface that faces up sees only sky; one that faces the horizon sees half sky and half ground.
    const glm::vec3 sky = 0.5f * (zenith + horizon);
    const float up = 0.5f + 0.5f * std::clamp(normal.y, -1.0f, 1.0f);
    return glm::mix(ground, sky, up);
}

}   // namespace gnomon::scene
