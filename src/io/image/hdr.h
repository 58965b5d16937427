// SPDX-License-Identifier: Apache-2.0
#pragma once
// Radiance images (.hdr, RGBE) [Ward 1991, "Real Pixels", Graphics Gems II; Radiance reference, "image file
// format"].
//
// Both run-length schemes and plain pixels; rows from the top, columns from the left (-Y h +X w), as every tool writes
// them. A channel is mantissa * 2^(exponent - 136), divided by the header's exposures.

#include <cstdint>
#include <span>
#include <string>

#include "io/image/float_image.h"

namespace gnomon::io {

/// Whether the bytes begin as a Radiance image does.
bool is_hdr(std::span<const std::uint8_t> bytes);

/// Linear RGB.
/// @throws InputError
ImageF decode_hdr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits = {});

}   // namespace gnomon::io
