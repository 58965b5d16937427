// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images from and to files. Reading checks the header against limits before it allocates; writing goes to a temporary
// name in the same folder and renames, so a file is whole or not there.

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "base/image.h"

namespace gnomon::io {

struct ImageLimits {
    int max_side = 16384;
    std::uint64_t max_pixels = 1ull << 26;
    bool stored_values = false;   // as they are, whatever a PNG says of its gamma and colours
};

/// PNG, JPEG or binary PPM by content, not by name; 8 bits a channel (16-bit PNG is reduced); 1 to 4 channels.
/// @throws InputError
Image8 read_image(const std::filesystem::path& file, const ImageLimits& limits = {});
/// The same from memory; `name` is for messages.
Image8 decode_image(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits = {});

/// 8-bit PNG, 1 to 4 channels; the bytes depend on the pixels alone.
/// @throws MissingError if it cannot be written
void write_png(const std::filesystem::path& file, const Image8& image);

/// The same bytes, in memory.
/// @throws MissingError  out of memory
std::vector<std::uint8_t> encode_png(const Image8& image);

/// Whether a file is a PNG of that size with nothing missing: every chunk's checksum is looked at, up to the last.
bool is_whole_png(const std::filesystem::path& file, int width, int height);

}   // namespace gnomon::io
