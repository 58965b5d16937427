// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ray-triangle intersection by signed volumes over the edges [Davidovic et al. 2012, '3D Rasterization: A Bridge
// Between Rasterization and Ray Casting', 2].
//
// Watertight where two triangles share an edge to the bit, because both compute the same volume with opposite signs.

#include <algorithm>

#include "base/math.h"
#include "ray/limits_shared.h"

namespace gnomon::ray {

struct TriangleHit {
    float t = 0, u = 0, v = 0;   // at (1-u-v) p0 + u p1 + v p2
    bool behind = false;         // hit from the side on which the corners run clockwise
};

// Volumes up to this fraction of their sum count as 0, so that a ray at an edge hits both triangles.
inline constexpr float k_edge_slack = GNOMON_EDGE_SLACK;
static_assert(k_edge_slack == 0x1p-23f);

/// @return whether the ray hits the triangle, from either side, at a distance in (tnear, tfar]
inline bool meets(const glm::vec3& origin, const glm::vec3& direction, float tnear, float tfar, const glm::vec3 (&p)[3],
                  TriangleHit& hit)
{
    const glm::vec3 p0 = p[0] - origin, p1 = p[1] - origin, p2 = p[2] - origin;
    const glm::vec3 e0 = p2 - p0, e1 = p0 - p1, e2 = p1 - p2;
    const float u = glm::dot(glm::cross(e0, p2 + p0), direction);
    const float v = glm::dot(glm::cross(e1, p0 + p1), direction);
    const float w = glm::dot(glm::cross(e2, p1 + p2), direction);
    const float sum = u + v + w;
    const float slack = k_edge_slack * std::abs(sum);
    if (!(std::min({u, v, w}) >= -slack || std::max({u, v, w}) <= slack)) return false;

    const glm::vec3 normal = glm::cross(e2, e0);
    const float slope = glm::dot(normal, direction);
    if (slope == 0 || sum == 0) return false;
    const float t = glm::dot(p0, normal) / slope;
    if (!(t > tnear && t <= tfar)) return false;
    hit = {t, u / sum, v / sum, slope > 0};
    return true;
}

}   // namespace gnomon::ray
