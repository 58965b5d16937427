// SPDX-License-Identifier: Apache-2.0
#pragma once
// Enlarges an image of few pixels so that edges between surfaces stay sharp, and are lines instead of stairs.
//
// A place of the enlarged image lies among 4 x 4 pixels, weighted by a cubic B-spline. These pixels vote for the
// surface that the place shows, each with its weight, and the place takes the mean of those that show the winner. So no
// colour crosses an edge, a border between two surfaces becomes a smooth line, and a single pixel amid another surface,
// which has less than half of the weight, leaves no block. Pixels show the same surface if they show the same object
// and normals that are alike, and if no light shines on one of them alone where the surface is flat, so that
// the edges of shadows are lines as well. Pixels in a penumbra show the same surface as those around them.
//
// Cost: about 10 ns for each pixel of the enlarged image, and several times as much along edges.

#include <cstdint>
#include <vector>

#include "base/image.h"
#include "base/math.h"
#include "gnomon/types.h"

namespace gnomon::viewer {

/// What a pixel's centre shows.
struct SeenSurface {
    std::uint32_t object = 0;   // 0: none
    glm::vec3 normal{0};
    float nearness = 0;   // 1 divided by its depth along the camera's axis; 0: none
    // Lights, one bit each: those that shine on it with nothing before them, and those that do not shine on it at all.
    std::uint32_t lit = 0, unlit = 0;
};

struct EnlargedImage {
    Image8 image;
    std::vector<float> nearness;   // by pixel, row by row: of the surface whose colour it has, as SeenSurface has it
};

/// @param image     of three channels
/// @param surfaces  by pixel, row by row
/// @param factor    of width and height, above 0
EnlargedImage enlarged(const Image8& image, const std::vector<SeenSurface>& surfaces, int factor);

/// How many times as wide an image should be for the screen before the screen enlarges it further.
/// @param divisor  what the view's size was divided by for the image
int enlargement(Size image, int divisor);

}   // namespace gnomon::viewer
