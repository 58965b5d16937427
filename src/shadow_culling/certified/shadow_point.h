// SPDX-License-Identifier: Apache-2.0
#pragma once
// Input of certified culling: shading points, and the view that they are seen in.

#include "base/math.h"
#include "visibility/shadow_point.h"

namespace gnomon::shadow_culling {

using visibility::ShadowPoint;

/// The camera of the image. It determines the size of parts, never their states.
struct CullingView {
    glm::vec3 eye{0};
    float pixel_spread = 0;   // growth of a pixel's width per unit of distance; 0: orthographic
    float pixel_width = 0;    // at the eye
};

}   // namespace gnomon::shadow_culling
