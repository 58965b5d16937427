// SPDX-License-Identifier: Apache-2.0
#pragma once
// Gives light to scenes that have too little of it: objects stand in the studio, on a ground that shows their shadows;
// landscapes and courtyards lie under a sky and a sun; closed rooms have a light below the ceiling.
//
// A scene's own lights and emissive surfaces are enough if they reach at least half of the surfaces in view of its
// camera. Whether something is in between is asked of a coarse grid (SpaceGrid).

#include <optional>

#include "scene/scene.h"

namespace gnomon::scene {

struct SurroundingsOptions {
    std::optional<bool> ground;      // none: with the studio
    float enough_reached = 0.5f;     // of the surfaces in view
    float landscape_side = 15;       // metres: the least longer horizontal side of a landscape
    float landscape_depth = 0.3f;    // at least this fraction of it is the shorter one
    float landscape_height = 0.6f;   // at most this fraction of it is the height
    float landscape_cover = 0.6f;    // at least this fraction of its rectangle shows a surface from above
    float shut_off = 0.5f;           // of the surfaces in view, from which on one-sided shells are opened
    int lights = 16;                 // directional lights that approximate the studio where light maps need points
};

/// Call after finish(), add_emitter_lights() and add_default_camera(). Each addition gives a warning.
void add_surroundings(Scene& scene, const SurroundingsOptions& options = {});

/// The names of the ground's node: one that came with the studio goes when other light replaces that.
inline constexpr const char* k_default_ground = "default ground";
inline constexpr const char* k_wanted_ground = "ground";

/// Adds a ground below everything that the clip shows, as wide as several of the scene: a disc whose material
/// catches_shadows. Finishes the scene.
void add_ground(Scene& scene, const char* name);

/// The fraction of the surfaces in view of a scene's first camera that its lights reach, and leave not so dark that
/// they look black beside the others.
float share_reached(const Scene& scene);

}   // namespace gnomon::scene
