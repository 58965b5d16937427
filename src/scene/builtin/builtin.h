// SPDX-License-Identifier: Apache-2.0
#pragma once
// Built-in scenes, made in code so that the demo and the tests need no files.

#include <string_view>

#include "scene/scene.h"

namespace gnomon::scene {

/// @param name  the text after "builtin:", e.g. "kinetic" or "spheres?objects=300&dynamic=10"
/// @throws UsageError  unknown name or parameter, or a value out of range
Scene make_builtin(std::string_view name);

/// 40 frames: a ball between two blocks in a Cornell box, lit by one spot.
Scene make_cornell();
/// 120 frames: a courtyard around a sundial under a turning mobile.
Scene make_kinetic();

struct SpheresOptions {
    int objects = 300;          // 1 to 1,000,000
    double dynamic = 10;        // percentage of objects that move in every frame
    int dynamic_objects = -1;   // their number instead, if >= 0
    int vertices = 2037;        // of one sphere: 2 poles + rings; the nearest possible count is taken
    std::uint64_t seed = 1;
    // If set, static objects are small. k_spheres_near of them are placed where dynamic objects pass and all others
    // outside, so that the surroundings of dynamic objects do not depend on `objects`.
    bool crowd = false;
};
constexpr int k_spheres_near = 90;
/// Equal spheres in a cube, some of which move along closed paths; one spot light illuminates all of them.
Scene make_spheres(const SpheresOptions& options);

}   // namespace gnomon::scene
