// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads images as linear light: OpenEXR and Radiance HDR as stored, PNG, JPEG and PPM decoded from sRGB.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/image.h"

namespace gnomon::io {

/// Limit on the channels of an OpenEXR file, for writing and reading: a layer may have one per light. OpenEXR takes
/// about a kilobyte for each.
constexpr int k_max_exr_channels = 16384;

struct FloatImageLimits {
    int max_side = 16384;
    std::uint64_t max_pixels = 1ull << 25;         // 8192 x 4096
    std::uint64_t max_values = 1ull << 27;         // pixels times channels: 512 MB
    std::uint64_t max_file_bytes = 1ull << 30;     // the whole file is read into memory
    int max_channels = k_max_exr_channels;         // per file
    std::uint64_t max_values_per_byte = 1 << 12;   // supported compressions pack at most this many values into a byte
};

enum class ImageFormat { exr, hdr, other };

/// Recognises the format by content, not by name.
ImageFormat image_format(std::span<const std::uint8_t> bytes);

/// Reads a regular file; never opens a pipe or a device.
/// @throws InputError
std::vector<std::uint8_t> read_image_bytes(const std::filesystem::path& file, const FloatImageLimits& limits = {});

/// Linear RGB. Grey is copied to three channels; alpha is dropped.
/// @throws InputError
ImageF read_float_image(const std::filesystem::path& file, const FloatImageLimits& limits = {});
/// The same from memory; `name` is for messages.
ImageF decode_float_image(std::span<const std::uint8_t> bytes, const std::string& name,
                          const FloatImageLimits& limits = {});

}   // namespace gnomon::io
