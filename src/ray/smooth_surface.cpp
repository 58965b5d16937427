// SPDX-License-Identifier: Apache-2.0
#include "ray/smooth_surface.h"

#include <algorithm>

namespace gnomon::ray {

glm::vec3 smooth_lift(const ObjectGeometry& geometry, std::uint32_t triangle, float u, float v, const glm::vec3& normal)
{
    glm::vec3 lift(0);
    if (!geometry.normals) return lift;
    const glm::uvec3 index = geometry.mesh->triangles[triangle];
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    const float weight[3] = {std::max(0.0f, 1 - u - v), u, v};
    const glm::vec3 position = weight[0] * p[0] + weight[1] * p[1] + weight[2] * p[2];
    // Move the point to the plane of each vertex, where that lies above it, in proportion to its weight.
    for (int i = 0; i < 3; ++i) {
        glm::vec3 n = geometry.normals[index[i]];
        if (geometry.normal_to_world) n = *geometry.normal_to_world * n;
        const float square = glm::dot(n, n), above = glm::dot(p[i] - position, n);
        if (!(square > 0) || !std::isfinite(square)) continue;
        // Both factors of n may point to the other side.
        const bool same_side = glm::dot(n, normal) > 0;
        if (same_side ? above > 0 : above < 0) lift += weight[i] * (above / square) * n;
    }
    return lift;
}

}   // namespace gnomon::ray
