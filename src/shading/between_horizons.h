// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lights with size that lie partly between the two horizons of a point on a smooth mesh (ray/smooth_surface.h): above
// the smooth one, below that of the triangle. What is proven of triangles does not say what such a point sees of them.
//
// Rays say so, to at most k_rays places of the light: from the triangle to those that are before it, from the smooth
// surface to the others. They are few: such points lie in a narrow band where the light of a smooth surface ends.

#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"
#include "scene/sized_light.h"
#include "shading/surface.h"

namespace gnomon::shading {

/// Whether a part of a light lies between the horizons, or may do so.
bool is_partly_between(const SurfacePoint& s, const scene::SizedLight& light);

/// What a point sees of a light. Its memory is reused; one per thread.
class SeenBetween {
 public:
    static constexpr std::size_t k_rays = 64;
    static constexpr std::uint8_t k_whole = 1;   // of a place that is visible

    /// @param origin         where rays from the triangle start
    /// @param smooth_origin  and those from the smooth surface: shading::smooth_origin()
    void find(const ray::RayScene& rays, const SurfacePoint& s, const glm::vec3& origin, const glm::vec3& smooth_origin,
              const scene::SizedLight& light);
    /// Places of the light, and how much of each is visible, up to k_whole: as visible_share() takes them.
    const std::vector<scene::SizedPlace>& places() const { return places_; }
    const std::vector<std::uint8_t>& seen() const { return seen_; }

 private:
    std::vector<scene::SizedPlace> places_;
    std::vector<std::uint8_t> seen_, occluded_;
    ray::RayQueue queue_;
};

}   // namespace gnomon::shading
