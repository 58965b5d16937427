// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of a spot for many points: illuminate() (light.h) without finding the cosines of its angles each time.

#include "scene/light.h"

namespace gnomon::scene {

/// The cosines of a light's two angles.
struct LightCone {
    float outer = -1, inner = -1;
};
LightCone cone_of(const Light& light);

/// The same as illuminate() without a cone. @param cone  cone_of() the light
LightSample illuminate(const Light& light, const LightState& state, const LightCone& cone, const glm::vec3& point);

}   // namespace gnomon::scene
