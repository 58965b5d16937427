// SPDX-License-Identifier: Apache-2.0
#pragma once
// The place for which the visibility of a node from a point is tested.
//
// The surfaces of a wide node face many directions: tiles and their joints, two walls, foliage. What its light brings
// to a point is that of the surfaces which face the point (point_kernels.h). If its sample lies on another one, the
// surface itself would occlude it, and what does not face the point would be left out twice. A place on a surface that
// faces the point takes the sample's part.
//
// Cost: a comparison where all surfaces of a node face alike or the sample faces the point; else four nodes per level.

#include "irradiance_cache/light_tree/light_tree.h"

namespace gnomon::irradiance_cache {

/// A point that light arrives at.
struct FacingPoint {
    glm::vec3 origin{0}, normal{0}, horizon{0};   // as of CachePoint
};

/// The node's sample if its surface faces the point; else the place of a leaf below that does, on the way of those
/// children that bring most light. If that one does not, either, or lies below the point's horizon, the sample.
glm::vec3 facing_place(const LightTree& tree, NodeId node, const FacingPoint& point);

}   // namespace gnomon::irradiance_cache
