// SPDX-License-Identifier: Apache-2.0
#include "reference/light_emission.h"

#include <algorithm>

#include "ray/origin.h"
#include "reference/sample_pattern.h"

namespace gnomon::reference {

namespace {

constexpr auto k_float_pi = static_cast<float>(k_pi);
// A light without falloff is weighed as if all it lights were this far away, as a fraction of the scene's diagonal.
constexpr double k_middle = 0.25;

// The solid angle of a cone.
float cone(float least_cosine)
{
    return 2 * k_float_pi * (1 - least_cosine);
}

}   // namespace

LightEmission::LightEmission(const scene::SceneState& state, const ray::RayScene& rays,
                             std::span<const scene::LightId> lights)
    : state_(state), lights_(lights.begin(), lights.end())
{
    const scene::Scene& scene = state.scene();
    const double middle = k_middle * static_cast<double>(rays.bounds().diagonal());
    nearest_ = static_cast<float>(middle) * (1 - ray::k_shadow_ray_end);
    for (const scene::LightId l : lights) {
        const scene::Light& light = scene.lights[l];
        least_cosine_.push_back(light.type == scene::LightType::spot ? std::cos(light.outer_angle) : -1.0f);
        double power = static_cast<double>(luminance(light.color)) * static_cast<double>(cone(least_cosine_.back()));
        if (light.falloff == scene::Falloff::constant) power *= middle * middle;
        if (light.type == scene::LightType::directional || !std::isfinite(power)) power = 0;
        total_ += power;
        sums_.push_back(total_);
    }
}

EmittedRay LightEmission::sample(float choice, const glm::vec2& direction) const
{
    EmittedRay ray;
    const double wanted = static_cast<double>(choice) * total_;
    const auto at = std::min<std::ptrdiff_t>(std::upper_bound(sums_.begin(), sums_.end(), wanted) - sums_.begin(),
                                             static_cast<std::ptrdiff_t>(sums_.size()) - 1);
    ray.light = static_cast<std::size_t>(at);
    const scene::LightState& light = state_.light(lights_[ray.light]);
    // A cosine distribution around +Z is uniform in the height's square: stretch that to the cone's heights.
    const glm::vec3 around = cosine_direction({0, 0, 1}, direction.x, direction.y);
    const float radius_square = around.x * around.x + around.y * around.y;
    const float cosine = 1 - radius_square * (1 - least_cosine_[ray.light]);
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    const float stretch = radius_square > 0 ? sine / std::sqrt(radius_square) : 0;
    glm::vec3 across, up;
    make_basis(light.direction, across, up);
    ray.origin = light.position;
    ray.direction = stretch * around.x * across + stretch * around.y * up + cosine * light.direction;
    return ray;
}

float LightEmission::density(std::size_t light, const glm::vec3& direction) const
{
    const double power = sums_[light] - (light > 0 ? sums_[light - 1] : 0);
    const float least = least_cosine_[light];
    if (!(power > 0) || !(least < 1)) return 0;
    if (least > -1 && glm::dot(direction, state_.light(lights_[light]).direction) < least) return 0;
    return static_cast<float>(power / total_) / cone(least);
}

}   // namespace gnomon::reference
