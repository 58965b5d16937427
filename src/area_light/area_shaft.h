// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a planar light: the convex region that contains every segment
// between them.
//
// Its top lies below the light, where shadow rays end.

#include <array>

#include "area_light/hull_shaft.h"
#include "area_light/light_places.h"

namespace gnomon::area_light {

/// The part of a convex polygon above a plane.
struct ClippedLight {
    std::array<glm::dvec3, 8> corner{};
    int count = 0;
};
ClippedLight clip_light(const LightPolygon& polygon, const glm::dvec3& normal, double distance);

class AreaShaft final : public HullShaft {
 public:
    /// @param corner  of the piece, in the receiving triangle's plane
    /// @param normal  unit, the receiver's, on the side where rays start
    /// @param light   what of the light is above the receiver's plane
    /// @param front   unit, the normal of the light's emitting side
    /// @param lift    height of the ray origins above the plane
    AreaShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const ClippedLight& light,
              const glm::dvec3& front, double lift, const ShaftRules& rules = {});

    /// Whether the piece has a point in front of the light. Otherwise no light reaches it.
    bool faces_light() const { return most_height_ > 0; }
    /// How far below the light the segments end from the highest points of the piece. (The shaft ends where those from
    /// the lowest do.)
    double most_end_gap() const { return (1 - static_cast<double>(ray::k_shadow_ray_end)) * most_height_; }
    /// Height over the light's plane, on its emitting side.
    double light_height(const glm::dvec3& x) const { return light_plane_.at(x); }

 private:
    double most_height_ = 0;
    visibility::Plane light_plane_;
};

}   // namespace gnomon::area_light
