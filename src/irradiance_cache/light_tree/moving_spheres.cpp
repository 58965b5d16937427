// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/moving_spheres.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

MovingBox MovingBox::around(const Box3& own, const glm::mat4& to_world, const Sphere& sphere)
{
    const glm::vec3 half = 0.5f * (own.high - own.low);
    const glm::mat3 axes(to_world);
    MovingBox box;
    box.centre = transform_point(to_world, own.centre());
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 across = glm::cross(axes[(i + 1) % 3], axes[(i + 2) % 3]);
        const float length = glm::length(across);
        if (!(length > 0) || !std::isfinite(length)) continue;   // the object is flattened to nothing
        box.normal[i] = across / length;
        box.half[i] = half[i] * std::abs(glm::dot(axes[i], box.normal[i])) + (k_grown - 1) * sphere.radius;
    }
    return box;
}

void MovingSpheres::add(const std::vector<Sphere>& together)
{
    std::vector<Object> objects;
    for (const Sphere& sphere : together) objects.push_back({sphere, {}});
    enclose(objects);
}

// Adds a sphere around all, then those of each half, split at the median of the longest axis.
void MovingSpheres::enclose(std::span<Object> objects)
{
    if (objects.empty()) return;
    const auto at = nodes_.size();
    nodes_.push_back({objects[0].sphere, 0, objects.size() == 1});
    boxes_.push_back(objects[0].box);
    if (objects.size() > 1) {
        glm::vec3 low = objects[0].sphere.centre, high = low;
        for (const auto& [s, box] : objects)
            low = glm::min(low, s.centre - s.radius), high = glm::max(high, s.centre + s.radius);
        Sphere all{0.5f * (low + high), 0};
        for (const auto& [s, box] : objects)
            all.radius = std::max(all.radius, glm::length(s.centre - all.centre) + s.radius);
        all.radius *= k_grown;
        nodes_[at].sphere = all;
        boxes_[at] = {};
        const glm::vec3 size = high - low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        std::stable_sort(objects.begin(), objects.end(), [&](const Object& a, const Object& b) {
            return a.sphere.centre[axis] < b.sphere.centre[axis];
        });
        const std::size_t half = objects.size() / 2;
        enclose(objects.first(half));
        enclose(objects.subspan(half));
    }
    nodes_[at].next = static_cast<std::uint32_t>(nodes_.size());
}

}   // namespace gnomon::irradiance_cache
