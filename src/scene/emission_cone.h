// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cone within which a surface emits, as a spot with size does: in each direction, every point of the surface has
// the share of its radiance that a spot light with this profile has of its intensity (SpotProfile::smooth_cosine).

#include "scene/light_cone.h"

namespace gnomon::scene {

struct Material;

struct EmissionCone {
    glm::vec3 axis{0};   // unit; 0: there is no cone, and the radiance is the same in all directions
    LightCone cosines{};

    bool limits() const { return axis != glm::vec3(0); }
    /// The share of the radiance that leaves in a direction.
    /// @param direction  unit, away from the surface
    float share(const glm::vec3& direction) const
    {
        return limits() ? share_of_spot(glm::dot(direction, axis), cosines, SpotProfile::smooth_cosine) : 1;
    }
    friend bool operator==(const EmissionCone& a, const EmissionCone& b)
    {
        return a.axis == b.axis && a.cosines.outer == b.cosines.outer && a.cosines.inner == b.cosines.inner;
    }
};

/// The cone of a material's emission (MaterialLayers::emission_outer).
/// @param axis  the -Z of the object's space in the world; of any length
EmissionCone emission_cone(const Material& material, const glm::vec3& axis);

}   // namespace gnomon::scene
