// SPDX-License-Identifier: Apache-2.0
#pragma once
// The thin lens of a camera: rays through its disc, and how wide it shows a point [Potmesil and Chakravarty 1981].
//
// All rays of a place in the image meet in one point of the plane of focus. A pinhole's ray is that of the lens's
// centre. An orthographic view looks through the same lens: from a place of it, all rays are parallel, and slant.

#include "scene/view.h"

namespace gnomon::scene {

struct Lens {
    float radius = 0;   // 0: a pinhole
    float focus = 1;    // distance of the plane that is sharp, along the view's axis

    bool sharp() const { return radius == 0; }
};

/// Height of the sensor that f-numbers refer to, in metres: that of a full-frame camera.
inline constexpr double k_sensor_height = 0.024;

/// The focal length, in metres, that f-numbers of orthographic views refer to, as in Blender's Cycles.
inline constexpr double k_orthographic_focal_length = 1;

/// The radius of a view's lens of an f-number, in metres.
float lens_radius(const View& view, double f_number);

/// The point of the unit disc for a point of the unit square, of equal areas [Shirley and Chiu 1997].
glm::vec2 disc_point(const glm::vec2& square);

/// The view from a place of the lens, which shows the plane of focus where the view does.
/// @param at  in the unit disc, right and up
View through_lens(const View& view, const Lens& lens, const glm::vec2& at);

/// As View::ray(), from a place of the lens.
/// @param at  in the unit disc, right and up
void lens_ray(const View& view, const Lens& lens, float x, float y, const glm::vec2& at, glm::vec3& origin,
              glm::vec3& direction, float& tnear, float& tfar);

/// The diameter of the disc as which a point of this depth is shown, in pixels: of the circle of confusion.
/// @param depth  along the view's axis; infinite for the background, whose disc is infinite in an orthographic view
float circle_of_confusion(const View& view, const Lens& lens, float depth);

}   // namespace gnomon::scene
