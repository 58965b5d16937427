// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes made in code: the demo and the tests need no files.

#include <string_view>

#include "scene/scene.h"

namespace gnomon::scene {

/// @param name  what follows "builtin:", e.g. "kinetic" or "spheres?objects=300&dynamic=10"
/// @throws UsageError for an unknown name, parameter, or a value out of range
Scene make_builtin(std::string_view name);

/// 40 frames: a ball between two blocks in a Cornell box, lit by one spot.
Scene make_cornell();
/// 120 frames: a courtyard around a sundial under a turning mobile.
Scene make_kinetic();

struct SpheresOptions {
    int objects = 300;          // 1 to 1,000,000
    double dynamic = 10;        // percent that move in every frame; or
    int dynamic_objects = -1;   // that many, if >= 0
    int vertices = 2037;        // of one sphere: 2 poles + rings; the nearest possible count is taken
    std::uint64_t seed = 1;
    // What stands still is small; k_spheres_near of it stand where dynamic objects pass, all others beside, so that the
    // dynamic objects' surroundings are the same whatever `objects` is.
    bool crowd = false;
};
constexpr int k_spheres_near = 90;
/// Equal spheres in a cube, a part of which moves along closed paths; one spot light sees them all.
Scene make_spheres(const SpheresOptions& options);

}   // namespace gnomon::scene
