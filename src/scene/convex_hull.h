// SPDX-License-Identifier: Apache-2.0
#pragma once
// The convex hull of points in a plane, and a polygon of few corners within it, which tells that most further points
// would not change the hull.

#include <vector>

#include "base/math.h"

namespace gnomon::scene {

/// Keeps the corners of the convex hull, counter-clockwise [Andrew 1979]. Cost: O(n log n).
void reduce_to_hull(std::vector<glm::dvec2>& points);

/// A polygon whose corners are at most 16 of those of a hull, chosen so that little of the hull lies outside.
class InnerPolygon {
 public:
    InnerPolygon() = default;   // nothing is within
    /// @param hull  as reduce_to_hull() leaves it
    explicit InnerPolygon(const std::vector<glm::dvec2>& hull);

    /// Whether a point lies within, or beyond by at most a millionth of the hull's size.
    bool contains(const glm::dvec2& p) const
    {
        for (const glm::dvec3& side : sides_)
            if (!(side.x * p.x + side.y * p.y <= side.z)) return false;
        return !sides_.empty();
    }

 private:
    std::vector<glm::dvec3> sides_;   // (a, b, c): a x + b y <= c on the inner side
};

}   // namespace gnomon::scene
