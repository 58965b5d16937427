// SPDX-License-Identifier: Apache-2.0
#pragma once
// Makes every light of a scene move in every frame, to measure what caches cost when they cannot be reused.

#include <memory>

#include "scene/scene.h"

namespace gnomon::bench {

struct MovingLightsOptions {
    double radius = 1e-3;   // radius of each light's circle, in diagonals of the scene's bounds
    double turn = 1e-2;     // amplitude by which directions swing, in radians
    double step = 0.7;      // angle along the circle from frame to frame, in radians
};

/// Returns a copy of the scene in which every light moves along a small circle around its position and swings its
/// direction in every frame. Animation and visibility of the light are kept; everything else is unchanged.
std::shared_ptr<const scene::Scene> with_moving_lights(const std::shared_ptr<const scene::Scene>& scene,
                                                       const MovingLightsOptions& options = {});

}   // namespace gnomon::bench
