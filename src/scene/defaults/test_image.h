// SPDX-License-Identifier: Apache-2.0
#pragma once
// A small square image of which surface each pixel shows, drawn into a depth buffer. It judges default cameras and
// lights: what a camera would see, and whether that is enough. A function of the scene and the camera alone.
//
// Cost: linear in triangles; small triangles that cover no pixel's centre are not seen, as rays would not hit them.

#include <vector>

#include "scene/state.h"

namespace gnomon::scene {

struct TestPixel {
    float depth = k_infinity;   // of what a camera ray sees, along the view's axis; infinite: nothing
    float first = k_infinity;   // of the first surface, seen or not: camera rays pass the backs of one-sided ones
    ObjectId object = none;
    std::uint32_t triangle = 0;
    bool from_behind = false;   // a double-sided surface's back
    glm::vec3 position{0};      // world space
    glm::vec3 normal{0};        // unit, geometric, towards the camera
};

struct TestImage {
    int side = 0;
    std::vector<TestPixel> pixels;   // rows from the top

    /// The fraction of all pixels that show a surface.
    float shown() const;
    /// Of the pixels in which there is a surface, the fraction that show the first one. 1 without any.
    float shown_of_all() const;
};

struct TestImageOptions {
    double vertical_fov = 0.7;   // whole angle, radians
    double near = 0;             // above 0
    int side = 64;               // pixels
    bool glass = true;           // false: transparent surfaces are left out
};

/// @param axes  right, up and back of the camera, unit
TestImage draw_test_image(const SceneState& state, const glm::dvec3& eye, const glm::dmat3& axes,
                          const TestImageOptions& options);

}   // namespace gnomon::scene
