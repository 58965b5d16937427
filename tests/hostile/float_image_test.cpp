// SPDX-License-Identifier: Apache-2.0
// OpenEXR and Radiance files that are truncated, changed, or contradictory: refused or read, never a crash, never much
// memory.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <fstream>

#include "base/random.h"
#include "gnomon/error.h"
#include "hdr_bytes.h"
#include "io/image/exr.h"
#include "io/image/float_image.h"
#include "io/image/hdr.h"
#include "support.h"

namespace gnomon::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes exr_file()
{
    const test::ScratchFolder scratch;
    constexpr Size size{40, 35};   // three chunks
    Random random(1);
    std::vector<ExrLayer> layers{{"", {"R", "G", "B"}, {}}, {"depth", {"Z"}, {}}};
    for (ExrLayer& layer : layers)
        for (std::size_t i = 0; i < layer.channels.size() * 40 * 35; ++i)
            layer.data.push_back(static_cast<float>(random.below(9)));
    write_exr(scratch / "a.exr", size, layers);
    std::ifstream in(scratch / "a.exr", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

Bytes hdr_file()
{
    Bytes pixels;
    for (int y = 0; y < 20; ++y) {
        const Bytes row = test::even_row(200, {static_cast<std::uint8_t>(y), 20, 30, 130});
        pixels.insert(pixels.end(), row.begin(), row.end());
    }
    return test::hdr_file("-Y 20 +X 200", pixels);
}

// Reads completely, or refuses with an InputError; anything else fails the test.
bool reads(const Bytes& bytes)
{
    try {
        decode_float_image(bytes, "hostile");
        if (image_format(bytes) == ImageFormat::exr) decode_exr(bytes, "hostile");
        return true;
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return false;
    }
}

std::uint64_t peak_bytes()
{
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void put_word(Bytes& bytes, std::size_t at, std::uint32_t value)
{
    for (int i = 0; i < 4; ++i) bytes[at + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> (8 * i));
}

// The offset of an attribute's value.
std::size_t value_of(const Bytes& bytes, const std::string& attribute, const std::string& type)
{
    std::string key = attribute;
    key += '\0';
    key += type;
    key += '\0';
    const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
    EXPECT_NE(at, bytes.end()) << attribute;
    return static_cast<std::size_t>(at - bytes.begin()) + key.size() + 4;
}

TEST(HostileExr, RefusesEveryTruncation)
{
    const Bytes whole = exr_file();
    ASSERT_TRUE(reads(whole));
    for (std::size_t size = 0; size < whole.size(); size += size < 700 ? 1 : 13)
        EXPECT_FALSE(reads(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
    EXPECT_FALSE(reads(Bytes(whole.begin(), whole.end() - 1)));
}

TEST(HostileExr, ReadsOrRefusesChangedBytes)
{
    const Bytes whole = exr_file();
    Random random(11);
    int refused = 0;
    constexpr int rounds = 3000;
    for (int round = 0; round < rounds; ++round) {
        Bytes bytes = whole;
        const std::uint32_t reach =
            round % 2 ? 500 : static_cast<std::uint32_t>(bytes.size());   // half of the changes in the header
        for (std::uint32_t i = 0; i <= random.below(4); ++i)
            bytes[random.below(reach)] = static_cast<std::uint8_t>(random.below(256));
        refused += !reads(bytes);
    }
    EXPECT_GT(refused, rounds / 2);
}

TEST(HostileExr, EveryDecoderSurvivesWrongData)
{
    // The same chunks with another compression: their bytes are then invalid for the decoder.
    const Bytes whole = exr_file();
    const std::size_t at = value_of(whole, "compression", "compression");
    for (int compression = 0; compression < 12; ++compression) {
        Bytes bytes = whole;
        bytes[at] = static_cast<std::uint8_t>(compression);
        EXPECT_EQ(reads(bytes), compression == 3) << compression;   // ZIP
    }
}

TEST(HostileExr, ClaimedSizesAllocateNoMemory)
{
    const Bytes whole = exr_file();
    const std::size_t window = value_of(whole, "dataWindow", "box2i");
    const std::uint64_t before = peak_bytes();
    for (const std::uint32_t far : {16383u, 1u << 20, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {
        Bytes bytes = whole;
        put_word(bytes, window + 8, far);
        put_word(bytes, window + 12, far);
        EXPECT_FALSE(reads(bytes)) << far;
    }
    Bytes bytes = whole;
    put_word(bytes, value_of(whole, "channels", "chlist") - 4, 0x7fffffff);   // the attribute's size
    EXPECT_FALSE(reads(bytes));
    EXPECT_LT(peak_bytes(), before + (64u << 20));
}

TEST(HostileHdr, RefusesEveryTruncation)
{
    const Bytes whole = hdr_file();
    ASSERT_TRUE(reads(whole));
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_FALSE(reads(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)))) << size;
}

TEST(HostileHdr, ReadsOrRefusesChangedBytes)
{
    const Bytes whole = hdr_file();
    Random random(12);
    int refused = 0;
    constexpr int rounds = 5000;
    for (int round = 0; round < rounds; ++round) {
        Bytes bytes = whole;
        for (std::uint32_t i = 0; i <= random.below(6); ++i)
            bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
                static_cast<std::uint8_t>(random.below(256));
        refused += !reads(bytes);
    }
    EXPECT_GT(refused, rounds / 10);
}

TEST(HostileHdr, ClaimedSizesAllocateNoMemory)
{
    const std::uint64_t before = peak_bytes();
    for (const char* resolution : {"-Y 16384 +X 2048", "-Y 2147483647 +X 2147483647", "-Y 99999999999999 +X 1",
                                   "-Y -5 +X 5", "-Y 1 +X 1e3", "-Y", ""})
        EXPECT_FALSE(reads(test::hdr_file(resolution, test::even_row(2048, {1, 2, 3, 128})))) << resolution;
    EXPECT_LT(peak_bytes(), before + (64u << 20));
}

TEST(HostileFloatImage, DoesNotOpenPipes)
{
    const test::ScratchFolder scratch;
    ASSERT_EQ(::mkfifo((scratch / "pipe.exr").c_str(), 0600), 0);
    EXPECT_THROW(read_float_image(scratch / "pipe.exr"), InputError);
    EXPECT_THROW(read_float_image("/dev/zero"), InputError);
}

}   // namespace
}   // namespace gnomon::io
