// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far two images are apart: errors in numbers, and FLIP, which answers as a person would.

#include <filesystem>
#include <optional>
#include <string>

#include "gnomon/error.h"
#include "gnomon/types.h"

namespace gnomon {

struct CompareOptions {
    std::string layer;               // of OpenEXR files ("depth", "shadow", one channel: "shadow.L0"); "": the image
    bool ssim = true, flip = true;   // the two that take time
    std::filesystem::path heatmap;   // FLIP's error map as .png in the colours of magma; "": none. Turns flip on
    int threads = 0;                 // 0: all; at most 1024
};

/// Values are compared as files hold them: PNG, JPEG and PPM as bytes / 255 (sRGB-encoded, alpha included), OpenEXR and
/// Radiance as they are; where the two differ in this, the encoded one is first brought to linear light.
struct CompareResult {
    Size size;
    double rmse = 0;              // root of the mean squared difference over pixels and channels
    double relmse = 0;            // mean of (a - b)^2 / (b^2 + 0.01)
    std::optional<double> psnr;   // decibels; peak: 1, or the reference's largest value if linear. None: equal images
    std::optional<double> ssim;   // of luminance, or the mean over channels; none if it was not asked for
    std::optional<double> flip;   // mean over pixels: LDR for encoded, HDR for linear images of 1 or 3 channels
    double max_abs = 0;
    double pixels_different = 0;   // fraction of pixels of which any channel differs
};

/// @param test, reference  PNG, JPEG, PPM, OpenEXR or Radiance HDR, told apart by content
/// @throws InputError    for a file that is missing or wrong
/// @throws UsageError    sizes differ; no such layer; different channels; a heat map of something FLIP cannot see
/// @throws MissingError  the heat map cannot be written
CompareResult compare(const std::filesystem::path& test, const std::filesystem::path& reference,
                      const CompareOptions& options = {});

}   // namespace gnomon
