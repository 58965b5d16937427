// SPDX-License-Identifier: Apache-2.0
#pragma once
// The filters of FLIP [Andersson et al. 2020, 4.1 and 4.2]: the colour blur of the eye, and detectors of edges and
// points.
//
// All are separable, or sums of two separable filters, so four run at a time, one in each component of a vector. Cost:
// 2 (2 radius + 1) taps per pixel.

#include <vector>

#include "base/math.h"

namespace gnomon::image {

struct FlipFilter {
    int radius = 0;
    std::vector<glm::vec4> across, down;   // 2 radius + 1 taps
};

struct FlipFilters {
    FlipFilter contrast;                 // achromatic, red-green, blue-yellow in two lobes; each has sum 1
    float blue_yellow_weight[2]{0, 0};   // weights of the two lobes
    FlipFilter features;                 // edges in x, points in x, edges in y, points in y
};
FlipFilters make_flip_filters(double pixels_per_degree);

/// An array of rows of four floats.
struct FlipField {
    int width = 0, rows = 0;
    std::vector<glm::vec4> data;

    void resize(int w, int h);
    glm::vec4* row(int y) { return data.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width); }
    const glm::vec4* row(int y) const
    {
        return data.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};

/// Filters the interior of a field.
/// @param border   width around `in` on all sides, at least the filter's radius; `out` has no border
/// @param between  scratch
void apply(const FlipFilter& filter, const FlipField& in, int border, FlipField& between, FlipField& out);

}   // namespace gnomon::image
