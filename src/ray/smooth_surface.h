// SPDX-License-Identifier: Apache-2.0
#pragma once
// The smooth surface that vertex normals describe, over the triangles that approximate it.
//
// Light arrives from above the plane of the interpolated normal, the smooth horizon. Where that lies below the plane of
// the triangle, rays start above the smooth surface, because the triangle would block them from its own plane
// [Hanika 2021]. Triangles of a smooth mesh then do not show at the edge of its light.

#include "ray/ray_scene.h"

namespace gnomon::ray {

/// The normal of the smooth horizon.
/// @param geometric  unit, the triangle's
/// @param smooth     unit, interpolated, on the same side. One that stands far off the other is not believed
inline glm::vec3 smooth_horizon(const glm::vec3& geometric, const glm::vec3& smooth)
{
    constexpr float k_least_cosine = 0.25f;
    return glm::dot(smooth, geometric) > k_least_cosine ? smooth : geometric;
}

/// The interpolated normal, unit, on the side of the triangle's. That is returned where there is none.
/// @param w, u, v  barycentric coordinates
glm::vec3 smooth_normal(const ObjectGeometry& geometry, std::uint32_t triangle, float w, float u, float v,
                        const glm::vec3& normal);

/// From a point of a triangle to the smooth surface above it; 0 where that is not above. @param normal  the triangle's,
/// on the side that counts
glm::vec3 smooth_lift(const ObjectGeometry& geometry, std::uint32_t triangle, float u, float v,
                      const glm::vec3& normal);

}   // namespace gnomon::ray
