// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a planar light: the convex region that contains every segment
// between them.
//
// Its sides go through an edge of the piece and a corner of the light, or the reverse, one for each edge; each lies
// outside of all corners, so that a plane that is imprecise cuts off less, never more. Its base lies below the ray
// origins, and its top below the light, where shadow rays end. Both are enlarged for each tested triangle, as
// visibility/shaft.h explains.

#include <array>
#include <cstdint>
#include <span>

#include "area_light/light_places.h"
#include "visibility/shaft.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

/// The part of a convex polygon above a plane.
struct ClippedLight {
    std::array<glm::dvec3, 8> corner{};
    int count = 0;
};
ClippedLight clip_light(const LightPolygon& polygon, const glm::dvec3& normal, double distance);

struct ShaftRules {
    double margin = 4e-6;   // of sides and top outwards, as a fraction of the largest coordinate involved
    double room = 0.5;      // of the base below the ray origins, in lifts (ray/origin.h) of that coordinate
};

/// A convex polygon: a triangle clipped by a shaft.
struct ClippedTriangle {
    std::array<glm::dvec3, 20> corner;
    int count = 0;
};

class AreaShaft {
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
    /// Conservative: may return true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Conservative: whether a triangle may have a point inside. Cheaper than clip(), and nearly as sharp.
    bool may_meet(const visibility::StaticTriangle& triangle) const;
    /// Whether a triangle has a point inside, to double precision. `clipped` gets the part inside.
    bool clip(const visibility::StaticTriangle& triangle, ClippedTriangle& clipped) const;
    /// Whether a segment has a point inside the shaft, enlarged for a coordinate of this size.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b, double coordinate) const;
    double height(const glm::dvec3& x) const { return planes_[0].at(x); }
    /// How far below the light the segments end from the highest points of the piece. (The shaft ends where those from
    /// the lowest do.)
    double most_end_gap() const { return (1 - static_cast<double>(ray::k_shadow_ray_end)) * most_height_; }
    /// Height over the light's plane, on its emitting side.
    double light_height(const glm::dvec3& x) const { return light_plane_.at(x); }
    double lift_for(double coordinate) const { return std::max(lift_, k_lift * coordinate); }
    double margin_for(double coordinate) const { return rules_.margin / k_lift * lift_for(coordinate); }

 private:
    static constexpr double k_lift = ray::k_lift_per_coordinate;
    static constexpr std::size_t k_most_planes = 2 + 3 + 8;

    void add_side(const glm::dvec3& a, const glm::dvec3& b, std::span<const glm::dvec3> far);
    // The least height over the piece inside the shaft, enlarged for a coordinate of this size.
    double base_for(double coordinate) const { return lift_ - rules_.room * lift_for(coordinate); }

    ShaftRules rules_;
    double lift_ = 0, end_gap_ = 0, most_height_ = 0;
    std::array<visibility::Plane, k_most_planes> planes_;   // base, top, sides; not enlarged
    std::size_t count_ = 0;
    visibility::Plane light_plane_;
    std::array<glm::dvec3, 3 + 8> hull_{};   // corners of piece and light
    std::size_t hull_count_ = 0;
    glm::dvec3 low_{0}, high_{0};
    std::array<std::array<std::uint8_t, 3>, k_most_planes> furthest_{};
};

}   // namespace gnomon::area_light
