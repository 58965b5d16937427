// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sums of the lobe filter (lobe_filter.h) over the neighbours of a row of pixels.
//
// As many pixels are summed at once as the processor's vectors have numbers. Each computes what the references of
// lobe_reuse.cpp do for a pixel by itself, in the same order, so the bits are those of any other instruction set.

#include "trace/lobe_window.h"

namespace gnomon::trace {

/// Which neighbours count, and how far.
struct LobeSharing {
    float near;   // square of LobeFilterOptions::near
    Likeness likeness;
};

/// Finds how far the lobes around a row of pixels are the same for its rays, and sums how many count: Window::same,
/// Window::covered, Window::counted.
/// @param even        how far, by the square of the difference
/// @param y           of the tile
/// @param first, end  the pixels of the row that have lobes
void find_same(LobeImage::Window& window, const LobeSharing& sharing, const Likeness& even, int y, int first, int end);

/// Sums how densely the pixels around cast rays to where the rays of a row end: Window::density.
void sum_densities(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end);

/// Sums what the rays of a row of pixels and of their neighbours bring, each as often as the pixel's own lobe would
/// meet its end: Window::light, Window::weight, Window::open.
void sum_rays(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end);

/// Sums what the pixels around a row have found, in the same place.
void sum_means(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end);

}   // namespace gnomon::trace
