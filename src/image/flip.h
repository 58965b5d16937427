// SPDX-License-Identifier: Apache-2.0
#pragma once
// FLIP: what a person sees who flips between two images [Andersson et al. 2020, "FLIP: A Difference Evaluator for
// Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2)], and its form for linear light of any range
// [Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics Short Papers].
//
// Colour: both images are blurred as the eye blurs them at a viewing distance (contrast sensitivity in Y Cx Cz), and
// compared by HyAB in L*a*b* with the Hunt effect. Features: edges and points of the achromatic channel; where they
// differ, the colour difference is raised. Each pixel's error is in 0 ... 1.
// Cost: 80 taps of four floats a pixel and image; the HDR form does so for each of its exposures. Memory beyond the
// error map: a band of rows a thread.
// Invariants: equal images give 0; the LDR form is symmetric; the same bits for any number of threads.

#include "base/image.h"
#include "base/tasks.h"

namespace gnomon::image {

struct FlipOptions {
    double pixels_per_degree = 67;   // 0.7 m from a screen 0.7 m and 3840 pixels wide [2020, 4.1]
};

/// @param test, reference  linear RGB of one size; clamped to 0 ... 1
/// @return one channel
ImageF flip_ldr(const ImageF& test, const ImageF& reference, Tasks& tasks, const FlipOptions& options = {});

/// The largest LDR error over a range of exposures, tone-mapped by the ACES fit of Narkowicz 2015.
/// @param test, reference  linear RGB of one size; what is negative or no number counts as 0
ImageF flip_hdr(const ImageF& test, const ImageF& reference, Tasks& tasks, const FlipOptions& options = {});

/// The exposures, in stops, that show an image from its brightest to its median pixel [2021, 3].
struct FlipExposures {
    double first = 0, last = 0;
    int count = 2;
};
FlipExposures flip_exposures(const ImageF& reference);

/// Mean of a one-channel image, summed in order.
double mean_of(const ImageF& map);

/// An error map in the colours of magma, sRGB.
Image8 heat_map(const ImageF& map);

}   // namespace gnomon::image
