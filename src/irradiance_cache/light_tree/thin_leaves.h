// SPDX-License-Identifier: Apache-2.0
#pragma once
// The leaves of light maps where surfaces thin light (scene::thins_light()).
//
// There, each light has two views of each direction. Leaves of the first lie on the first surfaces that its rays hit,
// and those that thin light reflect as far as they are there. Leaves of the second lie on what is lit behind surfaces
// that thin light, and on nothing elsewhere. So no node of the tree mixes both, because its visibility is that of one
// place. What lies between the first and the last such surface along a ray is passed.

#include "ray/thin_hits.h"

namespace gnomon::irradiance_cache {

/// Of the rays of a view: the factors of their leaves' flux; 0 where there is no leaf. Empty where nothing thins light.
/// @param behind   the view is a second one: hits are moved behind surfaces that thin light
/// @param against  what the rays were traced against
std::vector<glm::vec3> find_thin_leaves(const scene::Scene& scene, const ray::RayScene& rays,
                                        const ray::RayQueue& queue, bool behind, ray::Against against, ray::Hits& hits);

}   // namespace gnomon::irradiance_cache
