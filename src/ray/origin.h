// SPDX-License-Identifier: Apache-2.0
#pragma once
// The offset at which rays that leave a surface start, so that they do not hit it again, and where shadow rays end.

#include <algorithm>

#include "base/math.h"
#include "ray/limits_shared.h"

namespace gnomon::ray {

// As a fraction of the largest coordinate. A position interpolated from a triangle's corners is off the plane by a few
// units in the last place; this also covers the rounding of instance transforms.
inline constexpr float k_lift_per_coordinate = GNOMON_LIFT_PER_COORDINATE;

// Shadow rays end at this fraction of the way to a light, so that a light drawn as a surface does not shadow itself.
// Every shadow ray uses it, because certified culling is exact only if all agree.
inline constexpr float k_shadow_ray_end = GNOMON_SHADOW_RAY_END;

/// Distance along the geometric normal at which rays from this triangle (world-space corners) start.
inline float origin_lift(const glm::vec3 (&p)[3])
{
    float largest = 0;
    for (const glm::vec3& c : p) largest = std::max({largest, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    return k_lift_per_coordinate * largest;
}

}   // namespace gnomon::ray
