// SPDX-License-Identifier: Apache-2.0
// Pictures of every kind that is read.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <jpeglib.h>
#include <png.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "fuzz/seeds.h"
#include "hdr_bytes.h"

namespace gnomon::fuzz {

namespace {

Bytes bytes_of(const std::string& text)
{
    return {text.begin(), text.end()};
}

// A ramp that repeats, so that compression has something to do.
Bytes ramp(std::size_t size)
{
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i % 23 * 11);
    return bytes;
}

Bytes make_png(int width, int height, int depth, int type, bool interlaced, bool transparent = false)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    Bytes out;
    png_set_write_fn(
        png, &out,
        [](png_structp p, png_bytep data, png_size_t size) {
            auto* bytes = static_cast<Bytes*>(png_get_io_ptr(p));
            bytes->insert(bytes->end(), data, data + size);
        },
        nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), depth, type,
                 interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    const png_color palette[] = {{10, 20, 30}, {40, 50, 60}};
    const png_byte alpha[] = {0, 255};
    png_color_16 key{};
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 2);
    if (transparent)
        png_set_tRNS(png, info, type == PNG_COLOR_TYPE_PALETTE ? alpha : nullptr, 2,
                     type == PNG_COLOR_TYPE_PALETTE ? nullptr : &key);
    png_set_gAMA(png, info, 0.45);
    png_write_info(png, info);
    const std::size_t row_bytes = png_get_rowbytes(png, info);
    const Bytes row = type == PNG_COLOR_TYPE_PALETTE ? Bytes(row_bytes, 0) : ramp(row_bytes);
    for (int pass = interlaced ? png_set_interlace_handling(png) : 1; pass > 0; --pass)
        for (int y = 0; y < height; ++y) png_write_row(png, row.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return out;
}

Bytes make_jpeg(int width, int height, J_COLOR_SPACE space, int channels, bool progressive, unsigned restart)
{
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &memory, &size);
    info.image_width = static_cast<JDIMENSION>(width), info.image_height = static_cast<JDIMENSION>(height);
    info.input_components = channels;
    info.in_color_space = space;
    jpeg_set_defaults(&info);
    if (progressive) jpeg_simple_progression(&info);
    info.restart_interval = restart;
    jpeg_start_compress(&info, TRUE);
    Bytes row = ramp(static_cast<std::size_t>(width * channels));
    while (info.next_scanline < info.image_height) {
        JSAMPROW pointer = row.data();
        jpeg_write_scanlines(&info, &pointer, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    Bytes out(memory, memory + size);
    std::free(memory);
    return out;
}

// --- OpenEXR into memory

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
            for (const int depth : {8, 16}) seeds.push_back(make_png(9, 5, depth, type, interlaced));
        seeds.push_back(make_png(9, 5, 1, PNG_COLOR_TYPE_PALETTE, interlaced, true));
    }
    seeds.push_back(make_png(9, 5, 8, PNG_COLOR_TYPE_RGB, false, true));
    seeds.push_back(make_png(4, 4, 1, PNG_COLOR_TYPE_GRAY, false));
    seeds.push_back(make_png(2, 2, 8, PNG_COLOR_TYPE_PALETTE, false));
    return seeds;
}

std::vector<Bytes> jpeg_seeds()
{
    return {make_jpeg(9, 5, JCS_GRAYSCALE, 1, false, 0), make_jpeg(17, 18, JCS_RGB, 3, false, 1),
            make_jpeg(17, 18, JCS_RGB, 3, true, 0), make_jpeg(8, 8, JCS_CMYK, 4, false, 0)};
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
