// SPDX-License-Identifier: Apache-2.0
#pragma once
// Repairs of meshes that files and hosts bring: directions that are not of unit length, weights of joints that do not
// sum to one. What is proper already keeps its bits where a tolerance says so.
//
// Cost: linear in vertices and triangles.

#include <cstddef>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::scene {

/// A vector shorter than this is rounding, not a direction.
inline constexpr float k_least_direction = 1e-4f;

/// The direction of a vector of any finite length.
/// @param otherwise  returned if the vector is shorter than k_least_direction
glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise);

/// A unit vector that is perpendicular to a unit vector.
glm::vec3 perpendicular_to(const glm::vec3& normal);

/// Gives normals that are zero the normal of the triangles around the vertex, weighted by area; +Z where these have no
/// area. Triangles must refer to existing vertices.
void fill_normals(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                  std::span<glm::vec3> normals);

/// Scales the weights of each vertex, at least 0 and finite, so that they sum to one. A vertex whose weights are all
/// zero follows its first joint.
/// @param weights    up to two sets; an empty one has no weights
/// @param tolerance  sums within this of one are left as they are; negative: none are
/// @returns the number of vertices that were changed
std::size_t normalize_weights(std::span<std::vector<glm::vec4>> weights, float tolerance);

}   // namespace gnomon::scene
