// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where rays that leave a surface start, a little above it, so that they do not meet it again; and where shadow rays
// end.

#include <algorithm>

#include "base/math.h"
#include "ray/limits_shared.h"

namespace gnomon::ray {

// A position interpolated from corners of this size is off its plane by a few units in the last place; new rays start
// this much above it, which also covers the rounding of the instance transforms on the way.
inline constexpr float k_lift_per_coordinate = GNOMON_LIFT_PER_COORDINATE;

// Shadow rays end at this fraction of the way to a light, so that a light drawn as a surface does not shadow itself.
// Every shadow ray uses it: "the same image as with shadow culling off" depends on that.
inline constexpr float k_shadow_ray_end = GNOMON_SHADOW_RAY_END;

/// How far along the geometric normal a ray from this triangle (world-space corners) must start.
inline float origin_lift(const glm::vec3 (&p)[3])
{
    float largest = 0;
    for (const glm::vec3& c : p) largest = std::max({largest, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
    return k_lift_per_coordinate * largest;
}

}   // namespace gnomon::ray
