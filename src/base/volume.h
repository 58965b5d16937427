// SPDX-License-Identifier: Apache-2.0
#pragma once
// Limits on the matrices of instances: whether a matrix can be inverted, and how much precision rays lose in its space.

#include <algorithm>
#include <cmath>

#include "base/math.h"

namespace gnomon {

// Embree asserts, in release builds too, that rays are numbers within 1.8e18, also in the space of an instance. So rays
// beyond k_largest_coordinate (scene units) hit nothing, and instances that magnify rays by more than k_largest_inverse
// are ignored: together, coordinates stay below 6 * 1e9 * 1e8.
inline constexpr float k_largest_coordinate = 1e9f;
inline constexpr double k_largest_inverse = 1e8;

// Limits of the error amplification of a matrix, stray_of(). Rays are rounded in the space of an instance, so in a
// sheared and flattened instance their hits are displaced from its transformed corners. Above the first limit, the
// displacement is too large for bounds and outlines, which are computed from corners. Above the second, hits are
// meaningless.
inline constexpr double k_true_stray = 32;
inline constexpr double k_largest_stray = 1e4;

/// Error amplification of a transformation into a matrix's space and back, in units of rounding [Skeel 1979]: at most 3
/// for rotations after scales; for scales after rotations, three times the ratio of the largest scale to the smallest.
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

/// Whether the matrix can be inverted with enough precision for rays. Rays are transformed into the space of an
/// instance, so a singular matrix (a scale of 0 is a common way to hide objects) must not reach Embree or a device.
inline bool has_volume(const glm::mat4& m)
{
    // Compute the determinant in float, because Embree inverts in float.
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
