// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenEXR images with named layers, through the OpenEXR library.
//
// A layer's channel is called "layer.channel" in the file; those of the image itself (layer "") by their own name.
// Written as 32-bit float, scan lines from the top, ZIP: the bytes depend on the pixels alone.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnomon/frame.h"
#include "io/image/float_image.h"

namespace gnomon::io {

/// How many channels an image of this size may have, so that it can be written and read again: k_max_exr_channels, or
/// less where it is wider than 2,047 pixels.
std::size_t room_in_exr(Size size);

/// The file appears whole or not at all.
/// @throws UsageError for more channels than room_in_exr; MissingError if it cannot be written
void write_exr(const std::filesystem::path& file, Size size, std::span<const Layer> layers);

struct ExrImage {
    Size size;
    std::vector<Layer> layers;   // the image itself first if there is one, then by name
};

/// Half and integer channels become float. Colour channels come in the order R G B A, others by name.
/// @param only  read this layer alone ("": the image itself), or one channel by its full name ("shadow.L0"); layers
/// is
///              empty if there is none of that name
/// @throws InputError
ExrImage decode_exr(std::span<const std::uint8_t> bytes, const std::string& name,
                    const std::optional<std::string>& only = {}, const FloatImageLimits& limits = {});

/// Whether a file is an OpenEXR image of this size with nothing missing: all its chunks are there.
bool is_whole_exr(const std::filesystem::path& file, Size size);

/// Names of the layers in a file, in the order of decode_exr.
std::vector<std::string> exr_layer_names(std::span<const std::uint8_t> bytes, const std::string& name);

}   // namespace gnomon::io
