// SPDX-License-Identifier: Apache-2.0
#pragma once
// Points on the surfaces of a scene, spread by area, for estimates: how much of the scene something reaches or shows.

#include <vector>

#include "scene/state.h"

namespace gnomon::scene {

struct SurfacePlace {
    glm::vec3 position{0};   // world space
    glm::vec3 normal{0};     // unit, of the front
    bool one_sided = false;
    bool needs_light = true;   // shows black in the dark: not unlit
};

/// About `count` points, in the order of objects and triangles; the same for the same state.
std::vector<SurfacePlace> surface_points(const SceneState& state, int count);

/// The fraction of the scene's surface, by area, that is seen from around and above it. Glass hides nothing. Nearly 1
/// for most objects, and little for a building whose rooms matter.
float share_seen_from_outside(const SceneState& state);

}   // namespace gnomon::scene
