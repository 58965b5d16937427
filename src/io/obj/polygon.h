// SPDX-License-Identifier: Apache-2.0
#pragma once
// Triangulates a polygon by ear clipping [Meisters 1975], in the plane of its Newell normal.
//
// n corners always give n - 2 triangles, even for degenerate and self-intersecting polygons: where no ear is left, the
// sharpest remaining corner is cut. Cost: O(n) for convex polygons, usually O(n^2) and at worst O(n^3) for others. A
// budget bounds the cost; once it is used up, the rest becomes a fan.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::io {

class PolygonTriangulator {
 public:
    /// Indices into `points`, counter-clockwise like the polygon. Valid until the next call.
    /// @param points  3 or more
    const std::vector<glm::uvec3>& triangulate(std::span<const glm::vec3> points);

    /// Whether the budget was used up, so that some concave polygons may be wrong.
    bool exhausted() const { return budget_ == 0; }

 private:
    bool is_ear(std::size_t previous, std::size_t corner, std::size_t next);

    // Point-in-triangle tests and corners passed that are left, for all polygons of a file.
    std::uint64_t budget_ = 200'000'000;
    std::vector<glm::dvec2> flat_;
    std::vector<std::uint32_t> next_, previous_;
    std::vector<glm::uvec3> triangles_;
};

/// Twice the area times the unit normal, for any shape of polygon [Newell; Sutherland et al. 1974].
glm::dvec3 newell_normal(std::span<const glm::vec3> points);

}   // namespace gnomon::io
