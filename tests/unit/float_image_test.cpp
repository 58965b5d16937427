// SPDX-License-Identifier: Apache-2.0
#include "io/image/float_image.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>

#include "base/random.h"
#include "gnomon/error.h"
#include "hdr_bytes.h"
#include "io/image/exr.h"
#include "io/image/exr_header.h"
#include "io/image/hdr.h"
#include "io/image/image_file.h"
#include "support.h"

namespace gnomon::io {
namespace {

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<ExrLayer> some_layers(Size size)
{
    Random random(3);
    std::vector<ExrLayer> layers{{"", {"R", "G", "B"}, {}}, {"depth", {"Z"}, {}}, {"normal", {"X", "Y", "Z"}, {}}};
    ExrLayer shadow{"shadow", {}, {}};
    for (int l = 0; l < 12; ++l) shadow.channels.push_back(fmt::format("L{}", l));
    layers.push_back(shadow);
    const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    for (ExrLayer& layer : layers)
        for (std::size_t i = 0; i < layer.channels.size() * pixels; ++i) layer.data.push_back(random.uniform(-2, 1000));
    layers[0].data[4] = std::numeric_limits<float>::infinity();
    return layers;
}

TEST(Exr, RoundTripKeepsEveryBit)
{
    const test::ScratchFolder scratch;
    const Size size{37, 21};
    const std::vector<ExrLayer> layers = some_layers(size);
    write_exr(scratch / "a.exr", size, layers);
    const ExrImage back = decode_exr(bytes_of(scratch / "a.exr"), "a.exr");
    EXPECT_EQ(back.size, size);
    ASSERT_EQ(back.layers.size(), layers.size());
    for (const ExrLayer& layer : layers) {
        const auto found = std::find_if(back.layers.begin(), back.layers.end(),
                                        [&](const ExrLayer& other) { return other.name == layer.name; });
        ASSERT_NE(found, back.layers.end()) << layer.name;
        EXPECT_EQ(found->channels, layer.channels);   // L2 before L10, R before B
        EXPECT_EQ(found->data, layer.data) << layer.name;
    }
}

// OpenEXR would read such a value with the length of its type, and the rest as another attribute of any size.
TEST(Exr, RefusesAttributesOfWrongSize)
{
    const test::ScratchFolder scratch;
    write_exr(scratch / "a.exr", {37, 21}, some_layers({37, 21}));
    const std::vector<std::uint8_t> whole = bytes_of(scratch / "a.exr");
    EXPECT_NO_THROW(check_exr(whole, "a.exr", {}));
    const std::string name("screenWindowCenter\0v2f\0", 23);
    const auto at = std::search(whole.begin(), whole.end(), name.begin(), name.end());
    ASSERT_NE(at, whole.end());
    std::vector<std::uint8_t> longer = whole;
    longer[static_cast<std::size_t>(at - whole.begin()) + name.size()] = 40;
    EXPECT_THROW(check_exr(longer, "a.exr", {}), InputError);
    // Lists of strings and preview images contain their own sizes.
    for (const char* type : {"stringvector", "preview", "chlist"}) {
        std::vector<std::uint8_t> more(whole.begin(), whole.begin() + 8);
        for (const char* text : {"own", type}) {
            more.insert(more.end(), text, text + std::strlen(text));
            more.push_back(0);
        }
        for (const int byte : {8, 0, 0, 0, 255, 255, 255, 127, 1, 0, 0, 0})
            more.push_back(static_cast<std::uint8_t>(byte));
        more.insert(more.end(), whole.begin() + 8, whole.end());
        EXPECT_THROW(check_exr(more, "a.exr", {}), InputError) << type;
    }
}

TEST(Exr, WritesLayerAndChannelNames)
{
    const test::ScratchFolder scratch;
    write_exr(scratch / "a.exr", {37, 21}, some_layers({37, 21}));
    const ExrHeader header = check_exr(bytes_of(scratch / "a.exr"), "a.exr", {});
    for (const char* name : {"R", "G", "B", "depth.Z", "normal.X", "normal.Y", "normal.Z", "shadow.L0", "shadow.L11"})
        EXPECT_NE(std::find(header.channels.begin(), header.channels.end(), name), header.channels.end()) << name;
    EXPECT_EQ(header.channels.size(), 19u);
}

TEST(Exr, BytesDependOnPixelsOnly)
{
    const test::ScratchFolder scratch;
    write_exr(scratch / "a.exr", {37, 21}, some_layers({37, 21}));
    write_exr(scratch / "b.exr", {37, 21}, some_layers({37, 21}));
    EXPECT_EQ(bytes_of(scratch / "a.exr"), bytes_of(scratch / "b.exr"));
}

TEST(Exr, ReadsSingleLayersAndChannels)
{
    const test::ScratchFolder scratch;
    const std::vector<ExrLayer> layers = some_layers({37, 21});
    write_exr(scratch / "a.exr", {37, 21}, layers);
    const auto bytes = bytes_of(scratch / "a.exr");
    const ExrImage depth = decode_exr(bytes, "a.exr", "depth");
    ASSERT_EQ(depth.layers.size(), 1u);
    EXPECT_EQ(depth.layers[0].data, layers[1].data);
    const ExrImage one = decode_exr(bytes, "a.exr", "shadow.L3");
    ASSERT_EQ(one.layers.size(), 1u);
    ASSERT_EQ(one.layers[0].channels, std::vector<std::string>{"L3"});
    EXPECT_EQ(one.layers[0].data[5], layers[3].data[5 * 12 + 3]);
    EXPECT_TRUE(decode_exr(bytes, "a.exr", "nothing").layers.empty());
}

TEST(Exr, DetectsTruncatedFiles)
{
    const test::ScratchFolder scratch;
    write_exr(scratch / "a.exr", {37, 21}, some_layers({37, 21}));
    EXPECT_TRUE(is_whole_exr(scratch / "a.exr", {37, 21}));
    EXPECT_FALSE(is_whole_exr(scratch / "a.exr", {37, 22}));
    auto bytes = bytes_of(scratch / "a.exr");
    bytes.resize(bytes.size() - 100);
    std::ofstream(scratch / "b.exr", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    EXPECT_FALSE(is_whole_exr(scratch / "b.exr", {37, 21}));
    EXPECT_FALSE(is_whole_exr(scratch / "none.exr", {37, 21}));
    // Frames of videos may be larger than the reader's limit.
    const Size wide{FloatImageLimits{}.max_side + 1, 1};
    const ExrLayer line{"", {"Y"}, std::vector<float>(static_cast<std::size_t>(wide.width))};
    write_exr(scratch / "wide.exr", wide, std::span(&line, 1));
    EXPECT_TRUE(is_whole_exr(scratch / "wide.exr", wide));
}

TEST(Exr, ReadsAsManyChannelsAsItWrites)
{
    const test::ScratchFolder scratch;
    const Size size{3, 2};
    ExrLayer shadow{"shadow", {}, {}};
    for (int l = 0; l < k_max_exr_channels; ++l) {
        shadow.channels.push_back(fmt::format("L{}", l));
        for (int i = 0; i < 6; ++i) shadow.data.push_back(static_cast<float>(shadow.data.size() % 1000));
    }
    ASSERT_EQ(room_in_exr(size), shadow.channels.size());
    write_exr(scratch / "a.exr", size, std::span(&shadow, 1));
    EXPECT_TRUE(is_whole_exr(scratch / "a.exr", size));
    const ExrImage back = decode_exr(bytes_of(scratch / "a.exr"), "a.exr");
    ASSERT_EQ(back.layers.size(), 1u);
    EXPECT_EQ(back.layers[0].channels, shadow.channels);
    EXPECT_EQ(back.layers[0].data, shadow.data);

    // One more is refused before writing.
    shadow.channels.emplace_back("more");
    shadow.data.resize(shadow.data.size() + 6);
    EXPECT_THROW(write_exr(scratch / "b.exr", size, std::span(&shadow, 1)), UsageError);
    EXPECT_FALSE(std::filesystem::exists(scratch / "b.exr"));
}

TEST(Exr, WiderImagesAllowFewerChannels)
{
    // Sixteen lines of all channels are at most 2,147,483,647 bytes: OpenEXR writes more, but cannot read it.
    EXPECT_EQ(room_in_exr({2047, 1}), 16384u);
    EXPECT_EQ(room_in_exr({2048, 1}), 16383u);
    EXPECT_EQ(room_in_exr({16384, 5000}), 2047u);
    const test::ScratchFolder scratch;
    Layer wide;   // refused before any pixel is read
    wide.name = "shadow";
    wide.channels.assign(2048, "L");
    EXPECT_THROW(write_exr(scratch / "a.exr", {16384, 1}, std::span(&wide, 1)), UsageError);
}

TEST(Exr, RefusesSizesBeyondTheLimits)
{
    const test::ScratchFolder scratch;
    write_exr(scratch / "a.exr", {37, 21}, some_layers({37, 21}));
    const auto bytes = bytes_of(scratch / "a.exr");
    FloatImageLimits limits;
    limits.max_side = 36;
    EXPECT_THROW(decode_exr(bytes, "a", {}, limits), InputError);
    limits = {};
    limits.max_pixels = 37 * 21 - 1;
    EXPECT_THROW(decode_exr(bytes, "a", {}, limits), InputError);
    limits = {};
    limits.max_channels = 18;
    EXPECT_THROW(decode_exr(bytes, "a", {}, limits), InputError);
    limits = {};
    limits.max_values = 37 * 21 * 18;
    EXPECT_THROW(decode_exr(bytes, "a", {}, limits), InputError);
    limits.max_values = 37 * 21 * 19;
    EXPECT_NO_THROW(decode_exr(bytes, "a", {}, limits));
}

TEST(Hdr, ReadsNewRunsAndExposure)
{
    // 128 * 2^(129 - 136) = 1, 64 -> 0.5; exposures are divided out.
    const auto row = test::even_row(300, {128, 64, 0, 129});
    std::vector<std::uint8_t> pixels = row;
    pixels.insert(pixels.end(), row.begin(), row.end());
    const ImageF plain = decode_hdr(test::hdr_file("-Y 2 +X 300", pixels), "a.hdr");
    EXPECT_EQ(plain.width, 300);
    EXPECT_EQ(plain.height, 2);
    for (int x = 0; x < 300; ++x) {
        EXPECT_EQ(plain.pixel(x, 1)[0], 1.0f);
        EXPECT_EQ(plain.pixel(x, 1)[1], 0.5f);
        EXPECT_EQ(plain.pixel(x, 1)[2], 0.0f);
    }
    const ImageF exposed = decode_hdr(test::hdr_file("-Y 2 +X 300", pixels, "EXPOSURE=2\nEXPOSURE= 4\n"), "a.hdr");
    EXPECT_EQ(exposed.pixel(0, 0)[0], 0.125f);
}

TEST(Hdr, ReadsLiteralsOldRunsAndPlainPixels)
{
    // Literals: four components of eight different values.
    std::vector<std::uint8_t> row{2, 2, 0, 8};
    for (int c = 0; c < 4; ++c) {
        row.push_back(8);
        for (int x = 0; x < 8; ++x) row.push_back(static_cast<std::uint8_t>(c == 3 ? 136 : 10 * c + x));
    }
    const ImageF literal = decode_hdr(test::hdr_file("-Y 1 +X 8", row), "a.hdr");
    for (int x = 0; x < 8; ++x) EXPECT_EQ(literal.pixel(x, 0)[2], static_cast<float>(20 + x));

    // Old runs: one pixel, 3 + 1 * 256 more, then another.
    const ImageF old =
        decode_hdr(test::hdr_file("-Y 1 +X 261", {5, 6, 7, 136, 1, 1, 1, 3, 1, 1, 1, 1, 9, 9, 9, 137}), "a.hdr");
    EXPECT_EQ(old.pixel(259, 0)[0], 5.0f);
    EXPECT_EQ(old.pixel(260, 0)[0], 18.0f);

    const ImageF narrow = decode_hdr(test::hdr_file("-Y 1 +X 2", {2, 2, 0, 136, 8, 4, 2, 0}), "a.hdr");
    EXPECT_EQ(narrow.pixel(0, 0)[0], 2.0f);   // too narrow for runs: a pixel that looks like their marker
    EXPECT_EQ(narrow.pixel(1, 0)[0], 0.0f);   // exponent 0 is black
}

TEST(Hdr, RefusesInvalidFiles)
{
    const auto row = test::even_row(16, {128, 64, 0, 129});
    const auto refused = [](const std::vector<std::uint8_t>& bytes) {
        EXPECT_THROW(decode_hdr(bytes, "a.hdr"), InputError);
    };
    EXPECT_NO_THROW(decode_hdr(test::hdr_file("-Y 1 +X 16", row), "a.hdr"));
    refused(test::hdr_file("-Y 2 +X 16", row));                               // a row is missing
    refused(test::hdr_file("-Y 1 +X 17", row));                               // another width
    refused(test::hdr_file("+Y 1 +X 16", row));                               // bottom-up
    refused(test::hdr_file("-Y 1 +X 0", row));                                // empty
    refused(test::hdr_file("-Y 1 +X 16 ", row));                              // trailing text
    refused(test::hdr_file("-Y 1000000 +X 1000000", row));                    // beyond the limits
    refused(test::hdr_file("-Y 16000 +X 2000", row));                         // more rows than bytes
    refused(test::hdr_file("-Y 1 +X 16", row, "FORMAT=32-bit_rle_xyze\n"));   // another colour space
    refused(test::hdr_file("-Y 1 +X 16", row, "EXPOSURE=0\n"));
    refused(test::hdr_file("-Y 1 +X 8", {2, 2, 0, 8, 137, 1}));       // a run past the end
    refused(test::hdr_file("-Y 1 +X 8", {2, 2, 0, 8, 0, 1}));         // a run of nothing
    refused(test::hdr_file("-Y 1 +X 8", {1, 1, 1, 4, 9, 9, 9, 9}));   // a run of no pixel
}

TEST(FloatImage, RecognisesFormatsByContent)
{
    const test::ScratchFolder scratch;
    Image8 gray(3, 2, 1);
    gray.data = {0, 64, 128, 192, 255, 1};
    write_png(scratch / "a.hdr", gray);   // a misleading name
    const ImageF image = read_float_image(scratch / "a.hdr");
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.pixel(1, 1)[2], 1.0f);
    EXPECT_NEAR(image.pixel(2, 0)[0], 0.21586f, 1e-5f);   // sRGB 128

    const std::vector<ExrLayer> layers{{"", {"R", "G", "B", "A"}, {1, 2, 3, 0.5f, 4, 5, 6, 1}}};
    write_exr(scratch / "b.png", {2, 1}, layers);
    EXPECT_EQ(read_float_image(scratch / "b.png").data, (std::vector<float>{1, 2, 3, 4, 5, 6}));
    const std::vector<ExrLayer> depth{{"depth", {"Z"}, {1, 2}}};
    write_exr(scratch / "c.exr", {2, 1}, depth);
    EXPECT_THROW(read_float_image(scratch / "c.exr"), InputError);
    EXPECT_THROW(read_float_image(scratch.path()), InputError);
    EXPECT_THROW(read_float_image(scratch / "none"), InputError);
}

}   // namespace
}   // namespace gnomon::io
