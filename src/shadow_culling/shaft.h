// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a light: everything that a shadow ray from the piece can pass.
//
// For a point or spot light a tetrahedron with the light at its tip, for a directional light an endless prism. Planes
// are in double precision and pushed outward by a margin, so that the shaft holds the rays as they are traced in single
// precision, from origins a little above the receiver.

#include <array>
#include <cstdint>

#include "base/math.h"

namespace gnomon::shadow_culling {

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

/// Whether a triangle has a point inside all planes; to the precision of doubles. `clipped` gets what lies inside.
bool clip_triangle(const std::array<Plane, 4>& planes, const glm::dvec3 (&p)[3], ClippedPolygon& clipped);

class Shaft {
 public:
    /// @param corner    of the piece, in the receiving triangle's plane
    /// @param normal    unit, the receiver's, on the side that rays start from
    /// @param light     on that side of the receiver
    /// @param base      height of the shaft's base above the plane: lower than rays start
    /// @param margin    how far the side planes are pushed outward, scene units
    /// @param thinnest  pieces that are no thicker make no valid shaft
    Shaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const LightPoint& light, double base, double margin,
          double thinnest);

    /// False for pieces too thin to have side planes: nothing can be certified on them.
    bool valid() const { return valid_; }
    const LightPoint& light() const { return light_; }
    const std::array<Plane, 4>& planes() const { return planes_; }   // three sides, then the base
    double height(const glm::dvec3& x) const { return planes_[3].at(x); }
    /// Height of the light above the base; infinite for a directional one.
    double light_height() const { return light_height_; }
    glm::dvec3 centroid() const { return centroid_; }
    const glm::vec3& low() const { return low_; }
    const glm::vec3& high() const { return high_; }

    /// Conservative: may be true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Whether a triangle has a point inside; to the precision of doubles. `clipped` gets what lies inside.
    bool clip(const glm::dvec3 (&p)[3], ClippedPolygon& clipped) const { return clip_triangle(planes_, p, clipped); }
    /// Whether a segment has a point inside.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b) const;

 private:
    LightPoint light_;
    std::array<Plane, 4> planes_;
    double light_height_ = 0;
    glm::dvec3 centroid_{0};
    glm::vec3 low_{0}, high_{0};                              // of the shaft; infinite sides for a directional light
    std::array<std::array<std::uint8_t, 3>, 4> furthest_{};   // by plane and axis: 1 where it faces the high side
    bool valid_ = false;
};

}   // namespace gnomon::shadow_culling
