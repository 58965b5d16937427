// SPDX-License-Identifier: Apache-2.0
#pragma once
// Triangles of a polygon by clipping ears [Meisters 1975], in the plane of the polygon's own (Newell) normal.
//
// n corners always give n - 2 triangles, degenerate and self-crossing polygons included: where no ear is left, the
// sharpest remaining corner is taken. Cost: n for convex polygons; n^2 as a rule and n^3 at worst for others, bounded
// by a budget, after which the rest is a fan.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::io {

class PolygonTriangulator {
 public:
    /// Indices into `points`, counter-clockwise as the polygon is. Valid until the next call.
    /// @param points  3 or more
    const std::vector<glm::uvec3>& triangulate(std::span<const glm::vec3> points);

    /// Whether the budget ran out, and some concave polygons may be wrong.
    bool exhausted() const { return budget_ == 0; }

 private:
    bool is_ear(std::size_t previous, std::size_t corner, std::size_t next);

    std::uint64_t budget_ = 200'000'000;   // point-in-triangle tests and corners passed, over all polygons of a file
    std::vector<glm::dvec2> flat_;
    std::vector<std::uint32_t> next_, previous_;
    std::vector<glm::uvec3> triangles_;
};

/// Twice the area times the unit normal, whatever the polygon's shape [Newell; Sutherland et al. 1974].
glm::dvec3 newell_normal(std::span<const glm::vec3> points);

}   // namespace gnomon::io
