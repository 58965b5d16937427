// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sample places of a planar light: where its visibility from a point is tested.
//
// The places lie in rows of 64, one bit each. Rows are slanted against the light's sides, and each begins at another
// fraction of a step, so that an edge of a shadow that moves across the light covers places one by one. (On a regular
// grid, an edge that is parallel to the rows covers a whole row at once, which shows as a step in the image.)
//
// The places of a row lie on a straight line. Therefore the places that one triangle hides from a point are one run of
// bits in each row, found from four divisions for a whole light and a few multiplications a row (blocked_places.h).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::area_light {

inline constexpr int k_row_places = 64;
inline constexpr int k_square_rows = 64;   // rows' distance: 1 / 64 of the light
inline constexpr int k_slant = 8;          // rows that a row rises by from its first to its last place
inline constexpr int k_rows = 80;          // 72 that meet the unit square, padded for vectors

/// One bit for each place.
using PlaceMask = std::array<std::uint64_t, k_rows>;

/// A convex planar polygon that emits light on the side of its normal.
struct LightPolygon {
    std::array<glm::vec3, 4> corner{};   // counter-clockwise seen from the front
    int corners = 0;                     // 3 or 4
    glm::vec3 normal{0};                 // unit
};

bool same_bits(const LightPolygon& a, const LightPolygon& b);

/// A flat light: a polygon, or what some polygons in its plane cover of it.
struct FlatLight {
    LightPolygon outline;
    std::vector<LightPolygon> faces;   // empty: all of the outline

    FlatLight() = default;
    FlatLight(const LightPolygon& all, std::vector<LightPolygon> of = {}) : outline(all), faces(std::move(of)) {}
};

/// Rows as a linear function over the light's plane: a point of the plane lies in row
/// dot(row, point - origin) + LightPlaces::row_at_origin(), a fraction between rows.
struct RowPlane {
    glm::vec3 normal{0};
    glm::vec3 row{0};
};

class LightPlaces {
 public:
    explicit LightPlaces(const FlatLight& light);

    /// The light's outline.
    const LightPolygon& polygon() const { return polygon_; }
    /// The parallelogram that the places lie in: origin + s * side_s + t * side_t, s and t in [0, 1]. It encloses the
    /// polygon.
    const glm::vec3& origin() const { return origin_; }
    const glm::vec3& side_s() const { return side_s_; }
    const glm::vec3& side_t() const { return side_t_; }

    const RowPlane& row_plane() const { return row_plane_; }
    static constexpr float row_at_origin() { return k_slant - 0.5f; }
    /// s where a row begins (t = 0); it rises by `slant` to t = 1.
    static float row_start(int row);
    static constexpr float slant = static_cast<float>(k_slant) / k_square_rows;
    /// Place i of a row lies at t = (i + row_shift(row)) / 64.
    static float row_shift(int row);

    glm::vec2 at(int row, int place) const;
    glm::vec3 position(int row, int place) const
    {
        const glm::vec2 st = at(row, place);
        return origin_ + st.x * side_s_ + st.y * side_t_;
    }
    /// The places inside the light.
    const PlaceMask& inside() const { return inside_; }
    int count() const { return count_; }

 private:
    void mark_inside(const LightPolygon& face);

    LightPolygon polygon_;
    glm::vec3 origin_{0}, side_s_{0}, side_t_{0};
    RowPlane row_plane_;
    PlaceMask inside_{};
    int count_ = 0;
};

/// The number of set bits.
int count_places(const PlaceMask& mask);

}   // namespace gnomon::area_light
