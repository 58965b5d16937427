// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lets camera rays pass surfaces that cameras do not see (Material::hidden_from_camera), such as the shapes of lights.
//
// Cost: nothing for a scene without such materials; otherwise one more closest-hit ray for each surface that is passed.

#include <functional>

#include "ray/ray_scene.h"

namespace gnomon::trace {

/// Whether any material of the scene is hidden from cameras.
bool hides_surfaces(const scene::Scene& scene);

/// Replaces the hits of camera rays on hidden surfaces by what is behind these.
/// @param is_straight  whether a ray of the queue comes from the camera without being reflected or refracted
void pass_hidden_surfaces(const scene::Scene& scene, const ray::RayScene& rays, const ray::RayQueue& queue,
                          const std::function<bool(std::size_t)>& is_straight, ray::Hits& hits);

}   // namespace gnomon::trace
