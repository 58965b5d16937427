// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts linear light to display values: exposure, tone curve, sRGB bytes.
//
// Curves, on linear Rec. 709 colour:
// - neutral: Khronos PBR Neutral (Khronos Group 2024, "PBR Neutral Tone Mapper") keeps hue and the colour of materials,
//   and compresses only values above 0.8 - 0.04.
// - agx: AgX (Sobotka 2022) by the sixth-degree fit of Wrensch 2023 ("Minimal AgX Implementation"), base look.
// - aces: ACES RRT + ODT by the fit of Hill 2016 (in "BakingLab", after Narkowicz and Hill), without its exposure
//   factor.
//
// All are increasing for grey input, map black to at most half a step of 8 bits, and give values in 0 ... 1.

#include <cstdint>
#include <span>

#include "base/math.h"
#include "gnomon/types.h"

namespace gnomon::image {

/// Display-linear colour in 0 ... 1. Negative channels and NaN count as 0, infinite ones as very bright.
glm::vec3 tone_map(ToneMap curve, glm::vec3 linear);

/// The exposure in stops that gives the image a pleasant brightness: it maps the log-average of the lit pixels, without
/// the darkest and the brightest few, to a fixed key [after Reinhard et al. 2002, 3.1]. The result depends on the
/// pixels only: an integer histogram makes it independent of order and threads. 0 for a black image.
/// @param rgb  linear, three values per pixel
double auto_exposure(std::span<const float> rgb);

/// Applies exposure, tone curve and sRGB encoding.
/// @param rgb  linear, three values per pixel
/// @param out  one byte per value
void encode_srgb8(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint8_t> out);
/// The same with 16 bits.
void encode_srgb16(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint16_t> out);

}   // namespace gnomon::image
