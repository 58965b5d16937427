// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images of bench indirect: whole, and crops whose contrast is raised so that patterns show.

#include "bench/indirect/report.h"

namespace gnomon::bench {

/// Direct light and what surfaces send on of an irradiance, by pixel; without reflections. Exposed as `study.direct`.
Image8 lit_image(const IndirectStudy& study, const std::vector<glm::vec3>& irradiance);

struct IndirectCrop {
    int x = 0, y = 0, side = 0;
    double gain = 1;
};
/// The part of the image in which two irradiances differ by the most pattern: differences from their own mean, over
/// how much the smooth one varies there. The gain makes what varies most of this a fifth of what a screen shows.
IndirectCrop most_patterned(Size size, const std::vector<glm::vec3>& smooth, const std::vector<glm::vec3>& patterned);

/// Luminance of an irradiance in the crop, around its own mean there.
Image8 contrast_crop(const IndirectCrop& crop, Size size, const std::vector<glm::vec3>& irradiance);

}   // namespace gnomon::bench
