// SPDX-License-Identifier: Apache-2.0
#pragma once
// The built-in studio: a high-dynamic-range environment image of a photographer's studio, made in code.
//
// Large soft boxes stand around a neutral backdrop: the key light in front on the left, a wide fill on the right, a
// ceiling, and two narrow strips behind, so that metals have bright shapes with dark edges to mirror. All of them stand
// more than 20 degrees above the horizon, beyond what a camera that looks down on an object sees behind it. Colours are
// neutral but for a slightly warm key and slightly cool strips. A surface that faces up and sees everything has a
// radiance of about 1.3 times its reflectance, the backdrop one of .14 to .26: so light objects stand out before it.

#include <memory>

#include "scene/environment.h"

namespace gnomon::scene {

/// The radiance from a unit direction; +Z is where the camera usually stands.
glm::vec3 studio_radiance(const glm::vec3& direction);

/// The image, 256 x 128; made once.
std::shared_ptr<const Environment> studio_environment();

}   // namespace gnomon::scene
