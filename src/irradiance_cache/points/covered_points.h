// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cache points of static objects that dynamic objects cover: what stands on a point, or is close to it all around,
// leaves it dark, and its light is no longer that of the surface around. Such a point is left out as long as it is
// covered.

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"
#include "patches/open_places.h"

namespace gnomon::irradiance_cache {

/// What tells whether a point is covered.
struct CoverablePoint {
    glm::vec3 origin{0}, normal{0};   // geometric
    float reach = 0;                  // of what covers it from outside: it must be less far away in every direction

    CoverablePoint() = default;
    explicit CoverablePoint(const CachePoint& point) : origin(point.origin()), normal(point.geometric_normal)
    {
        constexpr float k_reach = 0.25f;   // of the lattice's spacing
        if (is_lattice(point.key)) reach = k_reach * lattice_spacing(point.key);
    }
};

/// Thread-safe. Cost: a look at the boxes of dynamic objects; inside one, up to five rays.
inline bool is_covered(const CacheFrame& frame, const CoverablePoint& point)
{
    const bool inside = frame.dynamic_bounds.any(
        [&](const Sphere& sphere) {
            const glm::vec3 to = sphere.centre - point.origin;
            const float within = sphere.radius + point.reach;
            return glm::dot(to, to) < within * within;
        },
        [&](const Sphere&, const MovingBox& box) {
            return meets_way(box, point.origin, point.normal, 0, point.reach);
        });
    return inside && patches::is_covered(*frame.rays, point.origin, point.normal, point.reach);
}

}   // namespace gnomon::irradiance_cache
