// SPDX-License-Identifier: Apache-2.0
#pragma once
// Pairs of static triangles that form a planar convex quadrilateral, as modellers' polygons do after triangulation. The
// two hide one run of places along a row, and are tested together.
//
// Cost: some ten nanoseconds per triangle, once. Memory: 8 bytes per triangle.

#include "area_light/blocked_places.h"

namespace gnomon::area_light {

class PlanarPairs {
 public:
    explicit PlanarPairs(const visibility::StaticTriangles& triangles);

    /// The other triangle of a pair; no_triangle for one by itself.
    visibility::TriangleId partner(visibility::TriangleId id) const { return pairs_[id].partner; }
    /// Makes a list of triangles with these ids, ascending; pairs of which both are among them become one entry.
    void gather(const visibility::StaticTriangles& triangles, std::span<const visibility::TriangleId> ids,
                TriangleList& list) const;
    std::size_t bytes() const { return pairs_.size() * sizeof(pairs_[0]); }

 private:
    struct Pair {
        visibility::TriangleId partner = visibility::no_triangle;
        std::uint8_t edge = 0;   // of the triangle with the smaller id, that both share
        std::uint8_t apex = 0;   // the partner's corner beyond it
    };
    std::vector<Pair> pairs_;
};

}   // namespace gnomon::area_light
