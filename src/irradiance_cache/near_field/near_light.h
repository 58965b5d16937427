// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light from surfaces so near that the light map cannot tell them apart: a leaf of it is as wide as they are far. In
// slits and corners that is most of the light.
//
// Short rays, spread by the cosine, find those surfaces; rays from there to the lights say how they are lit. Every
// point uses the same directions, so neighbours differ by what they see and not by chance. What arrives from within the
// radius is near light, fading out towards it; the nodes of the emitters' tree give the rest (far_share()).
//
// Cost: `rays` short rays a point, and one ray a light where they meet a lit surface. Only static surfaces give near
// light; what moves may block it, and is light of its own (DynamicEmitter).

#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

/// Share of the light from a surface that is not near light. 0 within half the radius, 1 from the radius on.
inline float far_share(float distance, float radius)
{
    if (!(distance < radius)) return 1;
    const float t = std::max(0.0f, 2 * distance / radius - 1);
    return t * t * (3 - 2 * t);
}

struct NearOptions {
    float radius = 0;   // scene units; 0: no near light
    int rays = 64;
};

/// Unit vectors around +z, spread by the cosine: a Fibonacci lattice on the disk below.
std::vector<glm::vec3> cosine_directions(int count);

struct NearReceiver {
    glm::vec3 origin{0}, normal{0}, geometric_normal{0};
};

struct NearAnswer {
    glm::vec3 light[3] = {};      // by colour, as RememberedPoint's
    float nearest = k_infinity;   // way to what the rays met first, scene units
};

class NearLight {
 public:
    struct Scratch {
        ray::RayQueue rays, shadow_rays;
        ray::Hits hits;
        std::vector<std::uint8_t> occluded;
        struct Lit {
            std::size_t receiver;
            glm::vec3 light, direction;
        };
        std::vector<Lit> lit;
        std::uint64_t cast = 0;   // counts up
    };
    explicit NearLight(const NearOptions& options = {});
    const NearOptions& options() const { return options_; }
    /// @param against  what may lie near and keep light off: static_only or everything
    void ask(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
             std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers) const;

 private:
    NearOptions options_;
    std::vector<glm::vec3> directions_;
};

}   // namespace gnomon::irradiance_cache
