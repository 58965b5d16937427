// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/image_header.h"

#include <cstring>

namespace gnomon::io::gltf {

namespace {

constexpr int k_max_checked = 1000;   // chunks or markers to check in an unused image

}   // namespace

ImageFormat format_of(std::span<const std::uint8_t> bytes)
{
    constexpr std::uint8_t png[] = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
    constexpr std::uint8_t jpeg[] = {0xff, 0xd8, 0xff};
    const auto begins = [&](std::span<const std::uint8_t> magic) {
        return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
    };
    constexpr std::uint8_t riff[] = {'R', 'I', 'F', 'F'}, webp[] = {'W', 'E', 'B', 'P'};
    if (begins(riff) && bytes.size() >= 12 && std::memcmp(bytes.data() + 8, webp, sizeof webp) == 0)
        return ImageFormat::webp;
    return begins(png) ? ImageFormat::png : begins(jpeg) ? ImageFormat::jpeg : ImageFormat::other;
}

std::string header_fault(std::span<const std::uint8_t> b)
{
    const auto u16 = [&](std::size_t i) { return static_cast<std::size_t>(b[i]) << 8 | b[i + 1]; };
    const char* ends = "the image ends within its header";
    // Walk the chunks of a PNG up to the first IDAT.
    if (format_of(b) == ImageFormat::png) {
        int chunks = 0;
        for (std::size_t i = 8; i + 8 <= b.size() && ++chunks <= k_max_checked;) {
            const std::size_t length = u16(i) << 16 | u16(i + 2);
            if (std::memcmp(&b[i + 4], "IDAT", 4) == 0) return {};
            if (i == 8 && (std::memcmp(&b[i + 4], "IHDR", 4) != 0 || length != 13))
                return "the PNG has no proper header";
            constexpr std::size_t around = 12;   // length, type and checksum of a chunk
            if (length > b.size() - i - 8) return ends;
            i += length + around;
        }
        return chunks > k_max_checked ? "" : ends;
    }
    // Walk the markers of a JPEG up to the frame header.
    if (format_of(b) == ImageFormat::jpeg) {
        int markers = 0;
        for (std::size_t i = 2; i + 4 <= b.size() && ++markers <= k_max_checked;) {
            if (b[i] != 0xff) return "the JPEG's markers are broken";
            const std::uint8_t marker = b[i + 1];
            if (marker == 0xff) {
                ++i;   // fill byte
                continue;
            }
            const std::size_t length = u16(i + 2);
            if (length < 2) return "a JPEG marker's length is too small";
            const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
            if (i + 2 + length > b.size()) return ends;
            if (frame) return length < 8 ? "a JPEG frame header is too short" : "";
            i += 2 + length;
        }
        return markers > k_max_checked ? "" : ends;
    }
    return {};
}

}   // namespace gnomon::io::gltf
