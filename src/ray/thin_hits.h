// SPDX-License-Identifier: Apache-2.0
#pragma once
// Closest-hit rays that go on behind surfaces that thin light (light_through.h).

#include <span>
#include <vector>

#include "ray/light_through.h"
#include "ray/ray_scene.h"

namespace gnomon::ray {

/// Whether hit i lies on a surface that thins light.
/// @param surface  out: that point of it, if so
bool hits_thin_surface(const scene::Scene& scene, const RayScene& rays, const Hits& hits, std::size_t i,
                       ThinSurface& surface);

/// Continues some rays behind their hits.
class RaysBehind {
 public:
    /// Replaces the hits of some rays by the next ones. Directions must be unit vectors.
    /// @param queue    of all rays
    /// @param which    rays that have a hit
    /// @param against  what they were traced against
    void find(const RayScene& rays, const RayQueue& queue, std::span<const std::uint32_t> which, Against against,
              Hits& hits);

 private:
    RayQueue queue_;
    Hits hits_;
};

}   // namespace gnomon::ray
