// SPDX-License-Identifier: Apache-2.0
#pragma once
// What surfaces that thin light let through of lights with size and of environments (scene::thins_light()).
//
// Their visibility is found as if such surfaces were not there, so that what is proven and remembered of it stays true.
// This factor comes on top: the mean of what passes along a fixed set of rays to the light, weighted by the light that
// they bring. No random numbers are used. Cost: some 64 to 120 rays for a point and a light, and none in scenes without
// such surfaces.

#include "environment_light/direction_cells.h"
#include "ray/ray_scene.h"
#include "scene/sized_light.h"
#include "shading/surface.h"

namespace gnomon::trace {

class PassingLight {
 public:
    static constexpr std::size_t k_rays = 64;
    static constexpr std::size_t k_rays_in_mirrors = 16;   // to cells, from what mirrors and glass show

    explicit PassingLight(const ray::RayScene& rays) : rays_(rays), any_(rays.thins_light()) {}
    /// Whether there is anything to do; else every factor is 1.
    bool any() const { return any_; }

    /// @param origin  of shadow rays
    glm::vec3 from_light(const shading::SurfacePoint& s, const glm::vec3& origin, const scene::SizedLight& light);
    /// @param normal  of the surface, shading
    /// @param seen  a bit for each leaf
    /// @param most  rays; with k_rays, those of an image go to the cells that stand in for others, some 100 of them
    glm::vec3 from_cells(const glm::vec3& normal, const glm::vec3& origin,
                         const environment_light::DirectionCells& cells, std::span<const std::uint64_t> seen,
                         std::size_t most = k_rays);

 private:
    glm::vec3 mean();

    const ray::RayScene& rays_;
    bool any_;
    ray::RayQueue queue_;
    std::vector<float> weight_, by_stand_in_;
    std::vector<glm::vec3> passes_;
};

}   // namespace gnomon::trace
