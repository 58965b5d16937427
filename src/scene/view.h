// SPDX-License-Identifier: Apache-2.0
#pragma once
// The eye: a camera at a time, as a generator of primary rays, and where in a pixel samples lie.

#include <string>

#include "base/math.h"
#include "gnomon/types.h"
#include "scene/state.h"

namespace gnomon::scene {

/// A camera placed in the world, for one image size. The vertical field of view is the camera's; the width follows.
struct View {
    glm::vec3 eye{0};
    glm::vec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};   // unit; right and up scaled by half the view's extent
    Size size;
    bool orthographic = false;
    float near = 0;   // along `forward`
    float far = k_infinity;
    float pixel_spread = 0;   // what a pixel's width grows by per unit of distance (perspective)
    float pixel_width = 0;    // its width at the eye (orthographic)

    /// @param x, y  in pixels from the top left corner; (0.5, 0.5) is the first pixel's centre
    void ray(float x, float y, glm::vec3& origin, glm::vec3& direction, float& tnear, float& tfar) const;
};

/// @param wanted  as in RenderOptions: a name, a number from 0, or auto: the first
/// @throws UsageError  the scene has no such camera
scene::CameraId find_camera(const scene::Scene& scene, const std::string& wanted);

View make_view(const scene::SceneState& state, scene::CameraId camera, Size size);

/// The same view after `angle` radians of a walk around the vertical axis through `centre`, counter-clockwise from
/// above.
View turned(const View& view, const glm::vec3& centre, double angle);

/// Place of sample i of n inside a pixel, in [0, 1)^2: the centre for one, else a rank-1 sequence (Roberts' R2), the
/// same for every pixel.
glm::vec2 sample_offset(int i, int n);

}   // namespace gnomon::scene
