// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts rendered frames to images of a report and compares two of them.

#include "base/tasks.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"

namespace gnomon::bench {

/// The frame as it would be written to a file: exposed, tone-mapped, in sRGB.
Image8 image_of(const Frame& image);

/// A figure of two images of the same size with a slider, and their FLIP error map in the magma colour map. A sentence
/// that states the difference is appended to the caption.
ImageComparison compare_images(const std::string& caption, const std::string& left_name, const Image8& left,
                               const std::string& right_name, const Image8& right, Tasks& tasks);

}   // namespace gnomon::bench
