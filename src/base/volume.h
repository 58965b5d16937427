// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a matrix leaves of things.

#include <algorithm>
#include <cmath>

#include "base/math.h"

namespace gnomon {

// Embree asserts, in release builds too, that rays are numbers within 1.8e18, also in the space of an instance. So rays
// beyond k_largest_coordinate (scene units) meet nothing, nor do instances that magnify rays by more than
// k_largest_inverse: together they stay below 6 * 1e9 * 1e8.
inline constexpr float k_largest_coordinate = 1e9f;
inline constexpr double k_largest_inverse = 1e8;

// Rays are rounded in the space of an instance, and what is squeezed there, aslant to its axes, is met somewhere else
// than where its corners are (stray_of()): from the first on too far off for bounds and outlines, which come from
// corners, and beyond the second so far off that nothing can be said to be met.
inline constexpr double k_true_stray = 32;
inline constexpr double k_largest_stray = 1e4;

/// How many units of rounding, at most, become one on the way into a matrix's space and back [Skeel 1979]: 3 for
/// rotations after scales; for scales after rotations, three times what the longest is to the shortest.
inline double stray_of(const glm::mat4& m)
{
    const glm::dmat3 there(m), back = glm::inverse(there);
    double most = 0;
    for (int row = 0; row < 3; ++row) {
        double sum = 0;
        for (int column = 0; column < 3; ++column)
            for (int k = 0; k < 3; ++k) sum += std::abs(there[k][row]) * std::abs(back[column][k]);
        most = std::max(most, sum);
    }
    return most;
}

/// Whether it can be inverted, and rays with it. Rays are taken into the space of an instance: a matrix without an
/// inverse (a scale of 0 is a usual way of hiding things) must not reach Embree, nor a device.
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
    return stray_of(m) <= k_largest_stray;
}

}   // namespace gnomon
