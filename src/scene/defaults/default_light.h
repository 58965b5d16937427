// SPDX-License-Identifier: Apache-2.0
#pragma once
// Default lights of places: the sky and the sun, and the light of a closed room.

#include "scene/defaults/interior.h"

namespace gnomon::scene {

/// Adds a sky and a sun: of a courtyard, one whose sun reaches the ground.
/// @param court  none: the open country
/// @param why    begins the warning
void add_sky_and_sun(Scene& scene, const Interior* court, const char* why);

/// Adds a light below the ceiling of a closed room; to a courtyard, a sky and a sun.
void add_light_of_place(Scene& scene, const Interior& place, const char* why);

}   // namespace gnomon::scene
