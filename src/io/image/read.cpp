// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <jerror.h>
#include <jpeglib.h>
#include <png.h>
#include <webp/decode.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/image/image_file.h"
#include "io/image/targa.h"

namespace gnomon::io {

namespace {

void check_size(std::uint64_t width, std::uint64_t height, const std::string& name, const ImageLimits& limits)
{
    const auto side = static_cast<std::uint64_t>(limits.max_side);
    if (width == 0 || height == 0) throw InputError(name, "", "the image has no pixels");
    if (width > side || height > side || width * height > limits.max_pixels)
        throw InputError(name, "", fmt::format("image of {} x {} pixels is larger than allowed", width, height));
}

// What an image needs whose decoder takes `more` bytes beside its pixels.
ImageNeeds needs_of(std::uint64_t width, std::uint64_t height, int channels, std::uint64_t more)
{
    return {static_cast<int>(width), static_cast<int>(height), channels,
            width * height * static_cast<std::uint64_t>(channels) + more};
}

// Each decoder below returns an empty image if `needs` is given, and fills it in instead.

// --- PNG, with libpng's simplified reader, which never calls longjmp across our frames.

struct PngChunks {
    std::uint64_t pixel_bytes = 0;       // packed
    std::vector<std::uint8_t> without;   // the file without the ignored chunks, if there are any
};

// Checks the chunks of a PNG and removes text. libpng allocates the size that a chunk claims before it looks for the
// bytes. It also unpacks every text, which may expand a thousandfold; texts are not part of the image.
PngChunks check_png_chunks(std::span<const std::uint8_t> bytes, const std::string& name, bool stored_values)
{
    constexpr std::size_t k_magic = 8, k_head = 8, k_checksum = 4;   // head: length, type
    PngChunks found;
    std::size_t copied = 0;
    for (std::size_t at = k_magic; at + k_head <= bytes.size();) {
        std::size_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | bytes[at + i];
        const std::size_t there = bytes.size() - at - k_head;
        if (length + k_checksum > there)
            throw InputError(
                name, fmt::format("byte {}", at),
                fmt::format("a PNG chunk needs {} bytes and a checksum, but {} bytes are left", length, there));
        const std::string_view type(reinterpret_cast<const char*>(&bytes[at + 4]), 4);
        const std::size_t next = at + k_head + length + k_checksum;
        const bool is_text = type == "tEXt" || type == "zTXt" || type == "iTXt";
        const bool is_encoding = type == "gAMA" || type == "cHRM" || type == "sRGB" || type == "iCCP";
        if (is_text || (is_encoding && stored_values)) {
            found.without.insert(found.without.end(), &bytes[copied], &bytes[at]);
            copied = next;
        }
        if (type == "IDAT") found.pixel_bytes += length;
        if (type == "IEND") break;
        at = next;
    }
    if (copied > 0) found.without.insert(found.without.end(), bytes.begin() + static_cast<long>(copied), bytes.end());
    return found;
}

// Compares the claimed number of pixels with the size of the data before memory is allocated: deflate has a maximum
// ratio.
void check_png_pixels(std::span<const std::uint8_t> bytes, const png_image& image, const PngChunks& chunks,
                      const std::string& name)
{
    constexpr std::size_t k_depth = 24, k_type = 25;   // in range, because libpng has validated the header
    constexpr std::uint64_t k_most_per_byte = 1032;
    static constexpr std::uint64_t channels[] = {1, 0, 3, 1, 2, 0, 4};
    const std::uint64_t bits = bytes[k_depth] * channels[bytes[k_type]];
    const std::uint64_t raw = std::uint64_t{image.width} * image.height * bits / 8;
    if (raw / k_most_per_byte > chunks.pixel_bytes)
        throw InputError(name, "",
                         fmt::format("invalid PNG: {} x {} pixels cannot be in {} bytes", image.width, image.height,
                                     chunks.pixel_bytes));
}

// Frees libpng's state on every path; the allocation of the pixels may throw.
struct PngMemory {
    png_image& image;
    ~PngMemory() { png_image_free(&image); }
};

Image8 decode_png(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits,
                  ImageNeeds* needs)
{
    const PngChunks chunks = check_png_chunks(bytes, name, limits.stored_values);
    if (!chunks.without.empty()) bytes = chunks.without;
    png_image image{};
    const PngMemory memory{image};
    image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
        throw InputError(name, "", fmt::format("invalid PNG: {}", image.message));
    check_size(image.width, image.height, name, limits);
    check_png_pixels(bytes, image, chunks, name);
    // Keep values as encoded, including 16-bit ones, which libpng assumes to be linear by default.
    image.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
    const bool color = image.format & PNG_FORMAT_FLAG_COLOR, alpha = image.format & PNG_FORMAT_FLAG_ALPHA;
    image.format = color ? (alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB) : (alpha ? PNG_FORMAT_GA : PNG_FORMAT_GRAY);
    const int channels = static_cast<int>(PNG_IMAGE_SAMPLE_CHANNELS(image.format));
    if (needs) {
        constexpr std::uint64_t k_row_bytes = 32;   // per pixel, of the rows that libpng holds
        *needs = needs_of(image.width, image.height, channels, k_row_bytes * image.width + chunks.without.size());
        return {};
    }
    Image8 result(static_cast<int>(image.width), static_cast<int>(image.height), channels);
    if (!png_image_finish_read(&image, nullptr, result.data.data(), 0, nullptr))
        throw InputError(name, "", fmt::format("invalid PNG: {}", image.message));
    return result;
}

// --- JPEG

// Limits the scans of a progressive image: each may take a few bytes and still process all pixels. Encoders write about
// ten.
constexpr int k_most_scans = 100;

struct JpegErrors {
    jpeg_error_mgr base;   // must be the first member, because libjpeg gets a pointer to it
    std::jmp_buf jump;
    char message[JMSG_LENGTH_MAX];
    jpeg_progress_mgr scans;
    bool file_ended, pixels_lacked;   // missing end marker; missing pixels
    bool interrupted;
};

[[noreturn]] void leave_jpeg(j_common_ptr info)
{
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    (*info->err->format_message)(info, errors->message);
    std::longjmp(errors->jump, 1);
}

// libjpeg fills missing pixels with grey and warns. (Files that lack only the end marker are complete.)
void note_warning(j_common_ptr info, int level)
{
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    if (level >= 0) return;
    errors->file_ended |= info->err->msg_code == JWRN_JPEG_EOF;
    errors->pixels_lacked |= info->err->msg_code == JWRN_HIT_MARKER;
}

// Leaves the decoder if the work was interrupted. No exception may pass through libjpeg.
void leave_if_interrupted(JpegErrors& errors)
{
    Interruption* const interruption = Interruption::current();
    errors.interrupted = interruption && interruption->requested();
    if (errors.interrupted) std::longjmp(errors.jump, 1);
}

void count_scans(j_common_ptr info)
{
    leave_if_interrupted(*reinterpret_cast<JpegErrors*>(info->err));
    if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= k_most_scans) return;
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    std::snprintf(errors->message, sizeof errors->message, "more than %d scans", k_most_scans);
    std::longjmp(errors->jump, 1);
}

// Whether the file can hold the claimed 8 x 8 blocks: each takes at least a bit, except with arithmetic coding.
bool has_room(const jpeg_decompress_struct& info, std::size_t bytes)
{
    std::uint64_t blocks = 0;
    for (int i = 0; i < info.num_components; ++i)
        blocks += std::uint64_t{info.comp_info[i].width_in_blocks} * info.comp_info[i].height_in_blocks;
    return info.arith_code || blocks / 8 <= bytes;
}

// Like PngMemory.
struct JpegMemory {
    jpeg_decompress_struct& info;
    ~JpegMemory() { jpeg_destroy_decompress(&info); }
};

// libjpeg keeps the coefficients of all blocks, unless one scan has everything. CMYK is decoded before it becomes RGB.
ImageNeeds jpeg_needs(jpeg_decompress_struct& info)
{
    constexpr std::uint64_t k_block_bytes = 64 * sizeof(JCOEF);
    constexpr std::uint64_t k_row_bytes = 256;   // per pixel of a row
    const auto padded = [](std::uint64_t blocks, int factor) {
        const auto f = static_cast<std::uint64_t>(std::max(1, factor));
        return (blocks + f - 1) / f * f;
    };
    std::uint64_t coefficients = 0;
    if (jpeg_has_multiple_scans(&info))
        for (int i = 0; i < info.num_components; ++i) {
            const jpeg_component_info& component = info.comp_info[i];
            coefficients += k_block_bytes * padded(component.width_in_blocks, component.h_samp_factor) *
                            padded(component.height_in_blocks, component.v_samp_factor);
        }
    const std::uint64_t pixels = static_cast<std::uint64_t>(info.image_width) * info.image_height;
    const bool cmyk = info.num_components == 4;
    return needs_of(info.image_width, info.image_height, info.num_components == 1 ? 1 : 3,
                    std::max<std::uint64_t>(coefficients, k_row_bytes * info.image_width) + (cmyk ? 4 * pixels : 0));
}

// All objects with destructors are in the caller, because longjmp does not run destructors.
bool decode_jpeg_into(jpeg_decompress_struct& info, JpegErrors& errors, std::span<const std::uint8_t> bytes,
                      const ImageLimits& limits, Image8& result, bool& too_large, ImageNeeds* needs)
{
    if (setjmp(errors.jump)) return false;
    jpeg_create_decompress(&info);
    info.progress = &errors.scans;
    jpeg_mem_src(&info, bytes.data(), bytes.size());
    jpeg_read_header(&info, TRUE);
    // Check the claimed size before allocating memory.
    const std::uint64_t side = static_cast<std::uint64_t>(limits.max_side);
    if (info.image_width > side || info.image_height > side ||
        static_cast<std::uint64_t>(info.image_width) * info.image_height > limits.max_pixels) {
        too_large = true;
        return false;
    }
    if (!has_room(info, bytes.size())) {
        std::snprintf(errors.message, sizeof errors.message, "%u x %u pixels cannot be in %zu bytes", info.image_width,
                      info.image_height, bytes.size());
        return false;
    }
    if (needs) {
        *needs = jpeg_needs(info);
        return true;
    }
    // Decode.
    info.out_color_space = info.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    if (info.num_components == 4) info.out_color_space = JCS_CMYK;
    jpeg_start_decompress(&info);
    result.width = static_cast<int>(info.output_width);
    result.height = static_cast<int>(info.output_height);
    result.channels = info.output_components;
    result.data.resize(static_cast<std::size_t>(info.output_width) * info.output_height *
                       static_cast<std::size_t>(info.output_components));
    while (info.output_scanline < info.output_height) {
        JSAMPROW row = result.pixel(0, static_cast<int>(info.output_scanline));
        jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
    // Reject a truncated file.
    if (!errors.file_ended || !errors.pixels_lacked) return true;
    std::snprintf(errors.message, sizeof errors.message, "the file ends before its last pixel");
    return false;
}

// Adobe writes inverted CMYK: 255 is no ink.
Image8 rgb_from_cmyk(const Image8& cmyk)
{
    Image8 rgb(cmyk.width, cmyk.height, 3);
    for (std::size_t i = 0; i < cmyk.data.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            rgb.data[3 * i + c] = static_cast<std::uint8_t>(cmyk.data[4 * i + c] * cmyk.data[4 * i + 3] / 255);
    return rgb;
}

Image8 decode_jpeg(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits,
                   ImageNeeds* needs)
{
    jpeg_decompress_struct info{};
    const JpegMemory memory{info};
    JpegErrors errors{};
    errors.scans.progress_monitor = &count_scans;
    info.err = jpeg_std_error(&errors.base);
    errors.base.error_exit = &leave_jpeg;
    errors.base.emit_message = &note_warning;
    Image8 result;
    bool too_large = false;
    const bool good = decode_jpeg_into(info, errors, bytes, limits, result, too_large, needs);
    if (errors.interrupted) interruption_point();
    if (too_large) check_size(info.image_width, info.image_height, name, limits);
    if (!good) throw InputError(name, "", fmt::format("invalid JPEG: {}", errors.message));
    if (result.channels == 4) return rgb_from_cmyk(result);
    return result;
}

// --- WebP, a still image

Image8 decode_webp(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits,
                   ImageNeeds* needs)
{
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(bytes.data(), bytes.size(), &features) != VP8_STATUS_OK)
        throw InputError(name, "", "invalid WebP: its header cannot be read");
    if (features.has_animation) throw InputError(name, "", "an animated WebP is not supported");
    check_size(static_cast<std::uint64_t>(features.width), static_cast<std::uint64_t>(features.height), name, limits);
    interruption_point();
    if (needs) {
        // libwebp holds the pixels of lossless images a second time, else those of alpha, and a few rows.
        constexpr int k_lossless = 2;
        constexpr std::uint64_t k_row_bytes = 256;   // per pixel of a row
        const auto width = static_cast<std::uint64_t>(features.width),
                   height = static_cast<std::uint64_t>(features.height);
        const std::uint64_t bytes_per_pixel = features.format == k_lossless ? 5 : features.has_alpha ? 6 : 1;
        *needs =
            needs_of(width, height, features.has_alpha ? 4 : 3, bytes_per_pixel * width * height + k_row_bytes * width);
        return {};
    }
    Image8 image(features.width, features.height, features.has_alpha ? 4 : 3);
    const int stride = features.width * image.channels;
    const auto decode = features.has_alpha ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
    if (!decode(bytes.data(), bytes.size(), image.data.data(), image.data.size(), stride))
        throw InputError(name, "", "invalid WebP: its pixels cannot be decoded");
    return image;
}

bool is_webp(std::span<const std::uint8_t> bytes)
{
    constexpr std::size_t k_head = 12;   // "RIFF", size, "WEBP"
    return bytes.size() > k_head && std::memcmp(bytes.data(), "RIFF", 4) == 0 &&
           std::memcmp(bytes.data() + 8, "WEBP", 4) == 0;
}

// --- Binary PPM and PGM

class PnmReader {
 public:
    PnmReader(std::span<const std::uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name), at_(2) {}

    std::uint64_t number()
    {
        // Skip blanks and comments, then read digits.
        while (at_ < bytes_.size() && (std::isspace(bytes_[at_]) || bytes_[at_] == '#')) {
            if (bytes_[at_] == '#')
                while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
            else
                ++at_;
        }
        std::uint64_t value = 0;
        const std::size_t first = at_;
        while (at_ < bytes_.size() && std::isdigit(bytes_[at_])) {
            value = value * 10 + (bytes_[at_++] - '0');
            if (at_ - first > 9) break;
        }
        if (at_ == first || at_ - first > 9)
            throw InputError(name_, fmt::format("byte {}", first), "expected a number");
        return value;
    }
    std::span<const std::uint8_t> pixels(std::size_t size)
    {
        if (at_ >= bytes_.size() || !std::isspace(bytes_[at_]))
            throw InputError(name_, fmt::format("byte {}", at_), "expected one blank before the pixels");
        ++at_;
        if (bytes_.size() - at_ < size)
            throw InputError(name_, fmt::format("byte {}", at_),
                             fmt::format("expected {} bytes of pixels, found {}", size, bytes_.size() - at_));
        return bytes_.subspan(at_, size);
    }

 private:
    std::span<const std::uint8_t> bytes_;
    const std::string& name_;
    std::size_t at_;
};

Image8 decode_pnm(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits,
                  ImageNeeds* needs)
{
    const int channels = bytes[1] == '6' ? 3 : 1;
    PnmReader reader(bytes, name);
    const std::uint64_t width = reader.number(), height = reader.number(), most = reader.number();
    check_size(width, height, name, limits);
    if (most == 0 || most > 65535)
        throw InputError(name, "", fmt::format("largest value {} is not in 1 to 65535", most));
    const std::size_t wide = most > 255 ? 2 : 1;
    const std::size_t values = static_cast<std::size_t>(width * height) * static_cast<std::size_t>(channels);
    const std::span<const std::uint8_t> pixels = reader.pixels(values * wide);
    if (needs) {
        *needs = needs_of(width, height, channels, 0);
        return {};
    }
    Image8 image(static_cast<int>(width), static_cast<int>(height), channels);
    for (std::size_t i = 0; i < values; ++i) {
        const std::uint64_t value = wide == 1 ? pixels[i] : pixels[2 * i] * 256u + pixels[2 * i + 1];
        image.data[i] = static_cast<std::uint8_t>(std::min<std::uint64_t>(255, (value * 255 + most / 2) / most));
    }
    return image;
}

bool starts_with(std::span<const std::uint8_t> bytes, std::initializer_list<std::uint8_t> magic)
{
    return bytes.size() > magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

Image8 decode(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits,
              ImageNeeds* needs)
{
    if (starts_with(bytes, {0x89, 'P', 'N', 'G'})) return decode_png(bytes, name, limits, needs);
    if (starts_with(bytes, {0xff, 0xd8, 0xff})) return decode_jpeg(bytes, name, limits, needs);
    if (starts_with(bytes, {'P', '6'}) || starts_with(bytes, {'P', '5'})) return decode_pnm(bytes, name, limits, needs);
    if (is_webp(bytes)) return decode_webp(bytes, name, limits, needs);
    if (is_bmp(bytes) || is_tga(bytes)) {
        constexpr std::size_t k_largest = std::size_t{1} << 30;   // of a file
        if (bytes.size() > k_largest) throw InputError(name, "", "the image file is larger than allowed");
        const ImageNeeds own = is_bmp(bytes) ? bmp_needs(bytes, name) : tga_needs(bytes, name);
        check_size(static_cast<std::uint64_t>(own.width), static_cast<std::uint64_t>(own.height), name, limits);
        if (!needs) return decode_with_stb(bytes, name);
        *needs = own;
        return {};
    }
    throw InputError(name, "", "unsupported image format; use PNG, JPEG, WebP, TGA, BMP or binary PPM");
}

}   // namespace

ImageNeeds image_needs(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits)
{
    ImageNeeds needs;
    decode(bytes, name, limits, &needs);
    return needs;
}

Image8 decode_image(std::span<const std::uint8_t> bytes, const std::string& name, const ImageLimits& limits)
{
    return decode(bytes, name, limits, nullptr);
}

Image8 read_image(const std::filesystem::path& file, const ImageLimits& limits)
{
    return decode_image(read_whole_file(file, file.string()), file.string(), limits);
}

}   // namespace gnomon::io
