// SPDX-License-Identifier: Apache-2.0
#include "ray/thin_hits.h"

#include <algorithm>
#include <cmath>

#include "ray/origin.h"

namespace gnomon::ray {

bool hits_thin_surface(const scene::Scene& scene, const RayScene& rays, const Hits& hits, std::size_t i,
                       ThinSurface& surface)
{
    if (hits.object[i] == scene::none) return false;
    const scene::Mesh& mesh = *rays.geometry(hits.object[i]).mesh;
    const scene::Material& material = scene.materials[mesh.part_of(hits.triangle[i]).material];
    if (!scene::thins_light(material)) return false;
    surface = thin_surface(scene, mesh, material, hits.triangle[i], hits.u[i], hits.v[i]);
    return true;
}

void RaysBehind::find(const RayScene& rays, const RayQueue& queue, std::span<const std::uint32_t> which,
                      Against against, Hits& hits)
{
    constexpr float k_least_cosine = 1e-3f;
    queue_.clear();
    queue_.purpose = queue.purpose;
    for (const std::uint32_t i : which) {
        glm::vec3 p[3];
        rays.geometry(hits.object[i]).corners(hits.triangle[i], p);
        const glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]), direction = queue.direction(i);
        const float length = glm::length(normal);
        const float cosine = length > 0 ? std::abs(glm::dot(normal, direction)) / length : 1;
        queue_.push(queue.origin(i), hits.t[i] + origin_lift(p) / std::max(cosine, k_least_cosine), direction,
                    queue.tfar[i]);
    }
    hits_.resize(queue_.size());
    rays.closest(queue_, 0, queue_.size(), hits_, Sides::both, against);
    for (std::size_t k = 0; k < which.size(); ++k) {
        const std::uint32_t i = which[k];
        hits.t[i] = hits_.t[k], hits.u[i] = hits_.u[k], hits.v[i] = hits_.v[k];
        hits.object[i] = hits_.object[k], hits.triangle[i] = hits_.triangle[k];
    }
}

}   // namespace gnomon::ray
