// SPDX-License-Identifier: Apache-2.0
#pragma once
// Validates the header of an OpenEXR file before the library reads the file ["OpenEXR File Layout", Academy Software
// Foundation].
//
// The header determines how much memory a reader allocates. So its claims are checked against limits and against the
// size of the file: every attribute, every entry of the chunk table and every chunk must lie inside the file. Only flat
// single-part images are accepted: scan lines, or tiles of one level; lossless compression and PXR24.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gnomon/types.h"
#include "io/image/float_image.h"

namespace gnomon::io {

/// The name of a channel in a file: "layer.channel", or the channel alone in the layer "".
inline std::string exr_channel_name(const std::string& layer, const std::string& channel)
{
    return layer.empty() ? channel : layer + "." + channel;
}

struct ExrHeader {
    int x = 0, y = 0;   // the data window's upper left corner
    Size size;          // of the data window
    std::vector<std::string> channels;
};

/// Whether the bytes begin with the magic number of OpenEXR.
bool is_exr(std::span<const std::uint8_t> bytes);

/// Checks everything that can be checked without decoding.
/// @throws InputError
ExrHeader check_exr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits);

}   // namespace gnomon::io
