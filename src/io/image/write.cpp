// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>
#include <iterator>
#include <vector>

#include "gnomon/error.h"
#include "io/file/atomic_file.h"
#include "io/image/image_file.h"

namespace gnomon::io {

namespace {
// The settings are fixed so that the bytes depend on the pixels only. For rendered images, this level with this filter
// takes a third of the time of libpng's defaults and gives files of the same size.
constexpr int k_compression_level = 3;
constexpr int k_filter = PNG_FILTER_UP;
constexpr const char* k_comment_key = "Comment";

// State shared with the callbacks. Exceptions must not pass through libpng: callbacks store them here and longjmp.
struct Encoding {
    std::vector<std::uint8_t> bytes;
    char error[200] = "";
};

void append(png_structp png, png_bytep data, std::size_t size)
{
    auto* encoding = static_cast<Encoding*>(png_get_io_ptr(png));
    bool stored = true;
    try {
        encoding->bytes.insert(encoding->bytes.end(), data, data + size);
    } catch (const std::exception&) {
        stored = false;
    }
    if (!stored) png_error(png, "out of memory");
}

void note_error(png_structp png, png_const_charp text)
{
    auto* encoding = static_cast<Encoding*>(png_get_error_ptr(png));
    std::snprintf(encoding->error, sizeof encoding->error, "%s", text);
    std::longjmp(png_jmpbuf(png), 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// No object in this function has a destructor, because longjmp may leave it.
template <class T>
bool encode(const Image<T>& image, const std::string& comment, Encoding& encoding)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoding, note_error, ignore_warning);
    if (!png) return false;
    png_infop info = png_create_info_struct(png);
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    static constexpr int color_types[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                          PNG_COLOR_TYPE_RGB_ALPHA};
    png_set_write_fn(png, &encoding, append, nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
                 8 * static_cast<int>(sizeof(T)), color_types[image.channels - 1], PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, k_compression_level);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, k_filter);
    if (!comment.empty()) {
        png_text text{};
        text.compression = PNG_TEXT_COMPRESSION_NONE;
        text.key = const_cast<char*>(k_comment_key);   // libpng only reads both
        text.text = const_cast<char*>(comment.c_str());
        text.text_length = comment.size();
        png_set_text(png, info, &text, 1);
    }
    png_write_info(png, info);
    if (sizeof(T) > 1 && std::endian::native == std::endian::little) png_set_swap(png);
    for (int y = 0; y < image.height; ++y)
        png_write_row(png, reinterpret_cast<png_const_bytep>(image.pixel(0, y)));   // a copy is swapped
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return true;
}

constexpr std::array<std::uint8_t, 8> k_signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

std::uint32_t big_endian(const std::uint8_t* p)
{
    return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}
}   // namespace

namespace {
template <class T>
std::vector<std::uint8_t> encoded(const Image<T>& image, const std::string& comment)
{
    GNOMON_CHECK(image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4);
    Encoding encoding;
    if (!encode(image, comment, encoding))
        throw MissingError(
            fmt::format("cannot encode a PNG: {}", encoding.error[0] ? encoding.error : "libpng could not start"));
    return std::move(encoding.bytes);
}

void write_bytes(const std::filesystem::path& file, const std::function<std::vector<std::uint8_t>()>& encode)
{
    AtomicFile out(file);
    const std::vector<std::uint8_t> bytes = encode();
    out.write(bytes.data(), bytes.size());
    out.commit();
}
}   // namespace

std::vector<std::uint8_t> encode_png(const Image8& image, const std::string& comment)
{
    return encoded(image, comment);
}

void write_png(const std::filesystem::path& file, const Image8& image, const std::string& comment)
{
    write_bytes(file, [&] { return encoded(image, comment); });
}

void write_png(const std::filesystem::path& file, const Image16& image, const std::string& comment)
{
    write_bytes(file, [&] { return encoded(image, comment); });
}

PngKind png_kind(const std::filesystem::path& file)
{
    // The header is the first chunk: length, type, width, height, bits, colour type [PNG, 11.2.2].
    constexpr std::size_t bits_at = 24, color_at = 25;
    std::array<char, 26> head{};
    std::ifstream in(file, std::ios::binary);
    in.read(head.data(), head.size());
    if (!in || std::memcmp(head.data(), k_signature.data(), k_signature.size()) != 0)
        throw MissingError(fmt::format("cannot read the frame {}", file.string()));
    return {(head[color_at] & PNG_COLOR_MASK_ALPHA) != 0, head[bits_at] == 16};
}

bool is_whole_png(const std::filesystem::path& file, int width, int height)
{
    return comment_of_whole_png(file, width, height).has_value();
}

std::optional<std::string> comment_of_whole_png(const std::filesystem::path& file, int width, int height)
{
    std::error_code ignored;
    std::ifstream in(file, std::ios::binary);
    if (!in || !std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    if (bytes.size() < k_signature.size() || std::memcmp(bytes.data(), k_signature.data(), k_signature.size()) != 0)
        return std::nullopt;

    // Walk the chunks: length, type, data, checksum of type and data [PNG, 5.3].
    constexpr std::size_t frame_bytes = 12;
    constexpr std::size_t header_bytes = 13;
    const std::size_t key_bytes = std::strlen(k_comment_key) + 1;   // with the null character that ends it
    std::string comment;
    bool first = true;
    for (std::size_t at = k_signature.size(); at + frame_bytes <= bytes.size();) {
        const std::uint8_t* chunk = bytes.data() + at;
        const std::size_t length = big_endian(chunk);
        if (length > bytes.size() - at - frame_bytes) return std::nullopt;
        const uLong checksum = crc32(crc32(0, nullptr, 0), chunk + 4, static_cast<uInt>(length + 4));
        if (checksum != big_endian(chunk + 8 + length)) return std::nullopt;
        if (first) {
            if (std::memcmp(chunk + 4, "IHDR", 4) != 0 || length != header_bytes) return std::nullopt;
            if (big_endian(chunk + 8) != static_cast<std::uint32_t>(width)) return std::nullopt;
            if (big_endian(chunk + 12) != static_cast<std::uint32_t>(height)) return std::nullopt;
            first = false;
        }
        if (std::memcmp(chunk + 4, "tEXt", 4) == 0 && length >= key_bytes &&
            std::memcmp(chunk + 8, k_comment_key, key_bytes) == 0)
            comment.assign(reinterpret_cast<const char*>(chunk + 8 + key_bytes), length - key_bytes);
        at += frame_bytes + length;
        if (std::memcmp(chunk + 4, "IEND", 4) == 0) return at == bytes.size() ? std::optional(comment) : std::nullopt;
    }
    return std::nullopt;
}

}   // namespace gnomon::io
