// SPDX-License-Identifier: Apache-2.0
#include "ray/smooth_surface.h"

#include <algorithm>
#include <cmath>

namespace gnomon::ray {

namespace {

// DEVIATION(Hanika 2021, 6.3): a point rises by at most this part of the triangle's shortest altitude. On a sphere it
// rises less as long as a triangle spans less than 90 degrees. But the planes of the vertices of a slender triangle may
// meet anywhere, beyond what stands before it.
constexpr float k_highest = 0.5f;

float shortest_altitude(const glm::vec3 (&p)[3])
{
    const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], c = p[2] - p[1];
    const float longest = std::sqrt(std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)}));
    return longest > 0 ? glm::length(glm::cross(a, b)) / longest : 0.0f;
}

}   // namespace

glm::vec3 smooth_normal(const ObjectGeometry& geometry, std::uint32_t triangle, float w, float u, float v,
                        const glm::vec3& normal)
{
    if (!geometry.normals) return normal;
    const glm::uvec3 index = geometry.mesh->triangles[triangle];
    glm::vec3 n = w * geometry.normals[index[0]] + u * geometry.normals[index[1]] + v * geometry.normals[index[2]];
    if (geometry.normal_to_world) n = *geometry.normal_to_world * n;
    if (glm::dot(n, normal) < 0) n = -n;
    return glm::dot(n, n) > 0 ? glm::normalize(n) : normal;
}

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
    const float height = glm::length(lift), most = k_highest * shortest_altitude(p);
    return height > most ? lift * (most / height) : lift;
}

}   // namespace gnomon::ray
