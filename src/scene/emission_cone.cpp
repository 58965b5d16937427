// SPDX-License-Identifier: Apache-2.0
#include "scene/emission_cone.h"

#include <cmath>

#include "scene/material.h"
#include "scene/material_layers.h"

namespace gnomon::scene {

EmissionCone emission_cone(const Material& material, const glm::vec3& axis)
{
    EmissionCone cone;
    if (!material.layers || !(material.layers->emission_outer > 0)) return cone;
    const float square = glm::dot(axis, axis);
    cone.axis = square > 0 && std::isfinite(square) ? axis / std::sqrt(square) : glm::vec3(0, 0, -1);
    cone.cosines = {std::cos(material.layers->emission_outer),
                    std::cos(std::min(material.layers->emission_inner, material.layers->emission_outer))};
    return cone;
}

}   // namespace gnomon::scene
