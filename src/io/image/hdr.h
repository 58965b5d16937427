// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads Radiance images (.hdr, RGBE) [Ward 1991, "Real Pixels", Graphics Gems II; Radiance reference, "image file
// format"].
//
// Both run-length schemes and uncompressed pixels are supported; rows from the top, columns from the left (-Y h +X w),
// as all common tools write them. A channel is mantissa * 2^(exponent - 136), divided by the header's exposures.

#include <cstdint>
#include <span>
#include <string>

#include "io/image/float_image.h"

namespace gnomon::io {

/// Whether the bytes begin with the signature of a Radiance image.
bool is_hdr(std::span<const std::uint8_t> bytes);

/// Linear RGB.
/// @throws InputError
ImageF decode_hdr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits = {});

}   // namespace gnomon::io
