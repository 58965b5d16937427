// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shaft from a piece of a receiving triangle to a cluster of polygons: the convex region that contains every
// segment from the piece to the box around the cluster.

#include "area_light/hull_shaft.h"

namespace gnomon::area_light {

/// The box around a cluster.
struct ClusterBox {
    glm::dvec3 low{0}, high{0};
    glm::dvec3 corner(std::size_t k) const
    {
        return {k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z};
    }
    double diagonal() const { return glm::length(high - low); }
};

class ClusterShaft final : public HullShaft {
 public:
    /// @param corner  of the piece, in the receiving triangle's plane
    /// @param normal  unit, the receiver's, on the side where rays start
    /// @param lift    height of the ray origins above the plane
    ClusterShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const ClusterBox& box, double lift,
                 const ShaftRules& rules = {});

    /// Whether any of the box lies above the receiver's plane. Otherwise no light reaches the piece.
    bool rises() const { return rises_; }
    /// A place of the box above the receiver's plane.
    const glm::dvec3& place_above() const { return place_above_; }
    /// How far before their places the longest segments end.
    double most_end_gap() const { return end_gap_; }
    /// Whether a convex polygon keeps at least `clear` away from the box, along one of its axes or the normal given.
    bool keeps_clear(const ClippedTriangle& polygon, const glm::dvec3& normal, double clear) const;

 private:
    ClusterBox box_;
    bool rises_ = false;
    glm::dvec3 place_above_{0};
    double end_gap_ = 0;
};

}   // namespace gnomon::area_light
