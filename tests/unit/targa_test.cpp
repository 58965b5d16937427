// SPDX-License-Identifier: Apache-2.0
// TGA and BMP images: every kind that is read gives the same pixels, and files that end early are refused.
#include <gtest/gtest.h>

#include "gnomon/error.h"
#include "io/image/image_file.h"

namespace gnomon {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Red, green, blue, black above yellow, cyan, magenta, white: as in a file, from the top.
constexpr int k_width = 4, k_height = 2;
constexpr std::uint8_t k_pixels[k_width * k_height][3] = {{255, 0, 0},   {0, 255, 0},   {0, 0, 255},   {0, 0, 0},
                                                          {255, 255, 0}, {0, 255, 255}, {255, 0, 255}, {255, 255, 255}};

const std::uint8_t* pixel(int x, int y)
{
    return k_pixels[y * k_width + x];
}

Bytes tga(int kind, int bits, int alpha_bits, bool from_top, int colors = 0)
{
    Bytes b(18);
    b[1] = colors > 0 ? 1 : 0, b[2] = static_cast<std::uint8_t>(kind);
    b[5] = static_cast<std::uint8_t>(colors), b[7] = colors > 0 ? 24 : 0;
    b[12] = k_width, b[14] = k_height, b[16] = static_cast<std::uint8_t>(bits);
    b[17] = static_cast<std::uint8_t>(alpha_bits | (from_top ? 0x20 : 0));
    return b;
}

void add_color(Bytes& b, const std::uint8_t* p, int bits, std::uint8_t alpha = 0)
{
    b.insert(b.end(), {p[2], p[1], p[0]});
    if (bits == 32) b.push_back(alpha);
}

Bytes plain_tga(int bits, int alpha_bits, bool from_top)
{
    Bytes b = tga(2, bits, alpha_bits, from_top);
    for (int row = 0; row < k_height; ++row)
        for (int x = 0; x < k_width; ++x) add_color(b, pixel(x, from_top ? row : k_height - 1 - row), bits, 100);
    return b;
}

Bytes mapped_tga()
{
    Bytes b = tga(1, 8, 0, true, k_width * k_height);
    for (const auto& p : k_pixels) add_color(b, p, 24);
    for (int i = 0; i < k_width * k_height; ++i) b.push_back(static_cast<std::uint8_t>(i));
    return b;
}

// The second row is one colour, packed.
Bytes packed_tga()
{
    Bytes b = tga(10, 24, 0, true);
    b.push_back(k_width - 1);
    for (int x = 0; x < k_width; ++x) add_color(b, pixel(x, 0), 24);
    b.push_back(0x80 | (k_width - 1));
    add_color(b, pixel(0, 1), 24);
    return b;
}

Bytes bmp(int bits)
{
    const int row = (k_width * bits + 31) / 32 * 4;
    Bytes b(54);
    const auto put = [&](std::size_t at, int value) {
        for (std::size_t i = 0; i < 4; ++i) b[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
    };
    b[0] = 'B', b[1] = 'M';
    put(2, 54 + row * k_height), put(10, 54), put(14, 40), put(18, k_width), put(22, k_height);
    b[26] = 1, b[28] = static_cast<std::uint8_t>(bits);
    for (int y = k_height - 1; y >= 0; --y)
        for (int x = 0; x < k_width; ++x) add_color(b, pixel(x, y), bits, 0);
    return b;
}

void expect_pixels(const Bytes& bytes, const char* what, bool second_row = true)
{
    SCOPED_TRACE(what);
    const Image8 image = io::decode_image(bytes, "image");
    ASSERT_EQ(image.width, k_width);
    ASSERT_EQ(image.height, k_height);
    ASSERT_GE(image.channels, 3);
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x)
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(image.pixel(x, y)[c], pixel(y == 1 && !second_row ? 0 : x, y)[c]) << x << ' ' << y;
}

TEST(Targa, EveryKindGivesTheSamePixels)
{
    expect_pixels(plain_tga(24, 0, false), "24 bits");
    expect_pixels(plain_tga(24, 0, true), "24 bits, from the top");
    expect_pixels(plain_tga(32, 8, false), "32 bits");
    expect_pixels(mapped_tga(), "with a table of colours");
    expect_pixels(packed_tga(), "packed", false);
    expect_pixels(bmp(24), "a BMP of 24 bits");
    expect_pixels(bmp(32), "a BMP of 32 bits");
}

TEST(Targa, TheFourthByteIsAlphaOnlyIfTheHeaderSaysSo)
{
    const Image8 with = io::decode_image(plain_tga(32, 8, true), "image");
    ASSERT_EQ(with.channels, 4);
    EXPECT_EQ(with.pixel(0, 0)[3], 100);
    EXPECT_EQ(io::decode_image(plain_tga(32, 0, true), "image").channels, 3);
    // A BMP whose fourth bytes are all zero is opaque.
    const Image8 opaque = io::decode_image(bmp(32), "image");
    EXPECT_TRUE(opaque.channels == 3 || opaque.pixel(0, 0)[3] == 255);
}

TEST(Targa, FilesThatEndEarlyAreRefused)
{
    for (const Bytes& whole : {plain_tga(24, 0, true), plain_tga(32, 8, false), mapped_tga(), packed_tga(), bmp(24)})
        for (std::size_t length = 0; length < whole.size(); ++length)
            EXPECT_THROW(io::decode_image(std::span(whole).first(length), "image"), InputError) << length;
}

TEST(Targa, SizesAreHeldAgainstLimitsBeforeMemoryIsTaken)
{
    Bytes large = tga(2, 24, 0, true);
    large[13] = large[15] = 0xff;
    EXPECT_THROW(io::decode_image(large, "image"), InputError);
    EXPECT_THROW(io::image_needs(large, "image"), InputError);
    // A whole file that is larger than the limits.
    io::ImageLimits limits;
    limits.max_side = k_width - 1;
    EXPECT_THROW(io::decode_image(plain_tga(24, 0, true), "image", limits), InputError);
    EXPECT_THROW(io::decode_image(bmp(24), "image", limits), InputError);
    EXPECT_GE(io::image_needs(plain_tga(24, 0, true), "image").bytes, 3u * k_width * k_height);
}

}   // namespace
}   // namespace gnomon
