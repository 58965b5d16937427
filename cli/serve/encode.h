// SPDX-License-Identifier: Apache-2.0
#pragma once
// Encodes images as the answers of `gnomon serve`, in memory.

#include <cstdint>
#include <span>
#include <string>

#include "gnomon/types.h"

namespace gnomon::cli {

/// A PNG of three 8-bit channels.
/// @param pixels  width * height * 3 bytes, from the upper row
/// @throws MissingError  memory does not suffice
std::string encode_png(Size size, std::span<const std::uint8_t> pixels);

/// A TIFF of one channel of 32-bit floats, little-endian and without compression.
/// @param values  width * height of them, from the upper row
std::string encode_tiff(Size size, std::span<const float> values);

}   // namespace gnomon::cli
