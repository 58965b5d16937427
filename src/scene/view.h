// SPDX-License-Identifier: Apache-2.0
#pragma once
// Generates primary rays for a camera at a time, and the positions of samples within a pixel.

#include <optional>
#include <string>

#include "base/math.h"
#include "gnomon/types.h"
#include "scene/state.h"

namespace gnomon::scene {

/// A camera in the world for one image size. The vertical field of view is the camera's; the horizontal one follows.
struct View {
    glm::vec3 eye{0};
    glm::vec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};   // unit; right and up scaled by half the view's extent
    /// Lens shift in units of half the view's extent, right and up: {1, 0} moves the principal axis from the image's
    /// centre to its left edge, so that the view shows more of what is on the right.
    glm::vec2 shift{0};
    Size size;
    bool orthographic = false;
    /// Of an orthographic view from a place of a lens, which looks aside: how far its rays go to the right and up for
    /// each unit along `forward`, in units of half the view's extent.
    glm::vec2 skew{0};
    float near = 0;   // along `forward`
    float far = k_infinity;
    float pixel_spread = 0;   // growth of a pixel's width per unit of distance (perspective)
    float pixel_width = 0;    // a pixel's width at the camera (orthographic)

    /// @param x, y  in pixels from the top left corner; (0.5, 0.5) is the first pixel's centre
    void ray(float x, float y, glm::vec3& origin, glm::vec3& direction, float& tnear, float& tfar) const;
    /// The inverse of ray(): where the image shows a point, in pixels from the top left corner, possibly outside the
    /// image. Computed in double precision, because differences between frames are taken.
    /// @return nothing if the point is not in front of a perspective view's eye
    std::optional<glm::dvec2> project(const glm::dvec3& point) const;
    /// Where the image shows what is infinitely far away in a direction, which need not be a unit vector.
    /// @return nothing for an orthographic view, and if the direction does not point forwards
    std::optional<glm::dvec2> project_direction(const glm::dvec3& direction) const;
    friend bool operator==(const View&, const View&) = default;
};

/// @param wanted  as in RenderOptions: a name, an index from 0, or auto: the first
/// @throws UsageError  the scene has no such camera
scene::CameraId find_camera(const scene::Scene& scene, const std::string& wanted);

View make_view(const scene::SceneState& state, scene::CameraId camera, Size size);
/// @param world  from camera space to the world; its scale is ignored
View make_view(const scene::Camera& camera, const glm::dmat4& world, Size size);

/// The place of a camera for an image of a size: `world`, unless the camera adapts to the image (Camera::fit).
glm::dmat4 placed(const scene::Camera& camera, const glm::dmat4& world, Size size);

/// From the space of a view's camera to the world.
glm::dmat4 matrix_of(const View& view);

/// The view rotated by `angle` radians around the vertical axis through `centre`, counter-clockwise seen from above.
View turned(const View& view, const glm::vec3& centre, double angle);

/// Position of sample i of n inside a pixel, in [0, 1)^2: the centre for n = 1, else a rank-1 sequence (Roberts' R2).
/// It is the same for every pixel.
glm::vec2 sample_offset(int i, int n);

/// The samples of a pixel beyond the one at its centre, where samples are adaptive.
inline constexpr int k_refined_samples = 16, k_first_refined_samples = 4;
/// Position of the i-th of them. All of them, and the first few by themselves, are points of a (0, 2)-net in base 2:
/// one in each of so many columns and rows of the pixel, and in each of so many of its squares.
glm::vec2 refined_offset(int i);

}   // namespace gnomon::scene
