// SPDX-License-Identifier: Apache-2.0
#pragma once
// The PNG files in which the frames of a video are kept until it is encoded.
//
// They have what its codec has: 8 bits a channel, or 10, which are spread over the 16 of a PNG file; and alpha that is
// not associated. Where nothing covers a pixel, its colour is that of the nearest ones that are covered, because codecs
// mix the colours of neighbours: a black surrounding would darken the edges.

#include <filesystem>
#include <string>

#include "gnomon/frame.h"
#include "video/delivery.h"

namespace gnomon::video {

/// @param stamp  text that the file carries
/// @throws MissingError  the file cannot be written
void write_video_frame(const Frame& frame, const Delivery& delivery, const std::filesystem::path& file,
                       const std::string& stamp);

/// 10 bits of a value of 16, repeated in its lower bits, so that a codec of 10 bits gets exactly these.
constexpr std::uint16_t ten_bits(std::uint16_t value)
{
    const std::uint32_t ten = (std::uint32_t{value} * 1023 + 32767) / 65535;
    return static_cast<std::uint16_t>(ten << 6 | ten >> 4);
}

}   // namespace gnomon::video
