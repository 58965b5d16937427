// SPDX-License-Identifier: Apache-2.0
#pragma once
// A point for which shadows are looked up.

#include <cstdint>

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::visibility {

/// One shading point.
struct ShadowPoint {
    glm::vec3 origin{0};   // of its shadow rays: above the surface on the viewer's side
    glm::vec3 normal{0};   // geometric, unit, on that side
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    bool front = true;   // the viewer's side is the front by the winding in world space
};

}   // namespace gnomon::visibility
