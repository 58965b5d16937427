// SPDX-License-Identifier: Apache-2.0
#pragma once
// The texels of a light view that a ball covers: for compact objects, a far smaller rectangle than that of their box,
// of which a light may see a corner.
//
// Projected along one axis of the image, the ball is a circle and the eye a point outside of it: the two tangents bound
// it. Cost: two arc functions per axis.

#include <cmath>
#include <optional>

#include "light_views/projection.h"

namespace gnomon::light_quadtree {

inline constexpr double k_ball_room = 0.01;   // texels: far more than the rounding of a ray or a position

/// A rectangle of texels outside of which no ray through a texel's centre hits the ball; none if the eye is inside the
/// ball or nearly so. Not clipped to the image.
/// @param centre  in world space
/// @param radius  in scene units
inline std::optional<light_views::Rect> ball_footprint(const light_views::ViewProjection& view,
                                                       const glm::dvec3& centre, double radius)
{
    const glm::dvec3 off = centre - glm::dvec3(view.origin);
    const double ahead = glm::dot(off, glm::dvec3(glm::normalize(view.forward)));
    double low[2], high[2];
    const glm::vec3* const axes[2] = {&view.across, &view.down};
    for (int axis = 0; axis < 2; ++axis) {
        const double extent = glm::length(*axes[axis]);   // half the size of the image, at distance 1
        const double aside = glm::dot(off, glm::dvec3(*axes[axis])) / extent;
        if (view.perspective) {
            const double distance = std::hypot(aside, ahead);
            if (!(distance > radius)) return std::nullopt;
            const double towards = std::atan2(aside, ahead), half = std::asin(radius / distance);
            constexpr double k_widest = 1.5;   // radians from the view's axis
            if (towards - half < -k_widest || towards + half > k_widest) return std::nullopt;
            low[axis] = std::tan(towards - half) / extent, high[axis] = std::tan(towards + half) / extent;
        } else {
            low[axis] = (aside - radius) / extent, high[axis] = (aside + radius) / extent;
        }
        // Clamp coordinates far outside of the image, to keep them in range.
        low[axis] = std::clamp(low[axis], -2.0, 2.0), high[axis] = std::clamp(high[axis], -2.0, 2.0);
    }
    const auto texel = [&](double clip) { return (0.5 * clip + 0.5) * view.size; };
    return light_views::Rect{static_cast<int>(std::floor(texel(low[0]) - k_ball_room)),
                             static_cast<int>(std::floor(texel(low[1]) - k_ball_room)),
                             static_cast<int>(std::ceil(texel(high[0]) + k_ball_room)),
                             static_cast<int>(std::ceil(texel(high[1]) + k_ball_room))};
}

}   // namespace gnomon::light_quadtree
