// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rendered images as figures of a report.

#include "base/tasks.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"

namespace gnomon::bench {

/// As it would be written: exposed, tone-mapped, sRGB.
Image8 image_of(const Frame& image);

/// Two images of one size under a slider, and FLIP's error map in the colours of magma. The caption ends with how far
/// they are apart.
ImageComparison compare_images(const std::string& caption, const std::string& left_name, const Image8& left,
                               const std::string& right_name, const Image8& right, Tasks& tasks);

}   // namespace gnomon::bench
