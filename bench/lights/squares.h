// SPDX-License-Identifier: Apache-2.0
#pragma once
// Squares in place of lights without size: what bench lights and tests of lights with size measure in scenes that have
// none.

#include <array>
#include <memory>

#include "scene/state.h"

namespace gnomon::bench {

/// The corners of a square that faces along a direction, counter-clockwise seen from the front.
std::array<glm::vec3, 4> square_corners(const glm::vec3& centre, const glm::vec3& direction, float side);

/// Whether a light is a point or spot of the file, which becomes a square.
bool becomes_square(const scene::Light& light);

/// A copy of the state's scene in which the point and spot lights are emissive squares, at their present places, and
/// which has no other lights but its emissive surfaces. A square is as bright along its axis as the light.
/// @param only  the number of a square, counted from 0, to have no other; -1: all
std::shared_ptr<const scene::Scene> with_squares(const scene::SceneState& state, float side, int only = -1);

/// The same with one white square at a place.
std::shared_ptr<const scene::Scene> with_square(const scene::SceneState& state, const glm::vec3& centre,
                                                const glm::vec3& direction, float side, float radiance);

}   // namespace gnomon::bench
