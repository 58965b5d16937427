// SPDX-License-Identifier: Apache-2.0
#pragma once
// Decides whether a scene is an interior or an object. Rooms, halls and courtyards are seen from inside, and closed
// rooms are not lit by the sun. The result depends on the geometry only, which is sampled by coarse rays through a
// grid.

#include <optional>

#include "scene/defaults/space_grid.h"

namespace gnomon::scene {

struct InteriorOptions {
    int lattice = 14;         // sample points along the longest side
    float enclosed = 0.7f;    // a point is inside if at least this fraction of directions meets the front of a surface
    float interior = 0.25f;   // the scene is an interior if at least this fraction of its points is inside
    float covered = 0.98f;    // it has a roof if one is above at least this fraction of these points
    float eye_heights[3] = {0.15f, 0.3f, 0.5f};   // above the floor, as fractions of the whole height
};

struct Interior {
    bool covered = false;   // has a roof
    glm::vec3 eye{0};
    glm::vec3 direction{0, 0, -1};   // unit, level
    double vertical_fov = 1.0;       // radians
    bool stage = false;              // seen through its open side, from outside
    glm::vec3 opening[4]{};          // of a stage: the corners of that side
};

/// Returns nothing if the scene is an object, to be seen from outside.
std::optional<Interior> find_interior(const Scene& scene, const InteriorOptions& options = {});

}   // namespace gnomon::scene
