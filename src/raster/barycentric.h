// SPDX-License-Identifier: Apache-2.0
#pragma once
// Barycentric coordinates of points that were read back from the device.

#include <algorithm>

#include "base/math.h"

namespace gnomon::raster {

/// The coordinates (of p[1] and p[2]) of a point of a triangle, 0 to 1; 0 for a triangle without area.
inline glm::vec2 barycentric(const glm::vec3 (&p)[3], const glm::vec3& at)
{
    const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], c = at - p[0];
    const float aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
    const float determinant = aa * bb - ab * ab;
    if (!(determinant > 0)) return glm::vec2(0);
    const float u = (glm::dot(a, c) * bb - glm::dot(b, c) * ab) / determinant;
    const float v = (glm::dot(b, c) * aa - glm::dot(a, c) * ab) / determinant;
    return glm::clamp(glm::vec2(u, v), 0.0f, 1.0f);
}

/// The point of a triangle with these coordinates. The rasteriser may fill a pixel whose ray just misses the triangle;
/// what is computed from its plane may then lie below a neighbour, where no light arrives.
inline glm::vec3 point_of(const glm::vec3 (&p)[3], const glm::vec2& at)
{
    const glm::vec2 inside = at / std::max(at.x + at.y, 1.0f);
    return (1 - inside.x - inside.y) * p[0] + inside.x * p[1] + inside.y * p[2];
}

}   // namespace gnomon::raster
