// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds where two images differ, as a few rectangles.
//
// The images are compared in tiles. Differing tiles that are side by side form a run, and equal runs one above the
// other form a rectangle, which is then cut down to the pixels that differ. The rectangles depend on the pixels alone.
//
// Cost: reads both images once.

#include <vector>

#include "base/image.h"
#include "base/tasks.h"
#include "gnomon/types.h"

namespace gnomon::image {

/// @param before  of another size than `now`, for example empty: all of `now` counts as different
/// @return disjoint rectangles that contain every pixel of which any bit differs, ordered by their upper edge, then
///         from the left. No row or column at a rectangle's edge is without such a pixel.
std::vector<PixelRectangle> changed_rectangles(const ImageF& before, const ImageF& now, Tasks& tasks);

}   // namespace gnomon::image
