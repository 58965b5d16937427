// SPDX-License-Identifier: Apache-2.0
#pragma once
// Truevision TGA and Windows bitmaps (BMP), decoded by stb_image. It takes missing bytes for zeros and looks at sizes
// late; both are therefore checked before: a file that ends early is refused, and no memory is taken for it.

#include <span>
#include <string>

#include "io/image/image_file.h"

namespace gnomon::io {

/// Whether a file begins with a header of a BMP that can be read, or of any other BMP.
bool is_bmp(std::span<const std::uint8_t> bytes);
/// Whether a file has a sensible header of a TGA, which has no magic number. Ask for all other formats before.
bool is_tga(std::span<const std::uint8_t> bytes);

/// Size and channels of a whole file; what its decoder takes beside the pixels.
/// @throws InputError  it is truncated, or of a kind that is not read
ImageNeeds bmp_needs(std::span<const std::uint8_t> bytes, const std::string& name);
ImageNeeds tga_needs(std::span<const std::uint8_t> bytes, const std::string& name);

/// Decodes either. @pre the needs were asked for, and are granted
Image8 decode_with_stb(std::span<const std::uint8_t> bytes, const std::string& name);

}   // namespace gnomon::io
