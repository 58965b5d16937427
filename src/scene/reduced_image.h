// SPDX-License-Identifier: Apache-2.0
#pragma once
// An image as RGBA, halved any number of times: a level of a texture.
//
// Each step is a box filter in linear light that weights colour by alpha, so that transparent texels do not bleed into
// it; an odd last row or column is merged with its neighbour. Rows are computed as they are needed, so that the levels
// in between are never held: beside the result, the memory is that of three rows of each.

#include "base/image.h"

namespace gnomon::scene {

/// @param image          1 to 4 channels: grey, grey + alpha, RGB, RGBA; not empty
/// @param srgb           whether colour channels are sRGB-encoded
/// @param without_alpha  as if the image had no such channel
Image8 reduced_rgba(const Image8& image, bool srgb, int halvings, bool without_alpha = false);

}   // namespace gnomon::scene
