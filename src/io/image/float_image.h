// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images as linear light: OpenEXR and Radiance HDR as they are, PNG, JPEG and PPM decoded from sRGB.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/image.h"

namespace gnomon::io {

/// Channels of one OpenEXR file, written or read: an image has one a light. OpenEXR keeps about a kilobyte of each.
constexpr int k_max_exr_channels = 16384;

struct FloatImageLimits {
    int max_side = 16384;
    std::uint64_t max_pixels = 1ull << 25;         // 8192 x 4096
    std::uint64_t max_values = 1ull << 27;         // pixels times channels: 512 MB
    std::uint64_t max_file_bytes = 1ull << 30;     // read into memory whole
    int max_channels = k_max_exr_channels;         // of one file
    std::uint64_t max_values_per_byte = 1 << 12;   // no compression we read packs more into one byte of the file
};

enum class ImageFormat { exr, hdr, other };

/// By content, not by name.
ImageFormat image_format(std::span<const std::uint8_t> bytes);

/// The bytes of an ordinary file; never opens a pipe or a device for reading.
/// @throws InputError
std::vector<std::uint8_t> read_image_bytes(const std::filesystem::path& file, const FloatImageLimits& limits = {});

/// Linear RGB. Grey becomes three equal channels; alpha is left out.
/// @throws InputError
ImageF read_float_image(const std::filesystem::path& file, const FloatImageLimits& limits = {});
/// The same from memory; `name` is for messages.
ImageF decode_float_image(std::span<const std::uint8_t> bytes, const std::string& name,
                          const FloatImageLimits& limits = {});

}   // namespace gnomon::io
