// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_reach.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

namespace {

// How far from where a byte says the rays to the lights may start, in steps.
constexpr float k_inaccuracy = 2;

// A straight way: `far` times as long as `to`.
struct Way {
    glm::vec3 from, to;
    float far;
};

}   // namespace

std::uint8_t ReachSteps::encode(const glm::vec3& point, const glm::vec3& direction, float t,
                                const glm::vec3& surface) const
{
    const float steps = std::max(std::ceil(t / step_), 1.0f);
    if (!(steps < static_cast<float>(k_inexact))) return k_inexact;
    const auto reach = static_cast<std::uint8_t>(steps);
    const float off = glm::length(surface - (point + decode(reach) * direction));
    return off <= k_inaccuracy * step_ ? reach : k_inexact;
}

float farthest_reach(std::span<const std::uint8_t> reach, float radius)
{
    const std::uint8_t most = std::ranges::max(reach);
    const ReachSteps steps(radius);
    return most == ReachSteps::k_nothing_lit ? 0 : steps.decode(most) + k_inaccuracy * steps.step();
}

LightWay way_to(const scene::Light& light, const scene::LightState& at)
{
    const bool endless = light.type == scene::LightType::directional;
    return {endless, endless ? -at.direction : at.position};
}

bool meets_near_field(const Sphere& sphere, const glm::vec3& point, const LightWay& light, float radius)
{
    const glm::vec3 way = light.endless ? light.at : light.at - point;
    return meets_way({sphere.centre, sphere.radius + radius}, point, way, light.endless ? k_infinity : 1.0f);
}

bool meets_near_field(const MovingBox& box, const glm::vec3& point, const LightWay& light, float radius)
{
    const glm::vec3 way = light.endless ? light.at : light.at - point;
    return meets_way(box, point, way, light.endless ? k_infinity : 1.0f, radius);
}

NearDoubts::NearDoubts(float radius, std::span<const glm::vec3> directions) : steps_(radius), directions_(directions) {}

void NearDoubts::find(const NearReceiver& receiver, const glm::mat3& axes, std::span<const LightWay> lights,
                      const MovingSpheres& spheres, std::vector<std::uint32_t>& doubted)
{
    doubted.clear();
    // Find the lit surfaces, relative to the receiver.
    number_.clear(), x_.clear(), y_.clear(), z_.clear(), doubt_.clear();
    float farthest = 0;
    bool all_known = true;
    for (std::uint32_t i = 0; i < directions_.size(); ++i) {
        const std::uint8_t reach = receiver.reach[i];
        if (reach == ReachSteps::k_nothing_lit) continue;
        const bool known = reach != ReachSteps::k_inexact;
        const float far = steps_.decode(reach);
        const glm::vec3 to = axes * directions_[i] * far;
        number_.push_back(i), x_.push_back(to.x), y_.push_back(to.y), z_.push_back(to.z), doubt_.push_back(!known);
        farthest = std::max(farthest, far), all_known = all_known && known;
    }
    if (number_.empty()) return;
    // Find the objects that may come between some of them and the receiver or a light.
    const float margin = k_inaccuracy * steps_.step();
    const auto meets_way_to = [&](const auto& around, const LightWay& light) {
        return meets_near_field(around, receiver.origin, light, farthest + margin);
    };
    const auto meets = [&](const auto& around) {
        return std::ranges::any_of(lights, [&](const LightWay& light) { return meets_way_to(around, light); });
    };
    met_.clear();
    spheres.any(meets, [&](const Sphere& sphere, const MovingBox& box) {
        if (meets(box)) met_.push_back({sphere, box});
        return false;
    });
    if (met_.empty() && all_known) return;
    // Find which of them each may.
    for (const auto& [sphere, box] : met_) {
        const Sphere grown{sphere.centre - receiver.origin, sphere.radius + margin};
        MovingBox moved = box;
        moved.centre -= receiver.origin;
        const auto doubt_ways = [&](const auto& way_of) {
            const std::size_t count = number_.size();
            // Spheres meet few of them, and are held against all side by side.
            near_.resize(count);
            for (std::size_t k = 0; k < count; ++k) {
                const Way way = way_of(k);
                near_[k] = meets_way(grown, way.from, way.to, way.far);
            }
            for (std::size_t k = 0; k < count; ++k) {
                if (!near_[k] || doubt_[k]) continue;
                const Way way = way_of(k);
                doubt_[k] = meets_way(moved, way.from, way.to, way.far, margin);
            }
        };
        if (meets_way(moved, glm::vec3(0), glm::vec3(0), 1, farthest + margin))
            doubt_ways([&](std::size_t k) { return Way{glm::vec3(0), {x_[k], y_[k], z_[k]}, 1}; });
        for (const LightWay& light : lights) {
            if (!meets_way_to(sphere, light) || !meets_way_to(box, light)) continue;
            const glm::vec3 at = light.endless ? light.at : light.at - receiver.origin;
            doubt_ways([&](std::size_t k) {
                const glm::vec3 surface(x_[k], y_[k], z_[k]);
                return light.endless ? Way{surface, at, k_infinity} : Way{surface, at - surface, 1};
            });
        }
    }
    for (std::size_t k = 0; k < number_.size(); ++k)
        if (doubt_[k]) doubted.push_back(number_[k]);
}

}   // namespace gnomon::irradiance_cache
