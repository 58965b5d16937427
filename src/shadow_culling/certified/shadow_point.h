// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is asked of certified culling: points, as a view sees them.

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::shadow_culling {

/// From where the image is taken: sets how fine parts get, never what they say.
struct CullingView {
    glm::vec3 eye{0};
    float pixel_spread = 0;   // growth of a pixel's width per unit of distance; 0: orthographic
    float pixel_width = 0;    // its width at the eye
};

/// One shading point.
struct ShadowPoint {
    glm::vec3 origin{0};   // where its shadow rays start: above the surface on the viewer's side
    glm::vec3 normal{0};   // geometric, unit, on that side
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    bool front = true;   // the side is that of the world-space winding
};

}   // namespace gnomon::shadow_culling
