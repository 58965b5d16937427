// SPDX-License-Identifier: Apache-2.0
#pragma once
// From linear light to what a screen shows: exposure, tone curve, sRGB bytes.
//
// Curves, on linear Rec. 709 colour:
//   neutral  Khronos PBR Neutral (Khronos Group 2024, "PBR Neutral Tone Mapper"): keeps hue and the colour of
//   materials,
//            compresses only what is brighter than 0.8 - 0.04.
//   agx      AgX (Sobotka 2022) by the sixth-degree fit of Wrensch 2023 ("Minimal AgX Implementation"), base look.
//   aces     ACES RRT + ODT by the fit of Hill 2016 (in "BakingLab", after Narkowicz and Hill), without its factor of
//            exposure.
// All rise along the greys, take black to at most half a step of 8 bits, and give values in 0 ... 1.

#include <cstdint>
#include <span>

#include "base/math.h"
#include "gnomon/types.h"

namespace gnomon::image {

/// Display-linear colour in 0 ... 1. Negative and undefined channels count as 0, infinite ones as very bright.
glm::vec3 tone_map(ToneMap curve, glm::vec3 linear);

/// Stops that bring this image to a pleasant brightness: the log-average of its lit pixels, without the darkest and
/// the brightest few, goes to a fixed key [after Reinhard et al. 2002, 3.1]. From the pixels alone, by an integer
/// histogram: the same whatever order or number of threads made them. 0 for a black image.
/// @param rgb  linear, three a pixel
double auto_exposure(std::span<const float> rgb);

/// Exposes, maps and encodes.
/// @param rgb  linear, three a pixel
/// @param out  as many bytes
void encode_srgb8(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint8_t> out);

}   // namespace gnomon::image
