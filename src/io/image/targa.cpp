// SPDX-License-Identifier: Apache-2.0
#include "io/image/targa.h"

#include <fmt/format.h>
#include <stb/stb_image.h>

#include <cstring>
#include <limits>
#include <memory>

#include "base/interruption.h"
#include "gnomon/error.h"

namespace gnomon::io {

namespace {

// Little-endian numbers of a header.
std::uint64_t u16(std::span<const std::uint8_t> b, std::size_t at)
{
    return static_cast<std::uint64_t>(b[at]) | static_cast<std::uint64_t>(b[at + 1]) << 8;
}
std::uint64_t u32(std::span<const std::uint8_t> b, std::size_t at)
{
    return u16(b, at) | u16(b, at + 2) << 16;
}

[[noreturn]] void ends_early(const std::string& name, const char* format)
{
    throw InputError(name, "", fmt::format("invalid {}: the file ends within the image", format));
}

// --- TGA [Truevision TGA File Format Specification, Version 2.0]

constexpr std::size_t k_tga_head = 18;
constexpr std::uint8_t k_mapped = 1, k_true_color = 2, k_grey = 3, k_run_lengths = 8;   // kinds of images

struct TgaHead {
    explicit TgaHead(std::span<const std::uint8_t> b)
        : kind(b[2] & ~k_run_lengths),
          packed((b[2] & k_run_lengths) != 0),
          colors(u16(b, 5)),
          color_bits(b[7]),
          width(u16(b, 12)),
          height(u16(b, 14)),
          bits(b[16]),
          alpha_bits(b[17] & 15),
          pixels(k_tga_head + b[0])
    {
        if (b[1] == 1) pixels += colors * ((color_bits + 7u) / 8u);
    }
    std::size_t pixel_bytes() const { return (bits + 7u) / 8u; }

    int kind;
    bool packed;
    std::uint64_t colors;
    unsigned color_bits;
    std::uint64_t width, height;
    unsigned bits, alpha_bits;
    std::size_t pixels;   // where they begin
};

bool is_color(unsigned bits)
{
    return bits == 15 || bits == 16 || bits == 24 || bits == 32;
}

// Channels of stb_image's pixels for a colour of so many bits.
int channels_of(unsigned bits, bool grey)
{
    if (grey) return bits == 8 ? 1 : 2;
    return bits == 32 ? 4 : 3;
}

// Whether all packets of run lengths are there.
bool has_all_packets(std::span<const std::uint8_t> bytes, const TgaHead& head)
{
    const std::size_t size = head.pixel_bytes();
    std::size_t at = head.pixels;
    for (std::uint64_t left = head.width * head.height; left > 0;) {
        if (at >= bytes.size()) return false;
        const std::uint64_t count = (bytes[at] & 127u) + 1u;
        at += 1 + ((bytes[at] & 128) != 0 ? 1 : count) * size;
        left -= std::min(left, count);
    }
    return at <= bytes.size();
}

// --- BMP

constexpr std::size_t k_bmp_head = 14, k_bmp_info = 40;
constexpr std::uint64_t k_no_compression = 0, k_bit_fields = 3, k_alpha_bit_fields = 6;

}   // namespace

bool is_bmp(std::span<const std::uint8_t> bytes)
{
    return bytes.size() > k_bmp_head + 4 && bytes[0] == 'B' && bytes[1] == 'M' && u32(bytes, k_bmp_head) >= 12 &&
           u32(bytes, k_bmp_head) <= 124;
}

bool is_tga(std::span<const std::uint8_t> bytes)
{
    if (bytes.size() <= k_tga_head || bytes[1] > 1 || bytes[2] > (k_run_lengths | k_grey)) return false;
    const TgaHead head(bytes);
    if (head.width == 0 || head.height == 0) return false;
    switch (head.kind) {
        case k_mapped:
            return bytes[1] == 1 && (head.bits == 8 || head.bits == 16) && is_color(head.color_bits) && head.colors > 0;
        case k_true_color:
            return is_color(head.bits);
        case k_grey:
            return head.bits == 8 || head.bits == 16;
        default:
            return false;
    }
}

ImageNeeds tga_needs(std::span<const std::uint8_t> bytes, const std::string& name)
{
    const TgaHead head(bytes);
    const std::uint64_t count = head.width * head.height;
    const bool whole = head.packed
                           ? has_all_packets(bytes, head)
                           : bytes.size() >= head.pixels && bytes.size() - head.pixels >= count * head.pixel_bytes();
    if (!whole) ends_early(name, "TGA");
    const int channels = channels_of(head.kind == k_mapped ? head.color_bits : head.bits, head.kind == k_grey);
    const auto stored = static_cast<std::uint64_t>(channels);
    // stb_image's pixels beside ours, and its colours.
    return {static_cast<int>(head.width), static_cast<int>(head.height), channels,
            2 * count * stored + 4 * head.colors};
}

ImageNeeds bmp_needs(std::span<const std::uint8_t> bytes, const std::string& name)
{
    const std::uint64_t offset = u32(bytes, 10), info = u32(bytes, k_bmp_head);
    if (bytes.size() < k_bmp_head + std::max<std::uint64_t>(info, 12)) ends_early(name, "BMP");
    std::uint64_t width = 0, height = 0, bits = 0, compression = k_no_compression;
    if (info < k_bmp_info) {
        width = u16(bytes, 18), height = u16(bytes, 20), bits = u16(bytes, 24);
    } else {
        width = u32(bytes, 18), height = u32(bytes, 22), bits = u16(bytes, 28), compression = u32(bytes, 30);
        if (height >> 31 != 0) height = (std::uint64_t{1} << 32) - height;   // rows from the top
    }
    if (compression != k_no_compression && compression != k_bit_fields && compression != k_alpha_bit_fields)
        throw InputError(name, "", "a compressed BMP is not supported; save it without compression, or as PNG");
    const auto most = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
    if (width > most || height > most) throw InputError(name, "", "invalid BMP: its size is out of range");
    const std::uint64_t row = (width * bits + 31) / 32 * 4;
    if (offset > bytes.size() || (height > 0 && row > (bytes.size() - offset) / height)) ends_early(name, "BMP");
    return {static_cast<int>(width), static_cast<int>(height), 4, 2 * 4 * width * height};
}

Image8 decode_with_stb(std::span<const std::uint8_t> bytes, const std::string& name)
{
    interruption_point();
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &width, &height, &channels, 0),
        stbi_image_free);
    if (!pixels) throw InputError(name, "", fmt::format("the image cannot be decoded: {}", stbi_failure_reason()));
    // Without bits of alpha, the fourth byte of a pixel is not used.
    const bool opaque =
        channels == 4 && bytes[0] != 'B' && TgaHead(bytes).kind == k_true_color && TgaHead(bytes).alpha_bits == 0;
    Image8 image(width, height, opaque ? 3 : channels);
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const auto from = static_cast<std::size_t>(channels), to = static_cast<std::size_t>(image.channels);
    for (std::size_t i = 0; i < count; ++i) std::memcpy(image.data.data() + i * to, pixels.get() + i * from, to);
    return image;
}

}   // namespace gnomon::io
