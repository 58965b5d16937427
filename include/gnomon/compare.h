// SPDX-License-Identifier: Apache-2.0
#pragma once
// Compares two images: error metrics, and FLIP, which estimates the difference that a person perceives.

#include <filesystem>
#include <optional>
#include <string>

#include "gnomon/error.h"
#include "gnomon/types.h"

namespace gnomon {

/// Options of compare(). gnomon/ranges.h has the range of `threads`.
struct CompareOptions {
    std::string layer;   // layer of OpenEXR files ("depth", "shadow", one channel: "shadow.L0"); "": the image
    bool ssim = true, flip = true;   // the two slow metrics
    /// Writes FLIP's error map here as .png, with the magma colour map, and turns `flip` on; "": none.
    std::filesystem::path heatmap;
    int threads = 0;   // 0: all; at most 1024
};

/// The difference between two images. Values are compared as the files store them: PNG, JPEG and PPM as bytes / 255
/// (sRGB-encoded, alpha included), OpenEXR and Radiance as linear values. If one image is encoded and the other is
/// linear, the encoded one is first converted to linear light.
struct CompareResult {
    Size size;
    double rmse = 0;              // root of the mean squared difference over pixels and channels
    double relmse = 0;            // mean of (a - b)^2 / (b^2 + 0.01)
    std::optional<double> psnr;   // decibels; peak: 1, or the reference's largest value if linear. None: equal images
    std::optional<double> ssim;   // of luminance, or the mean over channels; none if not requested
    std::optional<double> flip;   // mean over pixels: LDR for encoded, HDR for linear images of 1 or 3 channels
    double max_abs = 0;
    double pixels_different = 0;   // fraction of pixels of which any channel differs
};

/// Compares two image files.
/// @param test, reference  PNG, JPEG, PPM, OpenEXR or Radiance HDR files, recognised by their content
/// @throws InputError    a file is missing or invalid
/// @throws UsageError    sizes or channels differ; no such layer; a heat map for channels that FLIP does not support
/// @throws MissingError  the heat map cannot be written
CompareResult compare(const std::filesystem::path& test, const std::filesystem::path& reference,
                      const CompareOptions& options = {});

}   // namespace gnomon
