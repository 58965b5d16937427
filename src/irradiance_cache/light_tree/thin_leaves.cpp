// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/thin_leaves.h"

#include "base/interruption.h"

namespace gnomon::irradiance_cache {

std::vector<glm::vec3> find_thin_leaves(const scene::Scene& scene, const ray::RayScene& rays,
                                        const ray::RayQueue& queue, bool behind, ray::Against against, ray::Hits& hits)
{
    constexpr int k_most_surfaces = 8;   // that thin light, along a ray
    if (!rays.thins_light()) return {};
    std::vector<glm::vec3> factor(queue.size(), glm::vec3(behind ? 0 : 1));
    std::vector<std::uint32_t> on, next_on;
    for (std::uint32_t i = 0; i < queue.size(); ++i) {
        ray::ThinSurface thin;
        if (!ray::hits_thin_surface(scene, rays, hits, i, thin)) continue;
        if (!behind) {
            factor[i] = glm::vec3(thin.covered);
        } else if (thin.passes != glm::vec3(0)) {
            factor[i] = thin.passes;
            on.push_back(i);
        }
    }
    ray::RaysBehind ray;
    for (int surface = 0; !on.empty(); ++surface) {
        interruption_point();
        ray.find(rays, queue, on, against, hits);
        next_on.clear();
        for (const std::uint32_t i : on) {
            ray::ThinSurface thin;
            if (!ray::hits_thin_surface(scene, rays, hits, i, thin)) continue;
            factor[i] *= surface < k_most_surfaces ? thin.passes : glm::vec3(0);
            if (factor[i] != glm::vec3(0)) next_on.push_back(i);
        }
        on.swap(next_on);
    }
    return factor;
}

}   // namespace gnomon::irradiance_cache
