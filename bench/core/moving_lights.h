// SPDX-License-Identifier: Apache-2.0
#pragma once
// The same scene with lights that never stand still: what a method that remembers costs when it cannot help.

#include <memory>

#include "scene/scene.h"

namespace gnomon::bench {

struct MovingLightsOptions {
    double radius = 1e-3;   // of every light's circle, in diagonals of the scene's bounds
    double turn = 1e-2;     // radians by which directions swing
    double step = 0.7;      // radians along the circle from frame to frame
};

/// A copy in which every light runs a small circle around its place, and swings, with a step in every frame. Its own
/// movement and visibility stay; nothing else moves.
std::shared_ptr<const scene::Scene> with_moving_lights(const std::shared_ptr<const scene::Scene>& scene,
                                                       const MovingLightsOptions& options = {});

}   // namespace gnomon::bench
