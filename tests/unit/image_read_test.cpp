// SPDX-License-Identifier: Apache-2.0
// Images from files and memory: decoding and refusals.
#include "io/image/image_file.h"

#include <sys/stat.h>

#include <fstream>

#include "base/random.h"
#include "gnomon/error.h"
#include "image_bytes.h"
#include "support.h"

namespace gnomon::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& text)
{
    return {text.begin(), text.end()};
}

Bytes file_bytes(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

Bytes make_png(int width, int height, int depth, int type, const std::vector<Bytes>& rows,
               const std::vector<png_color>& palette = {}, const Bytes& palette_alpha = {})
{
    return test::png_bytes({width, height, depth, type, palette, palette_alpha}, rows);
}

Bytes make_jpeg(int width, int height, J_COLOR_SPACE space, int channels, std::uint8_t value)
{
    return test::jpeg_bytes({width, height, space, channels},
                            Bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(channels), value));
}

void expect_refused(const Bytes& bytes, const std::string& what, const ImageLimits& limits = {})
{
    try {
        decode_image(bytes, "image", limits);
        FAIL() << "accepted: " << what;
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), "image");
    }
}

TEST(ImageRead, ReadsBinaryPpm)
{
    const Image8 image = decode_image(bytes_of("P6\n# a comment\n2 #x\n1\n255\nabcdef"), "t");
    EXPECT_EQ(image.width, 2);
    EXPECT_EQ(image.height, 1);
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.data, bytes_of("abcdef"));
    // A pixel may look like whitespace: exactly one character separates it from the header.
    EXPECT_EQ(decode_image(bytes_of("P6 1 1 255\n\n\n\n"), "t").data, bytes_of("\n\n\n"));
    // Sixteen bits are reduced to eight, most significant byte first; other ranges are scaled.
    EXPECT_EQ(decode_image(bytes_of(std::string("P6 1 1 65535 \xff\xff\x80\x00\x00\x00", 19)), "t").data,
              (Bytes{255, 128, 0}));
    EXPECT_EQ(decode_image(bytes_of(std::string("P6 1 1 1 \x01\x00\x01", 12)), "t").data, (Bytes{255, 0, 255}));
}

TEST(ImageRead, RefusesInvalidPpm)
{
    for (const std::string text :
         {"P6", "P6 ", "P6 1 1 255", "P6 1 1 255 ab", "P6 0 1 255 abc", "P6 1 1 0 abc", "P6 1 1 65536 abc",
          "P6 -1 1 255 abc", "P6 1 1 255abc", "P6 99999999999999999999 1 255 abc", "P6 4294967297 1 255 abc",
          "P6 16000 4000 255 abc", "P6 20000 1 255 abc", "P3 1 1 255 1 2 3", "P6 # never ends"})
        expect_refused(bytes_of(text), text);
}

TEST(ImageRead, ReadsPngOfAllKinds)
{
    EXPECT_EQ(decode_image(make_png(2, 1, 8, PNG_COLOR_TYPE_RGB, {{1, 2, 3, 4, 5, 6}}), "t").data,
              (Bytes{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(decode_image(make_png(1, 1, 8, PNG_COLOR_TYPE_RGBA, {{1, 2, 3, 4}}), "t").data, (Bytes{1, 2, 3, 4}));
    EXPECT_EQ(decode_image(make_png(2, 1, 8, PNG_COLOR_TYPE_GRAY, {{7, 9}}), "t").channels, 1);
    EXPECT_EQ(decode_image(make_png(1, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, {{7, 9}}), "t").data, (Bytes{7, 9}));
    // One bit of grey is scaled to 0 and 255.
    EXPECT_EQ(decode_image(make_png(2, 1, 1, PNG_COLOR_TYPE_GRAY, {{0x40}}), "t").data, (Bytes{0, 255}));
    // A palette becomes colours, with alpha if it has any.
    const std::vector<png_color> palette{{10, 20, 30}, {40, 50, 60}};
    EXPECT_EQ(decode_image(make_png(2, 1, 8, PNG_COLOR_TYPE_PALETTE, {{1, 0}}, palette), "t").data,
              (Bytes{40, 50, 60, 10, 20, 30}));
    EXPECT_EQ(decode_image(make_png(2, 1, 8, PNG_COLOR_TYPE_PALETTE, {{1, 0}}, palette, {0, 255}), "t").data,
              (Bytes{40, 50, 60, 255, 10, 20, 30, 0}));
}

TEST(ImageRead, SixteenBitPngKeepsItsEncoding)
{
    // sRGB-encoded values stay encoded: 0x8080 becomes 0x80 without conversion.
    const Image8 image = decode_image(
        make_png(2, 1, 16, PNG_COLOR_TYPE_RGB, {{0x80, 0x80, 0, 0, 0xff, 0xff, 0x40, 0x40, 0x20, 0x20, 0xc0, 0xc0}}),
        "t");
    ASSERT_EQ(image.data.size(), 6u);
    const Bytes expected{0x80, 0, 0xff, 0x40, 0x20, 0xc0};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(image.data[i], expected[i], 1) << i;
}

TEST(ImageRead, ReadsJpeg)
{
    const Image8 rgb = decode_image(make_jpeg(17, 9, JCS_RGB, 3, 100), "t");
    EXPECT_EQ(rgb.width, 17);
    EXPECT_EQ(rgb.height, 9);
    EXPECT_EQ(rgb.channels, 3);
    for (const std::uint8_t value : rgb.data) EXPECT_NEAR(value, 100, 2);
    EXPECT_EQ(decode_image(make_jpeg(8, 8, JCS_GRAYSCALE, 1, 50), "t").channels, 1);
    EXPECT_EQ(decode_image(make_jpeg(8, 8, JCS_CMYK, 4, 255), "t").channels, 3);
}

TEST(ImageRead, ChecksLimitsBeforeAllocating)
{
    const ImageLimits small{.max_side = 16, .max_pixels = 100};
    expect_refused(make_png(17, 1, 8, PNG_COLOR_TYPE_GRAY, {Bytes(17)}), "wide PNG", small);
    expect_refused(make_png(11, 10, 8, PNG_COLOR_TYPE_GRAY, std::vector<Bytes>(10, Bytes(11))), "PNG of many pixels",
                   small);
    expect_refused(make_jpeg(17, 1, JCS_GRAYSCALE, 1, 0), "wide JPEG", small);
    expect_refused(make_jpeg(11, 10, JCS_GRAYSCALE, 1, 0), "JPEG of many pixels", small);
    EXPECT_EQ(decode_image(make_jpeg(10, 10, JCS_GRAYSCALE, 1, 0), "t", small).width, 10);
}

TEST(ImageRead, AppliesPngGammaIfRequested)
{
    const Bytes linear =
        test::png_bytes({.width = 1, .height = 1, .depth = 8, .type = PNG_COLOR_TYPE_GRAY, .gamma = 1}, {Bytes{128}});
    EXPECT_GT(decode_image(linear, "t").data[0], 180);
    EXPECT_EQ(decode_image(linear, "t", {.stored_values = true}).data[0], 128);
}

TEST(ImageRead, RefusesTruncatedJpeg)
{
    // Noise, so that every row takes many bytes.
    Bytes row(64 * 3);
    Random random(5);
    for (std::uint8_t& value : row) value = static_cast<std::uint8_t>(random.next());
    for (const bool progressive : {false, true}) {
        const Bytes whole = test::jpeg_bytes({64, 64, JCS_RGB, 3, progressive}, row);
        expect_refused({whole.begin(), whole.begin() + static_cast<long>(whole.size() / 2)}, "half a JPEG");
        expect_refused({whole.begin(), whole.end() - 40}, "a JPEG without its last bytes");
        // It is complete if only the end marker is missing.
        EXPECT_EQ(decode_image(std::span(whole).first(whole.size() - 2), "t").data, decode_image(whole, "t").data);
    }
}

TEST(ImageRead, RefusesTruncatedAndDamagedFiles)
{
    const Bytes png = make_png(4, 4, 8, PNG_COLOR_TYPE_RGBA, std::vector<Bytes>(4, Bytes(16, 77)));
    const Bytes jpeg = make_jpeg(16, 16, JCS_RGB, 3, 100);
    for (const Bytes& good : {png, jpeg})
        for (std::size_t size = 0; size < good.size(); ++size) {
            try {
                decode_image(std::span(good).first(size), "image");
            } catch (const InputError&) {
            }
        }
    for (std::size_t size = 0; size < 40; ++size)
        expect_refused({png.begin(), png.begin() + static_cast<long>(size)}, "cut PNG");
    Random random(3);
    for (int round = 0; round < 2000; ++round) {
        Bytes bad = round % 2 ? png : jpeg;
        for (int i = 0; i < 3; ++i)
            bad[random.below(static_cast<std::uint32_t>(bad.size()))] = static_cast<std::uint8_t>(random.next());
        try {
            decode_image(bad, "image", {.max_side = 4096, .max_pixels = 1 << 20});
        } catch (const InputError&) {
        }
    }
}

TEST(ImageRead, RecognisesFormatsByContent)
{
    const test::ScratchFolder folder;
    const Bytes png = make_png(1, 1, 8, PNG_COLOR_TYPE_GRAY, {{9}});
    std::ofstream(folder / "x.jpg", std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<long>(png.size()));
    EXPECT_EQ(file_bytes(folder / "x.jpg"), png);
    EXPECT_EQ(read_image(folder / "x.jpg").data, Bytes{9});
    expect_refused(bytes_of("GIF89a..........."), "GIF");
    expect_refused({}, "nothing");
}

TEST(ImageRead, ReadsRegularFilesOnly)
{
    const test::ScratchFolder folder;
    EXPECT_THROW(read_image(folder / "absent.png"), InputError);
    EXPECT_THROW(read_image(folder.path()), InputError);
    ASSERT_EQ(mkfifo((folder / "fifo.png").c_str(), 0600), 0);
    EXPECT_THROW(read_image(folder / "fifo.png"), InputError);   // and does not block
    EXPECT_THROW(read_image("/dev/zero"), InputError);
}

}   // namespace
}   // namespace gnomon::io
