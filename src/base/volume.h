// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a matrix leaves of things.

#include "base/math.h"

namespace gnomon {

// Embree asserts, in release builds too, that rays are numbers within 1.8e18, also in the space of an instance. So rays
// beyond k_largest_coordinate (scene units) meet nothing, nor do instances that magnify rays by more than
// k_largest_inverse: together they stay below 6 * 1e9 * 1e8.
inline constexpr float k_largest_coordinate = 1e9f;
inline constexpr double k_largest_inverse = 1e8;

/// Whether it can be inverted. Rays are taken into the space of an instance: a matrix without an inverse (a scale of 0
/// is a usual way of hiding things) must not reach Embree, nor a device.
inline bool has_volume(const glm::mat4& m)
{
    // The determinant in float, since Embree inverts in float.
    if (!std::isnormal(glm::determinant(glm::mat3(m)))) return false;
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(m));
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) {
            if (!(std::abs(m[column][row]) <= k_largest_coordinate)) return false;
            if (column < 3 && !(std::abs(inverse[column][row]) <= k_largest_inverse)) return false;
        }
    return true;
}

}   // namespace gnomon
