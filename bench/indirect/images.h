// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images of bench indirect: the whole frame, and crops with enhanced contrast that make patterns visible.

#include "bench/indirect/report.h"

namespace gnomon::bench {

/// The frame lit directly and by an irradiance per pixel, without reflections, with the exposure of `study.direct`.
/// @param with_direct  false: by the irradiance alone
Image8 lit_image(const IndirectStudy& study, const std::vector<glm::vec3>& irradiance, bool with_direct = true);

struct IndirectCrop {
    int x = 0, y = 0, side = 0;
    double gain = 1;
};
/// The square of the image in which `patterned` shows the strongest pattern: the standard deviation of the difference
/// of the two irradiances, relative to that of `smooth`. The gain scales the larger deviation to a fifth of the range
/// of a screen.
IndirectCrop most_patterned(Size size, const std::vector<glm::vec3>& smooth, const std::vector<glm::vec3>& patterned);

/// The luminance of an irradiance in the crop, relative to its mean there and amplified by the gain.
Image8 contrast_crop(const IndirectCrop& crop, Size size, const std::vector<glm::vec3>& irradiance);

}   // namespace gnomon::bench
