// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <stdio.h>   // before jpeglib.h, which needs FILE

#include <jpeglib.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "gnomon/error.h"
#include "io/file/atomic_file.h"
#include "io/image/image_file.h"

namespace gnomon::io {

namespace {
constexpr std::uint8_t k_marker = 0xff, k_start = 0xd8, k_end = 0xd9, k_scan = 0xda;

struct Errors {
    jpeg_error_mgr base;   // must be the first member, because libjpeg gets a pointer to it
    std::jmp_buf leave;
    char text[JMSG_LENGTH_MAX];
};

[[noreturn]] void leave(j_common_ptr info)
{
    auto* errors = reinterpret_cast<Errors*>(info->err);
    errors->base.format_message(info, errors->text);
    std::longjmp(errors->leave, 1);
}

struct Bytes {
    unsigned char* data = nullptr;
    unsigned long size = 0;
    ~Bytes() { std::free(data); }
};

// No object in this function has a destructor, because longjmp may leave it.
bool encode(const Image8& image, int quality, Errors& errors, Bytes& bytes)
{
    jpeg_compress_struct info{};
    info.err = jpeg_std_error(&errors.base);
    errors.base.error_exit = leave;
    errors.base.output_message = [](j_common_ptr) {};
    if (setjmp(errors.leave)) {
        jpeg_destroy_compress(&info);
        return false;
    }
    jpeg_create_compress(&info);
    jpeg_mem_dest(&info, &bytes.data, &bytes.size);
    info.image_width = static_cast<JDIMENSION>(image.width);
    info.image_height = static_cast<JDIMENSION>(image.height);
    info.input_components = image.channels;
    info.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, std::max(1, quality), TRUE);
    info.dct_method = JDCT_ISLOW;   // gives the same results on every processor
    info.optimize_coding = TRUE;
    if (image.channels == 3 && quality >= k_full_colors)
        info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress(&info, TRUE);
    while (info.next_scanline < info.image_height) {
        JSAMPROW row = const_cast<JSAMPROW>(image.pixel(0, static_cast<int>(info.next_scanline)));   // is only read
        jpeg_write_scanlines(&info, &row, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    return true;
}
}   // namespace

void write_jpeg(const std::filesystem::path& file, const Image8& image, int quality)
{
    GNOMON_CHECK(image.width > 0 && image.height > 0 && (image.channels == 1 || image.channels == 3));
    AtomicFile out(file);
    Errors errors{};
    Bytes bytes;
    if (!encode(image, quality, errors, bytes))
        throw MissingError(fmt::format("cannot write {}: {}", file.string(), errors.text));
    out.write(bytes.data, bytes.size);
    out.commit();
}

bool is_whole_jpeg(const std::filesystem::path& file, int width, int height)
{
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) return false;
    std::ifstream in(file, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    const std::size_t size = bytes.size();
    if (!in || size < 4 || bytes[0] != k_marker || bytes[1] != k_start) return false;
    if (bytes[size - 2] != k_marker || bytes[size - 1] != k_end) return false;
    // Follow the segments up to the first scan: a marker, a length that counts itself, data.
    bool fits = false;
    for (std::size_t at = 2; at + 4 <= size && bytes[at] == k_marker;) {
        const std::uint8_t type = bytes[at + 1];
        const std::size_t length = std::size_t{bytes[at + 2]} << 8 | bytes[at + 3];
        if (length < 2 || length > size - at - 2) return false;
        // A frame header has its precision, height and width; c4, c8 and cc are other segments.
        const bool is_frame = type >= 0xc0 && type <= 0xcf && type != 0xc4 && type != 0xc8 && type != 0xcc;
        if (is_frame && length >= 7)
            fits = (bytes[at + 5] << 8 | bytes[at + 6]) == height && (bytes[at + 7] << 8 | bytes[at + 8]) == width;
        if (type == k_scan) return fits;
        at += 2 + length;
    }
    return false;
}

}   // namespace gnomon::io
