// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which casters lie between a receiver and the light: what the method before Oh and Shin's must find and draw.

#include "light_views/projection.h"

namespace gnomon::shadow_textures {

/// Of a box along the light's axis; conservative.
struct DistanceRange {
    float nearest = k_infinity, farthest = -k_infinity;
};

inline DistanceRange distance_range(const light_views::ViewProjection& view, const glm::mat4& to_world, const Box3& box)
{
    DistanceRange range;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                          corner & 4 ? box.high.z : box.low.z);
        const float along = glm::dot(transform_point(to_world, p) - view.origin, view.forward);
        range.nearest = std::min(range.nearest, along);
        range.farthest = std::max(range.farthest, along);
    }
    return range;
}

}   // namespace gnomon::shadow_textures
