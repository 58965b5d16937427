// SPDX-License-Identifier: Apache-2.0
#pragma once
// Input of certified culling: shading points, and the view that they are seen in.

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::shadow_culling {

/// The camera of the image. It determines the size of parts, never their states.
struct CullingView {
    glm::vec3 eye{0};
    float pixel_spread = 0;   // growth of a pixel's width per unit of distance; 0: orthographic
    float pixel_width = 0;    // at the eye
};

/// One shading point.
struct ShadowPoint {
    glm::vec3 origin{0};   // of its shadow rays: above the surface on the viewer's side
    glm::vec3 normal{0};   // geometric, unit, on that side
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    bool front = true;   // the viewer's side is the front by the winding in world space
};

}   // namespace gnomon::shadow_culling
