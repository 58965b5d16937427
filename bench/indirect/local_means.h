// SPDX-License-Identifier: Apache-2.0
#pragma once
// Compares light with a reference by blocks of an image. A mean over the whole image hides light that is too strong in
// one place and too weak in another; a mean square hides faint light that is wrong everywhere.

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gnomon/types.h"

namespace gnomon::bench {

/// A compared point: its pixel, row by row, with its light, the reference's and the standard error of that.
struct ComparedPoint {
    std::size_t pixel = 0;
    glm::vec3 light{0}, reference{0}, error{0};
};

/// Blocks of k_block x k_block pixels whose reference is brighter than k_dark of the mean over all points.
struct LocalMeans {
    static constexpr int k_block = 32;
    static constexpr double k_dark = 0.05, k_bound = 0.1;
    int blocks = 0;
    int off = 0;           // that differ from the reference by more than k_bound
    int surely_off = 0;    // of these: by more than k_bound and twice the reference's standard error
    double least = 1;      // ratio of a block's mean to its reference
    double greatest = 1;   // likewise
};

/// @param width  of the image, in pixels
LocalMeans compare_blocks(std::span<const ComparedPoint> points, int width);

/// Sums of frames: numbers of blocks, and the extremes of all.
LocalMeans& operator+=(LocalMeans& all, const LocalMeans& frame);

}   // namespace gnomon::bench
