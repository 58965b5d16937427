// SPDX-License-Identifier: Apache-2.0
#pragma once
// FLIP: estimates the difference that a person perceives when flipping between two images [Andersson et al. 2020,
// "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2)], and its form
// for linear light of any range [Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images",
// Eurographics Short Papers].
//
// Colour: both images are blurred with the contrast sensitivity of the eye at a viewing distance (in Y Cx Cz) and
// compared by HyAB in L*a*b* with the Hunt effect. Features: edges and points of the achromatic channel; where they
// differ, the colour difference is amplified. Each pixel's error is in 0 ... 1.
// Cost: 80 taps of four floats per pixel and image, for each exposure in the HDR form. Memory besides the error map: a
// band of rows per thread.
// Invariants: equal images give 0; the LDR form is symmetric; the bits do not depend on the number of threads.

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
/// @param test, reference  linear RGB of one size; negative values and NaN count as 0
ImageF flip_hdr(const ImageF& test, const ImageF& reference, Tasks& tasks, const FlipOptions& options = {});

/// The range of exposures in stops, at which the brightest to the median pixel of an image are displayed [2021, 3].
struct FlipExposures {
    double first = 0, last = 0;
    int count = 2;
};
FlipExposures flip_exposures(const ImageF& reference);

/// Mean of a one-channel image, summed in pixel order.
double mean_of(const ImageF& map);

/// An error map in the colour map magma, sRGB.
Image8 heat_map(const ImageF& map);

}   // namespace gnomon::image
