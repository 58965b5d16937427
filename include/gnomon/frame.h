// SPDX-License-Identifier: Apache-2.0
#pragma once
// A rendered frame: linear light and layers.

#include <filesystem>
#include <string>
#include <vector>

#include "gnomon/frame_times.h"
#include "gnomon/types.h"

namespace gnomon {

/// One layer of an image, 32-bit float, rows from the top, channels interleaved.
struct Layer {
    std::string name;                    // "" (the image itself), "depth", "normal", "albedo", "direct", ...
    std::vector<std::string> channels;   // {"R", "G", "B"}, {"Z"}, {"X", "Y", "Z"}, {"L0", "L1"}
    std::vector<float> data;
};

struct Frame {
    Size size;
    std::vector<Layer> layers;   // the first is the image: linear RGB, Rec. 709 primaries
    double exposure = 0;         // stops, applied by write() and to_srgb8() before tone mapping
    ToneMap tonemap = ToneMap::neutral;
    FrameCounters counters;
    double noise = 0;   // of a reference: the root mean square of its standard error, divided by the image's mean
    double milliseconds = 0;   // of the frame, without loading and writing
    FrameTimes times;          // the same time by stage
    double time = 0;           // scene time in seconds
    int frame = 1;             // of the clip; 0 if a time was given
    /// No light is missing because of FrameInput::indirect_ray_limit; otherwise the next frame of the same input has
    /// more of it.
    bool complete = true;
    Size view_size{};                  // of the rendered view, which overlays surround with titles
    int view_left = 0, view_top = 0;   // and its place in the image

    const Layer* layer(const std::string& name) const;
    /// Applies exposure, tone mapping and sRGB encoding. Returns width * height * 3 bytes.
    std::vector<std::uint8_t> to_srgb8() const;
    /// Writes .png (tone-mapped) or .exr (all layers, linear, without exposure). The file is replaced atomically.
    /// @throws UsageError    another extension; more channels than fit an .exr: 16,384, or fewer if the image is wider
    ///         than 2,047 pixels
    /// @throws MissingError  the file cannot be written
    void write(const std::filesystem::path& file) const;
};

}   // namespace gnomon
