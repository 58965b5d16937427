// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shining surfaces as lights: lights without size, placed over each of them, that together send out what it does.
//
// A Lambertian emitter of radiance L and area A sends L A cos(t) candela. n spot lights with the cosine profile and a
// half-angle of 90 degrees, of L A / n each, have the same flux, pi L A, and near enough the same shadows where n is
// 16. The lights stand on nodes below the surface's own and move with it.

#include "scene/scene.h"

namespace gnomon::scene {

struct EmitterOptions {
    float least_radiance = 1;         // luminance; what is dimmer glows, but does not light
    float least_irradiance = 0.01f;   // at half the scene's diagonal; smaller emitters are left out
    int most_lights = 16;             // over the whole scene
    float lift = 0.01f;               // in front of the surface, as a share of the root of its area
};

/// Where a scene has no lights, but untextured surfaces that emit: adds lights that stand for them, and a warning.
/// What is left out because of most_lights is made up for by the others, so that the flux is kept.
/// Call after finish(), before add_default_light.
void add_emitter_lights(Scene& scene, const EmitterOptions& options = {});

/// A flat patch that emits on one side, in the space of a node.
struct EmitterPatch {
    NodeId node = none;    // none: world
    glm::vec3 normal{0};   // unit, the side that emits
    glm::vec3 radiance{0};
    std::vector<glm::vec3> triangles;   // three corners each
    float area = 0;
};

/// Adds `count` spot lights over a patch; call finish() afterwards.
/// @param share  of the patch's flux that they have together
void add_patch_lights(Scene& scene, const EmitterPatch& patch, int count, float share, float lift,
                      const std::string& name);

/// What the walls of a closed room give back of a flux (pi times radiance times area), as ambient light, even
/// everywhere. Stands for indirect light where that is off; nothing where the sky looks in.
void add_room_fill(Scene& scene, const glm::vec3& flux);

}   // namespace gnomon::scene
