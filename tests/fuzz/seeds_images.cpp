// SPDX-License-Identifier: Apache-2.0
// Images of every kind that is read.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "fuzz/seeds.h"
#include "hdr_bytes.h"
#include "image_bytes.h"

namespace gnomon::fuzz {

namespace {

Bytes bytes_of(const std::string& text)
{
    return {text.begin(), text.end()};
}

// A repeating ramp, so that it can be compressed.
Bytes ramp(std::size_t size)
{
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i % 23 * 11);
    return bytes;
}

Bytes make_png(test::PngKind kind)
{
    const bool palette = kind.type == PNG_COLOR_TYPE_PALETTE;
    const bool rgb = (kind.type & PNG_COLOR_MASK_COLOR) != 0 && !palette, alpha = kind.type & PNG_COLOR_MASK_ALPHA;
    const int bits = kind.width * kind.depth * ((rgb ? 3 : 1) + (alpha ? 1 : 0));
    const auto row_bytes = static_cast<std::size_t>((bits + 7) / 8);
    if (palette) kind.palette = {{10, 20, 30}, {40, 50, 60}};
    kind.gamma = 0.45;
    return test::png_bytes(kind, {palette ? Bytes(row_bytes, 0) : ramp(row_bytes)});
}

Bytes make_jpeg(const test::JpegKind& kind)
{
    return test::jpeg_bytes(kind, ramp(static_cast<std::size_t>(kind.width) * static_cast<std::size_t>(kind.channels)));
}

// --- OpenEXR in memory

class MemoryStream : public Imf::OStream {
 public:
    explicit MemoryStream(Bytes& bytes) : Imf::OStream("memory"), bytes_(bytes) {}
    void write(const char c[], int n) override
    {
        if (bytes_.size() < at_ + static_cast<std::size_t>(n)) bytes_.resize(at_ + static_cast<std::size_t>(n));
        std::memcpy(&bytes_[at_], c, static_cast<std::size_t>(n));
        at_ += static_cast<std::size_t>(n);
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t at) override { at_ = at; }

 private:
    Bytes& bytes_;
    std::size_t at_ = 0;
};

Bytes make_exr(Imf::Compression compression, Imf::PixelType type, const std::vector<const char*>& channels, bool tiled)
{
    constexpr int width = 19, height = 18;
    Imf::Header header(width, height);
    header.compression() = compression;
    const std::size_t wide = type == Imf::HALF ? 2 : 4;
    Bytes pixels(width * height * wide, 0);
    Imf::FrameBuffer frame;
    for (const char* channel : channels) {
        header.channels().insert(channel, Imf::Channel(type));
        frame.insert(channel, Imf::Slice(type, reinterpret_cast<char*>(pixels.data()), wide, wide * width));
    }
    if (tiled) header.setTileDescription(Imf::TileDescription(8, 8, Imf::ONE_LEVEL));
    Bytes bytes;
    MemoryStream stream(bytes);
    if (tiled) {
        Imf::TiledOutputFile out(stream, header);
        out.setFrameBuffer(frame);
        out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
    } else {
        Imf::OutputFile out(stream, header);
        out.setFrameBuffer(frame);
        out.writePixels(height);
    }
    return bytes;
}

}   // namespace

std::vector<Bytes> png_seeds()
{
    std::vector<Bytes> seeds;
    for (const bool interlaced : {false, true}) {
        for (const int type : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGBA})
            for (const int depth : {8, 16})
                seeds.push_back(
                    make_png({.width = 9, .height = 5, .depth = depth, .type = type, .interlaced = interlaced}));
        seeds.push_back(make_png({.width = 9,
                                  .height = 5,
                                  .depth = 1,
                                  .type = PNG_COLOR_TYPE_PALETTE,
                                  .palette_alpha = {0, 255},
                                  .interlaced = interlaced}));
    }
    seeds.push_back(
        make_png({.width = 9, .height = 5, .depth = 8, .type = PNG_COLOR_TYPE_RGB, .see_through = png_color_16{}}));
    seeds.push_back(make_png({.width = 4, .height = 4, .depth = 1, .type = PNG_COLOR_TYPE_GRAY}));
    seeds.push_back(make_png({.width = 2, .height = 2, .depth = 8, .type = PNG_COLOR_TYPE_PALETTE}));
    return seeds;
}

std::vector<Bytes> jpeg_seeds()
{
    return {make_jpeg({9, 5, JCS_GRAYSCALE, 1}), make_jpeg({17, 18, JCS_RGB, 3, false, 1}),
            make_jpeg({17, 18, JCS_RGB, 3, true}), make_jpeg({8, 8, JCS_CMYK, 4})};
}

std::vector<Bytes> ppm_seeds()
{
    return {bytes_of("P6\n# a comment\n2 #x\n1\n255\nabcdef"), bytes_of("P5 3 1 255 abc"),
            bytes_of("P6 1 1 65535 abcdef"), bytes_of("P5 1 2 65535 abcd"), bytes_of("P6 1 1 1 \x01\x01\x01")};
}

std::vector<Bytes> exr_seeds()
{
    std::vector<Bytes> seeds;
    for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                               Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION})
        seeds.push_back(make_exr(compression, Imf::HALF, {"R", "G", "B", "A"}, false));
    seeds.push_back(make_exr(Imf::ZIP_COMPRESSION, Imf::FLOAT, {"R", "G", "B", "depth.Z", "normal.X"}, false));
    seeds.push_back(make_exr(Imf::ZIPS_COMPRESSION, Imf::UINT, {"Y"}, false));
    seeds.push_back(make_exr(Imf::RLE_COMPRESSION, Imf::FLOAT, {"R", "G", "B"}, true));
    return seeds;
}

std::vector<Bytes> hdr_seeds()
{
    Bytes flat, runs;
    for (int i = 0; i < 12; ++i) flat.insert(flat.end(), {100, 50, static_cast<std::uint8_t>(i), 129});
    Bytes older = {100, 50, 20, 129, 1, 1, 1, 5, 9, 9, 9, 128, 1, 1, 1, 5};
    for (int y = 0; y < 3; ++y) {
        const Bytes row = test::even_row(20, {static_cast<std::uint8_t>(y), 20, 30, 130});
        runs.insert(runs.end(), row.begin(), row.end());
    }
    return {test::hdr_file("-Y 3 +X 4", flat), test::hdr_file("-Y 2 +X 6", older), test::hdr_file("-Y 3 +X 20", runs),
            test::hdr_file("-Y 3 +X 4", flat, "# x\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\nEXPOSURE= 0.5\nGAMMA=1\n")};
}

}   // namespace gnomon::fuzz
