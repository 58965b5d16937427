// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of a spot for many points: illuminate() (light.h) without finding the cosines of its angles each time.

#include <algorithm>

#include "scene/light.h"

namespace gnomon::scene {

/// The cosines of a light's two angles.
struct LightCone {
    float outer = -1, inner = -1;
};
LightCone cone_of(const Light& light);

/// The share of a spot's intensity along its axis that it has in a direction.
/// @param cosine  of the angle between the direction and the axis
inline float share_of_spot(float cosine, const LightCone& cone, SpotProfile profile)
{
    if (cosine <= cone.outer) return 0;
    if (profile == SpotProfile::cosine) return cosine;
    // Apply the angular attenuation of KHR_lights_punctual.
    const float fade = std::clamp((cosine - cone.outer) / std::max(cone.inner - cone.outer, 1e-4f), 0.0f, 1.0f);
    return profile == SpotProfile::smooth ? fade * fade : cosine * fade * fade * (3.0f - 2.0f * fade);
}

/// The same as illuminate() without a cone. @param cone  cone_of() the light
LightSample illuminate(const Light& light, const LightState& state, const LightCone& cone, const glm::vec3& point);

}   // namespace gnomon::scene
