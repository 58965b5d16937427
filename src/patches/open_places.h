// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much of each patch is open to light while dynamic objects stand on it.
//
// A box on the ground covers places of the patches around its foot. A patch gives off the mean of what its places give,
// and so less than what is seen of it beside the box does. Whoever sees a patch from near by, past the box, divides by
// the part that is open.
//
// Cost: up to five rays for each place of the patches that the spheres around dynamic objects meet.

#include <vector>

#include "patches/patch_links.h"

namespace gnomon::patches {

/// Whether dynamic objects cover a place of a static surface in every direction: by their insides, as a box does that
/// stands on it, or from less far than `near`. Thread-safe. Cost: up to five rays.
/// @param place   just above the surface
/// @param normal  of the surface there, unit
bool is_covered(const ray::RayScene& rays, const glm::vec3& place, const glm::vec3& normal, float near);

/// The part of a patch's places, by area, that no dynamic object covers: by its inside, or from so near that little
/// light arrives. By patch; empty: all is open.
/// @param spheres  around the dynamic objects
std::vector<float> open_parts(const SurfacePatches& patches, const ray::RayScene& rays,
                              std::span<const BoundingSphere> spheres, Tasks& tasks);

}   // namespace gnomon::patches
