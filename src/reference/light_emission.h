// SPDX-License-Identifier: Apache-2.0
#pragma once
// Samples rays that leave lights, for the path-traced reference: where they end, light arrives.
//
// A light is chosen in proportion to its estimated power. Rays of point lights are uniform over the sphere, those of
// spots over their cone. Directional lights have no such rays, because few of them would meet what is in view; nor have
// emissive surfaces and the background, whose light is spread more evenly.
//
// Cost: a sample is a search over the lights.

#include <span>
#include <vector>

#include "ray/ray_scene.h"
#include "scene/state.h"

namespace gnomon::reference {

/// A ray that leaves a light.
struct EmittedRay {
    glm::vec3 origin{0}, direction{0};   // unit
    std::size_t light = 0;               // its place in the list of lights
};

class LightEmission {
 public:
    /// @param lights  those that take part
    LightEmission(const scene::SceneState& state, const ray::RayScene& rays, std::span<const scene::LightId> lights);

    /// No light has rays.
    bool empty() const { return !(total_ > 0); }
    /// Light drawn as a surface does not shadow itself: rays meet nothing nearer than this.
    float nearest() const { return nearest_; }
    /// Not when empty(). All numbers in [0, 1).
    EmittedRay sample(float choice, const glm::vec2& direction) const;
    /// Density per steradian with which sample() returns a direction of a light, by its place in the list. 0: never.
    float density(std::size_t light, const glm::vec3& direction) const;

 private:
    const scene::SceneState& state_;
    std::vector<scene::LightId> lights_;
    std::vector<double> sums_;          // of powers, up to and with each light
    std::vector<float> least_cosine_;   // of the cone of each
    double total_ = 0;
    float nearest_ = 0;
};

}   // namespace gnomon::reference
