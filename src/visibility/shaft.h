// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a light: everything that a shadow ray from the piece can pass.
//
// For a point or spot light a tetrahedron with the light at its tip, for a directional light an endless prism; planes
// in double precision. Rays are traced in single precision, from origins a little above the receiver, and how far off a
// ray can be is a matter of the triangle that it is tested against: a few units in the last place of the larger of the
// triangle's and the receiver's coordinates. So the shaft is made wider, and its base lower, for each triangle (or box
// of them) that is held against it, by the room that its coordinates ask for.

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/math.h"
#include "ray/origin.h"

namespace gnomon::visibility {

/// A light as certificates see it: w = 1 a place, w = 0 the direction towards it.
struct LightPoint {
    glm::dvec3 place{0};
    bool directional = false;
};

struct Plane {
    glm::dvec3 normal{0};   // unit, inward
    double distance = 0;    // inside: dot(normal, x) + distance >= 0
    double at(const glm::dvec3& x) const { return glm::dot(normal, x) + distance; }
};

/// A convex polygon with few corners: a triangle clipped by a shaft.
struct ClippedPolygon {
    std::array<glm::dvec3, 12> corner;
    int count = 0;
};

/// How much larger a shaft is made.
struct ShaftRules {
    double margin = 4e-6;   // of side planes outward, as a fraction of the largest coordinate in play
    double room = 0.5;      // of the base below where rays start, in lifts (ray/origin.h) of that coordinate
};

/// What these rules ask for one triangle, scene units.
struct ShaftRoom {
    double side = 0;   // side planes go outward by this
    double base = 0;   // the base's height above the receiver; may be negative
};

/// Whether a triangle has a point inside all planes; to the precision of doubles. `clipped` gets what lies inside.
bool clip_triangle(const std::array<Plane, 4>& planes, const glm::dvec3 (&p)[3], ClippedPolygon& clipped);

class Shaft {
 public:
    /// @param corner    of the piece, in the receiving triangle's plane
    /// @param normal    unit, the receiver's, on the side that rays start from
    /// @param light     on that side of the receiver
    /// @param lift      how far above the plane rays start
    Shaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const LightPoint& light, double lift,
          const ShaftRules& rules);

    /// False for pieces thinner than the margin: too little can be certified on them.
    bool valid() const { return valid_; }
    const LightPoint& light() const { return light_; }
    /// Above the receiver's plane.
    double height(const glm::dvec3& x) const { return planes_[3].at(x); }
    /// Of the light; infinite for a directional one.
    double light_height() const { return light_height_; }
    double lift() const { return lift_; }
    glm::dvec3 centroid() const { return centroid_; }

    /// The lift that a triangle with this largest coordinate asks for, or the receiver's own if that is more.
    double lift_for(double coordinate) const { return std::max(lift_, k_lift * coordinate); }
    ShaftRoom room_for(double coordinate) const
    {
        const double most = lift_for(coordinate);
        return {rules_.margin / k_lift * most, lift_ - rules_.room * most};
    }

    /// Conservative: may be true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Whether a triangle has a point inside; to the precision of doubles. `clipped` gets what lies inside.
    bool clip(const glm::dvec3 (&p)[3], const ShaftRoom& room, ClippedPolygon& clipped) const;
    /// Whether a segment has a point inside.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b, const ShaftRoom& room) const;

 private:
    static constexpr double k_lift = ray::k_lift_per_coordinate;

    LightPoint light_;
    ShaftRules rules_;
    double lift_ = 0;
    std::array<Plane, 4> planes_;   // three sides, then the receiver's; as in exact arithmetic
    double light_height_ = 0;
    glm::dvec3 centroid_{0};
    glm::vec3 low_{0}, high_{0};                              // around piece and light; a directional one is endless
    std::array<std::array<std::uint8_t, 3>, 4> furthest_{};   // by plane and axis: 1 where it faces the high side
    bool valid_ = false;
};

}   // namespace gnomon::visibility
