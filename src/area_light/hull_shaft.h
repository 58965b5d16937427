// SPDX-License-Identifier: Apache-2.0
#pragma once
// The convex region that contains every segment from a piece of a receiving triangle to a light, whatever its shape.
//
// Its sides go through an edge of the piece and a corner of the light, or the reverse, one for each edge; each lies
// outside of all corners, so that a plane that is imprecise cuts off less, never more. Its base lies below the ray
// origins. All are enlarged for each tested triangle, as visibility/shaft.h explains. What bounds it at the light is up
// to the kind of light (area_shaft.h, cluster_shaft.h).

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "visibility/shaft.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

struct ShaftRules {
    double margin = 4e-6;   // of sides and top outwards, as a fraction of the largest coordinate involved
    double room = 0.5;      // of the base below the ray origins, in lifts (ray/origin.h) of that coordinate
};

/// A convex polygon: a triangle clipped by a shaft.
struct ClippedTriangle {
    std::array<glm::dvec3, 28> corner;
    int count = 0;
};

class HullShaft {
 public:
    /// Conservative: may return true for a box outside.
    bool may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const;
    /// Conservative: whether a triangle may have a point inside. Cheaper than clip(), and nearly as sharp.
    bool may_meet(const visibility::StaticTriangle& triangle) const;
    /// Whether a triangle has a point inside, to double precision. `clipped` gets the part inside.
    bool clip(const visibility::StaticTriangle& triangle, ClippedTriangle& clipped) const;
    /// Whether a corner of a triangle lies inside, which clip() would keep.
    bool has_corner_inside(const visibility::StaticTriangle& triangle) const;
    /// Whether a segment has a point inside the shaft, enlarged for a coordinate of this size.
    bool meets_segment(const glm::dvec3& a, const glm::dvec3& b, double coordinate) const;
    double height(const glm::dvec3& x) const { return planes_[0].at(x); }
    double lift_for(double coordinate) const { return std::max(lift_, k_lift * coordinate); }
    double margin_for(double coordinate) const { return rules_.margin / k_lift * lift_for(coordinate); }

 protected:
    static constexpr std::size_t k_most_corners = 3 + 8;           // of piece and light
    static constexpr std::size_t k_most_planes = 1 + 3 + 12 + 6;   // base, edges of piece and light, faces of the light

    /// @param corner  of the piece
    /// @param normal  unit, of the piece, on the side where rays start
    /// @param light   corners of the light's convex hull
    HullShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, std::span<const glm::dvec3> light, double lift,
              const ShaftRules& rules);

    std::span<const glm::dvec3> piece() const { return {hull_.data(), 3}; }
    std::span<const glm::dvec3> light() const { return {hull_.data() + 3, hull_count_ - 3}; }
    void add_plane(const visibility::Plane& plane) { planes_[count_++] = plane; }
    /// Adds the plane through an edge and that corner of the other side that leaves all of both on one side.
    /// @param most_outside  of the edge; if every plane leaves more of it outside, none is added
    void add_side(const glm::dvec3& a, const glm::dvec3& b, std::span<const glm::dvec3> far,
                  double most_outside = std::numeric_limits<double>::infinity());
    /// Call once all planes are added.
    void finish();

 private:
    static constexpr double k_lift = ray::k_lift_per_coordinate;
    // The least height over the piece inside the shaft, enlarged for a coordinate of this size.
    double base_for(double coordinate) const { return lift_ - rules_.room * lift_for(coordinate); }

    ShaftRules rules_;
    double lift_ = 0;
    std::array<visibility::Plane, k_most_planes> planes_;   // the base first; not enlarged
    std::size_t count_ = 0;
    std::array<glm::dvec3, k_most_corners> hull_{};   // corners of piece and light
    std::size_t hull_count_ = 0;
    glm::dvec3 low_{0}, high_{0};
    // The same for vectors, filled up with planes that everything is inside of, and with the first corner.
    template <std::size_t N>
    struct Lanes {
        static constexpr std::size_t k_vector = 8, k_size = (N + k_vector - 1) / k_vector * k_vector;
        alignas(64) std::array<double, k_size> x, y, z, distance;
        std::size_t end = 0;   // a multiple of 8
    };
    friend struct HullTests;
    Lanes<k_most_planes> plane_lanes_;
    Lanes<k_most_corners> hull_lanes_;
};

/// The least of dot(normal, point).
double lowest(const glm::dvec3& normal, std::span<const glm::dvec3> points);

}   // namespace gnomon::area_light
