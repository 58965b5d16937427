// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shading normals for corners that a file gives none.
//
// Where it has smoothing groups, they decide: a corner's normal is the mean over the faces of its group that share the
// vertex. Where it has none, faces that meet at less than the crease angle are smoothed together. The mean is weighted
// by the angle at the corner [Thuermer and Wuethrich 1998].

#include <span>

#include "io/obj/data.h"

namespace gnomon::io {

struct ObjNormalOptions {
    float crease_angle = static_cast<float>(k_pi / 3);   // radians, between face normals
};

/// Normals of an object's corners, in the order of its faces' corners; zero: flat, the triangle's own is to be used.
/// Those of the file are taken over, to unit length, where they have one.
/// @param faces  of one object: faces of other objects do not count
/// @param positions_used  scratch: as long as data.positions, all k_no_index before and after
std::vector<glm::vec3> corner_normals(const ObjData& data, std::span<const std::uint32_t> faces,
                                      const ObjNormalOptions& options, std::vector<std::uint32_t>& positions_used);

}   // namespace gnomon::io
