// SPDX-License-Identifier: Apache-2.0
#pragma once
// Poses between two others: what a host's values are while a camera's shutter is open.
//
// Numbers and colours of lights and materials are blended; the rest, such as types and textures, is that of the first.
// Rotations are blended by normalised quaternions along the shorter way, scales and places linearly, so that what turns
// keeps its size. A matrix that is no product of these is blended element by element. Only sums, products, quotients
// and roots are computed, so the results are the same on every processor.

#include <glm/mat4x4.hpp>
#include <vector>

#include "scene/state.h"
#include "scene/view.h"

namespace gnomon::scene {

/// @param fraction  0: the first; 1: the second
glm::dmat4 pose_between(const glm::dmat4& first, const glm::dmat4& second, double fraction);
/// The positions are blended; the rest is that of the first. @pre both have as many
DeformedMesh pose_between(const DeformedMesh& first, const std::vector<glm::vec3>& second, double fraction);
std::vector<float> pose_between(const std::vector<float>& first, const std::vector<float>& second, double fraction);
Light pose_between(const Light& first, const Light& second, double fraction);
/// Layers are blended if both have them.
Material pose_between(const Material& first, const Material& second, double fraction);
/// The view of a camera that moves, turns and changes its projection.
View view_between(const Camera& first, const glm::dmat4& first_to_world, const Camera& second,
                  const glm::dmat4& second_to_world, Size size, double fraction);

}   // namespace gnomon::scene
