// SPDX-License-Identifier: Apache-2.0
#pragma once
// What patches see of each other and of the surroundings.
//
// Each patch casts 32 rays from its places, with a cosine distribution about their normals, against the static scene.
// A ray that meets a patch is a link to it; the irradiance that a patch gets from the others is the mean of their
// radiant exitances over the rays. A ray that leaves the scene brings the radiance of the surroundings. Surfaces that
// do not block light are passed. The directions of neighbours are turned against each other.
//
// Cost: 32 rays a patch, once for a static scene. Memory: 64 bytes a patch.

#include "patches/surface_patches.h"
#include "patches/surroundings.h"

namespace gnomon::patches {

struct PatchLinks {
    static constexpr std::size_t k_rays = 32;   // of a patch
    static constexpr std::uint16_t k_none = 0xffff;
    std::vector<std::uint16_t> target;     // k_rays for each patch: the patch that a ray meets, or none
    std::vector<glm::vec3> surroundings;   // by patch: irradiance from beyond the static scene
    std::size_t bytes() const
    {
        return target.size() * sizeof(std::uint16_t) + surroundings.size() * sizeof(glm::vec3);
    }
};

PatchLinks link_patches(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays,
                        const Surroundings& surroundings, Tasks& tasks);

/// Irradiance that each patch gets from the others.
/// @param exitance  radiant exitance by patch
void gather_links(const PatchLinks& links, std::span<const glm::vec3> exitance, std::span<glm::vec3> irradiance,
                  Tasks& tasks);

}   // namespace gnomon::patches
