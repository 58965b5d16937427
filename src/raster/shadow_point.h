// SPDX-License-Identifier: Apache-2.0
#pragma once
// The points at which the host finds the visibility of lights, from surfaces that were read back from the device.

#include "raster/barycentric.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"
#include "visibility/shadow_point.h"

namespace gnomon::raster {

/// Makes the point of a pixel as the traced frame does.
/// @param id        object + 1 and triangle, as in GBuffer::ids
/// @param position  on the triangle's plane
/// @param normal    geometric, on the viewer's side
inline visibility::ShadowPoint shadow_point_of(const ray::RayScene& rays, const glm::uvec2& id,
                                               const glm::vec3& position, const glm::vec3& normal)
{
    visibility::ShadowPoint point;
    point.object = id.x - 1;
    point.triangle = id.y;
    glm::vec3 corners[3];
    rays.geometry(point.object).corners(point.triangle, corners);
    const glm::vec2 at = barycentric(corners, position);
    point.u = at.x, point.v = at.y;
    point.normal = normal;
    point.front = glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), normal) > 0;
    point.origin = point_of(corners, at) + ray::origin_lift(corners) * normal;
    return point;
}

}   // namespace gnomon::raster
