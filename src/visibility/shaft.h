// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a light: the convex region that contains every shadow ray from the
// piece.
//
// For a point or spot light it is a tetrahedron with the light as apex, for a directional light an infinite prism. Its
// planes are in double precision. Rays are traced in single precision from origins slightly above the receiver, so a
// ray may miss its exact position by a few units in the last place of the larger of the coordinates of the receiver and
// of the tested triangle. Therefore the shaft is widened, and its base lowered, for each triangle (or box of triangles)
// that it is tested against, by a margin that depends on that triangle's coordinates.

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/math.h"
#include "ray/origin.h"

namespace gnomon::visibility {

/// A light in homogeneous coordinates: w = 1 for a position, w = 0 for the direction towards it.
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

/// How much a shaft is enlarged.
struct ShaftRules {
    double margin = 4e-6;   // of side planes outwards, as a fraction of the largest coordinate involved
    double room = 0.5;      // of the base below the ray origins, in lifts (ray/origin.h) of that coordinate
};

/// The enlargement for one triangle, in scene units.
struct ShaftRoom {
    double side = 0;   // displacement of the side planes outwards
    double base = 0;   // height of the base above the receiver; may be negative
};

/// Whether a triangle has a point inside all planes, to double precision. `clipped` gets the part inside.
bool clip_triangle(const std::array<Plane, 4>& planes, const glm::dvec3 (&p)[3], ClippedPolygon& clipped);

class Shaft {
 public:
    /// @param corner    of the piece, in the receiving triangle's plane
    /// @param normal    unit, the receiver's, on the side where rays start
    /// @param light     on that side of the receiver
    /// @param lift      height of the ray origins above the plane
    Shaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const LightPoint& light, double lift,
          const ShaftRules& rules);

    /// False for pieces thinner than the margin, which are too small to be worth a certificate.
    bool valid() const { return valid_; }
    const LightPoint& light() const { return light_; }
    /// Height above the receiver's plane.
    double height(const glm::dvec3& x) const { return planes_[3].at(x); }
    /// Height of the light; infinite for a directional one.
    double light_height() const { return light_height_; }
    double lift() const { return lift_; }
    glm::dvec3 centroid() const { return centroid_; }

    /// The lift for a triangle with this largest coordinate, at least the receiver's own.
    double lift_for(double coordinate) const { return std::max(lift_, k_lift * coordinate); }
    ShaftRoom room_for(double coordinate) const
    {
        const double most = lift_for(coordinate);
        return {rules_.margin / k_lift * most, lift_ - rules_.room * most};
    }

    /// Conservative: may return true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Whether a triangle has a point inside, to double precision. `clipped` gets the part inside.
    bool clip(const glm::dvec3 (&p)[3], const ShaftRoom& room, ClippedPolygon& clipped) const;
    /// Whether a segment has a point inside.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b, const ShaftRoom& room) const;

 private:
    static constexpr double k_lift = ray::k_lift_per_coordinate;

    LightPoint light_;
    ShaftRules rules_;
    double lift_ = 0;
    std::array<Plane, 4> planes_;   // three sides, then the receiver's; not enlarged
    double light_height_ = 0;
    glm::dvec3 centroid_{0};
    glm::vec3 low_{0}, high_{0};   // bounds of piece and light; infinite for a directional one
    std::array<std::array<std::uint8_t, 3>, 4>
        furthest_{};   // by plane and axis: 1 where the inside is towards the box's high side
    bool valid_ = false;
};

}   // namespace gnomon::visibility
