// SPDX-License-Identifier: Apache-2.0
#pragma once
// PNG and JPEG files of all kinds in memory, written by libpng and libjpeg.

#include <jpeglib.h>
#include <png.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <vector>

namespace gnomon::test {

struct PngKind {
    int width, height, depth, type;
    std::vector<png_color> palette{};
    std::vector<png_byte> palette_alpha{};
    std::optional<png_color_16> see_through{};   // the transparent colour
    bool interlaced = false;
    double gamma = 0;   // 0: not stored
};

/// @param rows  in libpng's layout; the last is repeated for all missing ones
inline std::vector<std::uint8_t> png_bytes(const PngKind& kind, const std::vector<std::vector<std::uint8_t>>& rows)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    std::vector<std::uint8_t> out;
    png_set_write_fn(
        png, &out,
        [](png_structp p, png_bytep data, png_size_t size) {
            auto* bytes = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(p));
            bytes->insert(bytes->end(), data, data + size);
        },
        nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(kind.width), static_cast<png_uint_32>(kind.height), kind.depth,
                 kind.type, kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (!kind.palette.empty()) png_set_PLTE(png, info, kind.palette.data(), static_cast<int>(kind.palette.size()));
    if (!kind.palette_alpha.empty())
        png_set_tRNS(png, info, kind.palette_alpha.data(), static_cast<int>(kind.palette_alpha.size()), nullptr);
    if (kind.see_through) png_set_tRNS(png, info, nullptr, 0, &*kind.see_through);
    if (kind.gamma > 0) png_set_gAMA(png, info, kind.gamma);
    png_write_info(png, info);
    for (int pass = kind.interlaced ? png_set_interlace_handling(png) : 1; pass > 0; --pass)
        for (std::size_t y = 0; y < static_cast<std::size_t>(kind.height); ++y)
            png_write_row(png, rows[std::min(y, rows.size() - 1)].data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return out;
}

struct JpegKind {
    int width, height;
    J_COLOR_SPACE space;
    int channels;
    bool progressive = false;
    unsigned restart = 0;   // blocks between restart markers; 0: none
};

/// @param row  used for all rows
inline std::vector<std::uint8_t> jpeg_bytes(const JpegKind& kind, std::vector<std::uint8_t> row)
{
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &memory, &size);
    info.image_width = static_cast<JDIMENSION>(kind.width), info.image_height = static_cast<JDIMENSION>(kind.height);
    info.input_components = kind.channels;
    info.in_color_space = kind.space;
    jpeg_set_defaults(&info);
    if (kind.progressive) jpeg_simple_progression(&info);
    info.restart_interval = kind.restart;
    jpeg_start_compress(&info, TRUE);
    while (info.next_scanline < info.image_height) {
        JSAMPROW pointer = row.data();
        jpeg_write_scanlines(&info, &pointer, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    std::vector<std::uint8_t> out(memory, memory + size);
    std::free(memory);
    return out;
}

}   // namespace gnomon::test
