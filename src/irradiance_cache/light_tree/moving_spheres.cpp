// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/moving_spheres.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

// Adds a sphere around all, then those of each half, split at the median of the longest axis.
void MovingSpheres::enclose(std::span<Sphere> spheres)
{
    if (spheres.empty()) return;
    const auto at = nodes_.size();
    nodes_.push_back({spheres[0], 0, spheres.size() == 1});
    if (spheres.size() > 1) {
        glm::vec3 low = spheres[0].centre, high = low;
        for (const Sphere& s : spheres)
            low = glm::min(low, s.centre - s.radius), high = glm::max(high, s.centre + s.radius);
        Sphere all{0.5f * (low + high), 0};
        for (const Sphere& s : spheres)
            all.radius = std::max(all.radius, glm::length(s.centre - all.centre) + s.radius);
        all.radius *= k_grown;
        nodes_[at].sphere = all;
        const glm::vec3 size = high - low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        std::stable_sort(spheres.begin(), spheres.end(),
                         [&](const Sphere& a, const Sphere& b) { return a.centre[axis] < b.centre[axis]; });
        const std::size_t half = spheres.size() / 2;
        enclose(spheres.first(half));
        enclose(spheres.subspan(half));
    }
    nodes_[at].next = static_cast<std::uint32_t>(nodes_.size());
}

}   // namespace gnomon::irradiance_cache
