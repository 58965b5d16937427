// SPDX-License-Identifier: Apache-2.0
#include "shading/between_horizons.h"

#include <algorithm>

#include "ray/origin.h"

namespace gnomon::shading {

bool is_partly_between(const SurfacePoint& s, const scene::SizedLight& light)
{
    if (s.smooth_normal == s.geometric_normal) return false;
    const float height = glm::dot(light.centre - s.position, s.geometric_normal);
    if (height >= light.radius) return false;
    if (light.faces.size() > 1) return true;
    const scene::SizedFace& face = light.faces.front();
    for (int c = 0; c < face.corners; ++c)
        if (between_horizons(s, face.corner[static_cast<std::size_t>(c)] - s.position)) return true;
    return false;
}

void SeenBetween::find(const ray::RayScene& rays, const SurfacePoint& s, const glm::vec3& origin,
                       const glm::vec3& smooth_origin, const scene::SizedLight& light)
{
    const std::size_t step = std::max<std::size_t>(1, (light.places.size() + k_rays - 1) / k_rays);
    places_.clear(), queue_.clear();
    queue_.purpose = ray::RayClass::shadow;
    for (std::size_t i = step / 2; i < light.places.size(); i += step) {
        const glm::vec3& place = light.places[i].position;
        const bool before = glm::dot(s.geometric_normal, place - s.position) > 0;
        const glm::vec3& from = before ? origin : smooth_origin;
        queue_.push(from, 0, place - from, ray::k_shadow_ray_end);
        places_.push_back(light.places[i]);
    }
    const std::size_t count = queue_.size();
    occluded_.resize(count + ray::k_packet_pad);
    rays.occluded(queue_, 0, count, occluded_.data());
    seen_.resize(count);
    for (std::size_t r = 0; r < count; ++r) seen_[r] = occluded_[r] ? 0 : k_whole;
}

}   // namespace gnomon::shading
