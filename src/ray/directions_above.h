// SPDX-License-Identifier: Apache-2.0
#pragma once
// Directions in which a place on a surface looks for what is close to it.

#include <array>

#include "base/math.h"

namespace gnomon::ray {

/// Five unit vectors: the normal, and four around it whose cosine to it is 0.6.
/// @param normal  unit
inline std::array<glm::vec3, 5> directions_above(const glm::vec3& normal)
{
    constexpr float k_up = 0.6f, k_aside = 0.8f;
    glm::vec3 t, b;
    make_basis(normal, t, b);
    const glm::vec3 up = k_up * normal;
    return {normal, up + k_aside * t, up - k_aside * t, up + k_aside * b, up - k_aside * b};
}

}   // namespace gnomon::ray
