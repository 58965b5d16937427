// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which points a light cannot reach whatever stands between: those that face away from it, and those outside its cone
// or range. No visibility test is needed for them.
//
// Every shadow pass (traced, certified, measured) decides with these tests, so that all of them cast or save the same
// rays.

#include <cmath>

#include "scene/light.h"

namespace gnomon::scene {

/// A light in one frame, with the tests of its points.
class LightReach {
 public:
    LightReach(const Light& light, const LightState& state)
        : light_(&light),
          state_(&state),
          directional_(light.type == LightType::directional),
          bounded_(light.type == LightType::spot || light.range > 0),
          place_(directional_ ? -state.direction : state.position)
    {
        if (light.type == LightType::spot) outer_cosine_ = std::cos(light.outer_angle);
    }

    bool directional() const { return directional_; }
    /// The light's position, or the direction towards it if it is directional.
    const glm::vec3& place() const { return place_; }
    /// From a point to the light; of a directional light a unit vector.
    glm::vec3 from(const glm::vec3& point) const { return directional_ ? place_ : place_ - point; }

    /// Whether a surface with this normal is turned towards the light; not for NaN.
    static bool faces(const glm::vec3& to_light, const glm::vec3& normal) { return glm::dot(to_light, normal) > 0; }
    /// Outside the cone or range: what `illuminate` gives there is black.
    bool dark_at(const glm::vec3& point) const
    {
        return bounded_ && illuminate(*light_, *state_, point).irradiance == glm::vec3(0);
    }
    /// Certainly outside a spot's cone, without evaluating the light: with a small margin, since `illuminate` decides
    /// at the very edge.
    bool outside_cone(const glm::vec3& to_light) const
    {
        constexpr float k_edge = 1e-4f;
        if (outer_cosine_ < -1) return false;
        return -glm::dot(to_light, state_->direction) < (outer_cosine_ - k_edge) * glm::length(to_light);
    }

 private:
    const Light* light_;
    const LightState* state_;
    bool directional_;
    bool bounded_;   // by a cone or a range: may leave a point that faces it dark
    glm::vec3 place_;
    float outer_cosine_ = -2;   // of a spot's cone; below -1: no spot
};

}   // namespace gnomon::scene
