// SPDX-License-Identifier: Apache-2.0
#pragma once
// Error metrics of a test image against a reference of the same size and channels.
//
// Sums are in pixel order and double precision, so the bits do not depend on the number of threads. NaN counts as 0 and
// infinity as the largest finite value, except in pixels_different, which compares the values as they are.

#include <optional>

#include "base/image.h"
#include "base/tasks.h"

namespace gnomon::image {

/// Mean over pixels and channels of (test - reference)^2.
double mean_squared_error(const ImageF& test, const ImageF& reference);

/// Mean over pixels and channels of (test - reference)^2 / (reference^2 + 0.01) [Rousselle et al. 2011, "Adaptive
/// Sampling and Reconstruction using Greedy Error Minimization", 6].
double relative_mse(const ImageF& test, const ImageF& reference);

/// 10 log10(peak^2 / mse) in decibels; none for equal images.
std::optional<double> psnr(double mse, double peak);

double max_abs_difference(const ImageF& test, const ImageF& reference);

/// The fraction of pixels of which any channel differs; two NaN are equal.
double pixels_different(const ImageF& test, const ImageF& reference);

/// Structural similarity [Wang et al. 2004, "Image Quality Assessment: From Error Visibility to Structural
/// Similarity"]: Gaussian windows of 11 x 11, sigma 1.5, K1 = 0.01, K2 = 0.03, on the luminance of three channels (else
/// the mean over channels), averaged over all windows that lie inside the image. Where a side is shorter than a window,
/// windows are cut and their weights renormalised.
/// @param range  of the values (L in the paper); > 0
double ssim(const ImageF& test, const ImageF& reference, double range, Tasks& tasks);

}   // namespace gnomon::image
