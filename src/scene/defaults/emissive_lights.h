// SPDX-License-Identifier: Apache-2.0
#pragma once
// Approximates emissive surfaces by point-like lights with the same total flux, for what cannot use them as they are:
// light maps, from which bounced light starts, and rasterised frames. The direct light of traced frames comes from the
// surfaces themselves (scene/sized_light.h), which leaves these lights out.
//
// A Lambertian emitter of radiance L and area A has an intensity of L A cos(t) candela. n spot lights with the cosine
// profile, a half-angle of 90 degrees and L A / n each have the same flux, pi L A, and nearly the same shadows where n
// is 16. The lights are placed on children of the surface's node and move with it.

#include "scene/scene.h"

namespace gnomon::scene {

struct EmitterOptions {
    int most_lights = 16;   // in the whole scene
    float lift = 0.01f;     // distance from the surface, as a fraction of the square root of its area
    bool fill = true;       // add_room_fill(), in a scene without other lights
};

/// Adds lights that approximate the emissive surfaces of a scene, whatever other lights it has (Light::of_surface), and
/// a warning if it has none. Textured surfaces count with their mean radiance. The flux of surfaces that are dropped
/// because of most_lights is distributed over the others. Meshes with keys, targets or
/// skins are left out; others whose vertices a host hands over count as they are at rest. Call after finish(), before
/// add_default_light.
void add_emitter_lights(Scene& scene, const EmitterOptions& options = {});

/// A flat patch that emits on one side, in the space of a node.
struct EmitterPatch {
    NodeId node = none;    // none: world
    glm::vec3 normal{0};   // unit, the side that emits
    glm::vec3 radiance{0};
    std::vector<glm::vec3> triangles;   // three corners each
    float area = 0;
    bool two_sided = false;   // emits on the other side as well
};

/// Adds `count` spot lights over a patch; call finish() afterwards.
/// @param fraction  fraction of the patch's flux that the lights have together
/// @param like  its name and marks are those of the lights
void add_patch_lights(Scene& scene, const EmitterPatch& patch, int count, float fraction, float lift,
                      const Light& like);

/// Adds the light that the walls of a closed room reflect of a flux (pi times radiance times area), as uniform ambient
/// light. It is used where indirect light is off; does nothing if the room is open to the sky.
void add_room_fill(Scene& scene, const glm::vec3& flux);

}   // namespace gnomon::scene
