// SPDX-License-Identifier: Apache-2.0
#pragma once
// The region that contains every ray from a piece of a receiving triangle in the directions of a cell: the sum of a
// triangle and a cone, convex and without end.
//
// Its sides go through a corner of the piece along a side of the cone, or through an edge of the piece along a corner
// of the cone; each lies outside of all corners of the piece, so that a plane that is imprecise cuts off less, never
// more. Its base lies below the ray origins. Both are enlarged for each tested triangle, as visibility/shaft.h
// explains.

#include <array>
#include <cstdint>
#include <span>

#include "visibility/shaft.h"
#include "visibility/static_triangles.h"

namespace gnomon::environment_light {

using PrismRules = visibility::ShaftRules;

/// A convex polygon: a triangle clipped by a prism.
struct ClippedTriangle {
    std::array<glm::dvec3, 16> corner;
    int count = 0;
};

class EndlessPrism {
 public:
    /// @param corner     of the piece, in the receiving triangle's plane
    /// @param normal     unit, the receiver's, on the side where rays start
    /// @param direction  corners of the cell, around it; one alone: a single direction
    /// @param lift       height of the ray origins above the plane
    EndlessPrism(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, std::span<const glm::dvec3> direction,
                 double lift, const PrismRules& rules = {});

    /// Conservative: may return true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Conservative: whether a triangle may have a point inside. Cheaper than clip(), and nearly as sharp.
    bool may_meet(const visibility::StaticTriangle& triangle) const;
    /// Whether a triangle has a point inside, to double precision. `clipped` gets the part inside.
    bool clip(const visibility::StaticTriangle& triangle, ClippedTriangle& clipped) const;
    /// Whether a segment has a point inside the prism, enlarged for a coordinate of this size.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b, double coordinate) const;
    /// Height above the receiver's plane.
    double height(const glm::dvec3& x) const { return planes_[0].at(x); }
    double lift_for(double coordinate) const { return std::max(lift_, k_lift * coordinate); }

 private:
    static constexpr double k_lift = ray::k_lift_per_coordinate;
    static constexpr std::size_t k_most_planes = 1 + 4 + 3 * 2;

    void add_side(glm::dvec3 normal, std::span<const glm::dvec3> direction);
    double least(std::size_t plane, double coordinate) const;

    PrismRules rules_;
    double lift_ = 0;
    glm::dvec3 piece_[3];
    std::array<visibility::Plane, k_most_planes> planes_;   // base, sides; not enlarged
    std::size_t count_ = 0;
    std::array<std::array<std::uint8_t, 3>, k_most_planes> furthest_{};
};

}   // namespace gnomon::environment_light
