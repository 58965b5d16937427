// SPDX-License-Identifier: Apache-2.0
#pragma once
// Computes shading normals for corners that have none in the file.
//
// If the file has smoothing groups, a corner's normal is the mean over the faces of its group that share the vertex. If
// it has none, faces that meet at less than the crease angle are smoothed together. The mean is weighted by the angle
// at the corner [Thuermer and Wuethrich 1998].

#include <span>

#include "io/obj/data.h"

namespace gnomon::io {

struct ObjNormalOptions {
    float crease_angle = static_cast<float>(k_pi / 3);   // radians, between face normals
};

/// Normals of an object's corners, in the order of its faces' corners; zero: flat, use the triangle's own normal.
/// Normals in the file are used, normalised.
/// @param faces  all faces of one object; faces of other objects are not smoothed with them
/// @param positions_used  scratch: as long as data.positions, all k_no_index before and after
std::vector<glm::vec3> corner_normals(const ObjData& data, std::span<const std::uint32_t> faces,
                                      const ObjNormalOptions& options, std::vector<std::uint32_t>& positions_used);

}   // namespace gnomon::io
