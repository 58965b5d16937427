// SPDX-License-Identifier: Apache-2.0
// Small images that would take a reader much time or memory.
#include <gtest/gtest.h>
#include <zlib.h>

#include <ctime>
#include <string>

#include "gnomon/error.h"
#include "hostile/made_scenes.h"
#include "image_bytes.h"
#include "io/image/image_file.h"
#include "sanitized.h"

namespace gnomon::test {
namespace {

Image8 decoded(const std::string& bytes)
{
    return io::decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, "image");
}

void expect_refused(const std::string& bytes, const std::string& about)
{
    try {
        decoded(bytes);
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), "image");
        EXPECT_NE(std::string(error.what()).find(about), std::string::npos) << error.what();
    }
}

std::string half(std::size_t value)
{
    return {static_cast<char>(value >> 8), static_cast<char>(value & 0xff)};
}

std::string segment(char mark, const std::string& data)
{
    return std::string("\xff") + mark + half(data.size() + 2) + data;
}

// A grey progressive JPEG, all black: one bit per block, then scans of a few bytes that encode no change for all
// blocks.
std::string many_scans(std::size_t side, int scans)
{
    const std::string table(15, '\0');   // no codes of 2 bits and more
    std::string bytes =
        "\xff\xd8" + segment('\xdb', std::string(1, '\0') + std::string(64, '\1')) +
        segment('\xc2', "\x08" + half(side) + half(side) + std::string("\1\1\x11\0", 4)) +
        segment('\xc4', std::string("\0\1", 2) + table + std::string(1, '\0')) +
        segment('\xc4', "\x10\1" + table + "\xe0");   // the only code: 16,384 blocks or more are finished
    bytes += segment('\xda', std::string("\1\1\0\0\0\0", 6)) + std::string(side * side / 512, '\0');
    for (int scan = 1; scan < scans; ++scan) bytes += segment('\xda', std::string("\1\1\0\1\x3f\0", 6)) + half(0);
    return bytes + "\xff\xd9";
}

TEST(HostileImage, RefusesEndlessProgressiveJpegScans)
{
    EXPECT_EQ(decoded(many_scans(64, 100)).width, 64);
    expect_refused(many_scans(64, 101), "more than 100 scans");
    expect_refused(many_scans(64, 20000), "more than 100 scans");
}

TEST(HostileImage, RefusesMorePixelsThanTheBytesCanHold)
{
    // A header with almost no data after it.
    expect_refused(many_scans(4096, 2).substr(0, 1000), "4096 x 4096 pixels cannot be in 1000 bytes");
    expect_refused(made_png(8192, 8192, false), "8192 x 8192 pixels cannot be in");
    // Optimally compressed data is read.
    EXPECT_EQ(decoded(many_scans(4096, 1)).width, 4096);
    std::vector<std::uint8_t> row(4096);
    const auto png = png_bytes({4096, 4096, 1, PNG_COLOR_TYPE_GRAY}, {row});
    EXPECT_EQ(decoded({png.begin(), png.end()}).width, 4096);
}

TEST(HostileImage, DoesNotUnpackTextChunks)
{
    const auto chunk = [](const std::string& type, const std::string& data) {
        const std::string both = type + data;
        const auto word = [](std::size_t value) { return half(value >> 16) + half(value & 0xffff); };
        return word(data.size()) + both +
               word(::crc32(0, reinterpret_cast<const Bytef*>(both.data()), static_cast<uInt>(both.size())));
    };
    // Eight megabytes each, in eight thousand bytes.
    const std::string text(7'900'000, 'a');
    std::string packed(::compressBound(text.size()), '\0');
    uLongf size = packed.size();
    ::compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(text.data()),
                text.size(), 9);
    packed.resize(size);
    std::string texts;
    for (int i = 0; i < 100; ++i)
        texts += chunk("zTXt", std::string("a\0\0", 3) + packed) + chunk("tEXt", std::string("a\0b", 3)) +
                 chunk("iTXt", std::string("a\0\1\0\0\0", 6) + packed);

    const auto plain = png_bytes({2, 1, 8, PNG_COLOR_TYPE_RGB, {}, {}, {}, false, 0.5}, {{1, 2, 3, 4, 5, 6}});
    const std::string png(plain.begin(), plain.end());
    const std::clock_t start = std::clock();
    for (const char* before : {"gAMA", "IDAT", "IEND"}) {
        std::string with = png;
        with.insert(png.find(before) - 4, texts);
        EXPECT_EQ(decoded(with).data, decoded(png).data) << before;
    }
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 2.0 * k_patience);
}

}   // namespace
}   // namespace gnomon::test
