// SPDX-License-Identifier: Apache-2.0
#pragma once
// What patches see of each other and of the surroundings.
//
// Each patch casts 32 rays from its places, with a cosine distribution about their normals, against the static scene.
// A ray that meets a patch is a link to it; the irradiance that a patch gets from the others is the mean of their
// radiant exitances over the rays. Where a ray meets a surface that has no patch, such as what other geometry cuts off
// from all places of its cell, it counts as the mean of the other rays that meet surfaces. A ray that leaves the scene
// brings the radiance of the surroundings. Surfaces that do not block light are passed; those that thin it
// (scene::thins_light()) take their part away. The directions of neighbours are turned against each other.
//
// So few rays may miss a bright part of the surroundings, or meet it too often. So eight more rays go to their spots,
// if there are any, and what the others miss of the rest where nothing hides it is divided among those that leave the
// scene.
//
// Cost: 32 to 40 rays a patch, once for a static scene. Memory: 152 bytes a patch; 632 where anything thins light.

#include "patches/surface_patches.h"
#include "patches/surroundings.h"

namespace gnomon::patches {

struct PatchLinks {
    static constexpr std::size_t k_rays = 32;      // of a patch
    static constexpr std::size_t k_to_spots = 8;   // likewise, after those
    static constexpr std::size_t k_all_rays = k_rays + k_to_spots;
    static constexpr std::uint16_t k_none = 0xffff;
    std::vector<std::uint16_t> target;   // k_rays for each patch: the patch that a ray meets, or none
    std::vector<std::uint8_t> leaves;    // k_all_rays for each patch: whether it leaves the static scene
    std::vector<glm::vec3> passes;       // likewise: the part of light that passes what thins it; empty: all of it
    std::vector<float> weight;           // by patch: of each ray that meets a patch
    std::vector<glm::dvec2> turn;        // by patch: cosine and sine of its rays' turn about the normals
    std::vector<float> reach;            // by patch: how far its places are from its middle; infinite if it is not flat
    std::vector<glm::vec3> missed;       // by patch: irradiance that each of k_rays brings if it leaves the scene,
                                         // besides its own
    std::vector<glm::vec3> surroundings;   // by patch: irradiance from beyond the static scene
    std::size_t bytes() const
    {
        return target.size() * (sizeof(std::uint16_t) + sizeof(std::uint8_t)) +
               (weight.size() + reach.size()) * sizeof(float) + turn.size() * sizeof(glm::dvec2) +
               (passes.size() + surroundings.size() + missed.size()) * sizeof(glm::vec3);
    }
};

PatchLinks link_patches(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays,
                        const Surroundings& surroundings, Tasks& tasks);

/// What encloses a dynamic object.
struct BoundingSphere {
    glm::vec3 centre{0};
    float radius = 0;
};

/// A link, or a part of it, that a dynamic object crosses.
struct BlockedLink {
    PatchId from;           // the patch whose ray it is,
    std::uint16_t target;   // and the one that it meets
    glm::vec3 weight;       // of the target's exitance in the irradiance that does not arrive
};
struct BlockedLinks {
    std::vector<glm::vec3> irradiance;   // by patch: what does not arrive, by links and from the surroundings
    std::vector<BlockedLink> links;      // in the order of `from`
};
/// What dynamic objects keep from patches: that of links that they cross, and of the surroundings. A part of the rays
/// of a patch is cast again where a sphere is so wide that it may matter.
/// @param spheres   around the dynamic objects
/// @param exitance  radiant exitance by patch; empty: of the surroundings alone, and no links
BlockedLinks blocked_links(const SurfacePatches& patches, const PatchLinks& links, const scene::SceneState& state,
                           const ray::RayScene& rays, const Surroundings& surroundings,
                           std::span<const BoundingSphere> spheres, std::span<const glm::vec3> exitance, Tasks& tasks);

/// Irradiance that each patch gets from the others.
/// @param exitance  radiant exitance by patch
void gather_links(const PatchLinks& links, std::span<const glm::vec3> exitance, std::span<glm::vec3> irradiance,
                  Tasks& tasks);

}   // namespace gnomon::patches
