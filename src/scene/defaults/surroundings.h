// SPDX-License-Identifier: Apache-2.0
#pragma once
// Gives light to scenes that have too little of it: objects stand in the studio, on a ground that shows their shadows;
// landscapes and courtyards lie under a sky and a sun; closed rooms have a light below the ceiling.
//
// A scene's own lights and emissive surfaces are enough if they reach at least half of the surfaces in view of its
// camera. Where the default camera also shows what is beyond them, a dim studio stands around what they light, because
// it would be black there. Whether something is in between is asked of a coarse grid (SpaceGrid).

#include <optional>

#include "scene/defaults/default_view.h"
#include "scene/scene.h"

namespace gnomon::scene {

struct SurroundingsOptions {
    std::optional<bool> ground;      // none: with the studio
    float enough_reached = 0.5f;     // of the surfaces in view
    float enough_filled = 0.9f;      // of the default camera's image, by surfaces: nothing else needs surroundings
    float fill = 0.25f;              // the studio's light on what faces up, of what own lights bring; 0: no fill
    float landscape_side = 15;       // metres: the least longer horizontal side of a landscape
    float landscape_depth = 0.3f;    // at least this fraction of it is the shorter one
    float landscape_height = 0.6f;   // at most this fraction of it is the height
    float landscape_cover = 0.6f;    // at least this fraction of its rectangle shows a surface from above
    float shut_off = 0.5f;           // of the surfaces in view, from which on one-sided shells are opened
    int lights = 16;                 // directional lights that approximate the studio where light maps need points
};

/// Call after finish(), add_emitter_lights() and add_default_camera(). Each addition gives a warning.
/// @param survey  what add_default_camera() found out about the same scene, if anything
void add_surroundings(Scene& scene, const SurroundingsOptions& options = {}, const Survey& survey = {});

/// The names of the ground's node: one that came with the studio goes when other light replaces that.
inline constexpr const char* k_default_ground = "default ground";
inline constexpr const char* k_wanted_ground = "ground";

/// Adds a ground below everything that the clip shows, as wide as several of the scene: a disc whose material
/// catches_shadows. Finishes the scene.
void add_ground(Scene& scene, const char* name);

/// What a scene's lights reach of the surfaces in view of its first camera.
struct Reached {
    float share = 0;    // of these surfaces, and not so dark that they look black beside the others
    float filled = 0;   // of a square image, by surfaces
    float bright = 0;   // luminance of the irradiance that nine tenths do not exceed
};
Reached reached_by_lights(const Scene& scene);

}   // namespace gnomon::scene
