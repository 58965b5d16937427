// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads and writes OpenEXR images with named layers, with the OpenEXR library.
//
// A layer's channel is called "layer.channel" in the file; channels of the image itself (layer "") have no prefix.
// Files are written as 32-bit float unless asked otherwise, and ids as unsigned integers; scan lines from the top, ZIP;
// the bytes depend on the pixels and the metadata only.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnomon/frame.h"
#include "gnomon/image_options.h"
#include "io/image/float_image.h"

namespace gnomon::io {

/// What a file says of its frame. Written as OpenEXR's standard attributes where there are any (framesPerSecond,
/// worldToCamera, worldToNDC, chromaticities), else as "gnomon.NAME".
struct ExrMetadata {
    int frame = 0;   // 0: unknown
    double time = 0, fps = 0, exposure = 0;
    std::string instruction_set;
    // Of column vectors, by column; the camera looks along -Z.
    std::optional<std::array<double, 16>> world_to_camera, world_to_image;
};

/// The number of channels with which an image of this size can be written and read again: k_max_exr_channels, or less
/// if it is wider than 2,047 pixels (1,023 with PIZ).
std::size_t room_in_exr(Size size, ExrCompression compression = ExrCompression::zip);

/// Replaces the file atomically.
/// @throws UsageError    more channels than room_in_exr
/// @throws MissingError  the file cannot be written
void write_exr(const std::filesystem::path& file, Size size, std::span<const Layer> layers,
               const ImageOptions& options = {}, const ExrMetadata& metadata = {});

/// One layer of a file, with memory of its own.
struct ExrLayer {
    std::string name;                    // "" (the image itself), "depth", ...
    std::vector<std::string> channels;   // {"R", "G", "B"}, {"Z"}, ...
    std::vector<float> data;             // rows from the top, channels interleaved
};

/// Writes layers of an image of that size as the other write_exr does.
void write_exr(const std::filesystem::path& file, Size size, std::span<const ExrLayer> layers);

struct ExrImage {
    Size size;
    std::vector<ExrLayer> layers;   // the image itself first if present, then by name
};

/// Half and integer channels are converted to float. Colour channels are in the order R G B A, others by name.
/// @param only  read only this layer ("": the image itself), or one channel by its full name ("shadow.L0"); layers is
///              empty if there is none of that name
/// @throws InputError
ExrImage decode_exr(std::span<const std::uint8_t> bytes, const std::string& name,
                    const std::optional<std::string>& only = {}, const FloatImageLimits& limits = {});

/// Whether a file is a complete OpenEXR image of this size, with all its chunks.
bool is_whole_exr(const std::filesystem::path& file, Size size);

/// Names of the layers in a file, in the order of decode_exr.
std::vector<std::string> exr_layer_names(std::span<const std::uint8_t> bytes, const std::string& name);

}   // namespace gnomon::io
