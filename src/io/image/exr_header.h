// SPDX-License-Identifier: Apache-2.0
#pragma once
// The header of an OpenEXR file, read by ourselves before the library sees the file ["OpenEXR File Layout", Academy
// Software Foundation].
//
// What a header claims decides how much memory a reader takes, so it is held against limits and against the bytes that
// are there: every attribute, every entry of the chunk table and every chunk must lie inside the file. Flat single-part
// images alone: scan lines, or tiles of one level; lossless compression and PXR24.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gnomon/types.h"
#include "io/image/float_image.h"

namespace gnomon::io {

struct ExrHeader {
    int x = 0, y = 0;   // the data window's upper left corner
    Size size;          // of the data window
    std::vector<std::string> channels;
};

/// Whether the bytes begin as an OpenEXR file does.
bool is_exr(std::span<const std::uint8_t> bytes);

/// Checks all that can be checked without decoding.
/// @throws InputError
ExrHeader check_exr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits);

}   // namespace gnomon::io
