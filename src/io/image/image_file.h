// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads and writes 8-bit image files. Reading checks the header against limits before it allocates memory. Writing uses
// a temporary file in the same folder and renames it, so a file is either complete or absent.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/image.h"

namespace gnomon {
using Image16 = Image<std::uint16_t>;
}

namespace gnomon::io {

struct ImageLimits {
    int max_side = 16384;
    std::uint64_t max_pixels = 1ull << 26;
    bool stored_values = false;   // ignore gamma and colour space information in PNG files
};

/// What an image will be, and what decoding it takes beside the file's bytes: its pixels and the decoder's own memory.
struct ImageNeeds {
    int width = 0, height = 0, channels = 0;
    std::uint64_t bytes = 0;
};

/// Reads the header of an image as decode_image() does, and takes no memory in proportion to its size.
/// @throws InputError
ImageNeeds image_needs(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits = {});

/// Reads PNG, JPEG, WebP (still images), TGA, BMP or binary PPM, recognised by content; 8 bits per channel (16-bit PNG
/// is reduced); 1 to 4 channels.
/// @throws InputError
Image8 read_image(const std::filesystem::path& file, const ImageLimits& limits = {});
/// The same from memory; `name` is for messages.
Image8 decode_image(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits = {});

/// Writes an 8-bit PNG with 1 to 4 channels; the bytes depend on the pixels and the comment only.
/// @param comment  ASCII text that the file carries; empty: none
/// @throws MissingError if it cannot be written
void write_png(const std::filesystem::path& file, const Image8& image, const std::string& comment = {});

/// The same with 16 bits a channel.
void write_png(const std::filesystem::path& file, const Image16& image, const std::string& comment = {});

/// What a PNG file says of its pixels.
struct PngKind {
    bool alpha = false, deep = false;   // deep: 16 bits a channel
};
/// @throws MissingError  it cannot be read, or is no PNG
PngKind png_kind(const std::filesystem::path& file);

/// Writes a JPEG file of 1 or 3 channels, with colours of full resolution from quality k_full_colors on, and of half
/// below; the bytes depend on the pixels and the quality only.
/// @param quality  0 to 100
/// @throws MissingError if it cannot be written
void write_jpeg(const std::filesystem::path& file, const Image8& image, int quality);
inline constexpr int k_full_colors = 85;

/// Whether a file is a complete JPEG of that size: its markers are followed, its last bytes are the end marker.
bool is_whole_jpeg(const std::filesystem::path& file, int width, int height);

/// The same bytes as of the first write_png, in memory.
/// @throws MissingError  out of memory
std::vector<std::uint8_t> encode_png(const Image8& image, const std::string& comment = {});

/// Whether a file is a complete PNG of that size; the checksums of all chunks are verified.
bool is_whole_png(const std::filesystem::path& file, int width, int height);
/// The comment of such a file, empty if it has none; nothing if the file is not complete or has another size.
std::optional<std::string> comment_of_whole_png(const std::filesystem::path& file, int width, int height);

}   // namespace gnomon::io
