// SPDX-License-Identifier: Apache-2.0
#pragma once
// Is a scene something to be in, or something to look at? Rooms, halls and courtyards are seen from inside, and closed
// rooms are not lit by the sun. A function of the geometry alone, by coarse rays through a grid.

#include <optional>

#include "scene/defaults/space_grid.h"

namespace gnomon::scene {

struct InteriorOptions {
    int lattice = 14;                             // points along the longest side that are asked what they see
    float enclosed = 0.7f;                        // a point is inside if so much of what it sees are surfaces facing it
    float share = 0.25f;                          // the scene is an interior if so many of its points are
    float covered = 0.98f;                        // it has a roof if above so many of these is one
    float eye_heights[3] = {0.15f, 0.3f, 0.5f};   // above the floor, as a share of the whole height
};

struct Interior {
    bool covered = false;   // no sky above
    glm::vec3 eye{0};
    glm::vec3 direction{0, 0, -1};   // unit, level
    double vertical_fov = 1.0;       // radians
};

/// Nothing: the scene is an object, seen from outside.
std::optional<Interior> find_interior(const Scene& scene, const InteriorOptions& options = {});

}   // namespace gnomon::scene
