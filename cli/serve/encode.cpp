// SPDX-License-Identifier: Apache-2.0
#include "cli/serve/encode.h"

#include <png.h>

#include <bit>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::cli {

std::string encode_png(Size size, std::span<const std::uint8_t> pixels)
{
    GNOMON_CHECK(pixels.size() == 3 * static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(size.width), image.height = static_cast<png_uint_32>(size.height);
    image.format = PNG_FORMAT_RGB;
    png_alloc_size_t bytes = 0;
    std::string file;
    if (png_image_write_get_memory_size(image, bytes, 0, pixels.data(), 0, nullptr)) {
        file.resize(bytes);
        if (png_image_write_to_memory(&image, file.data(), &bytes, 0, pixels.data(), 0, nullptr)) {
            file.resize(bytes);
            return file;
        }
    }
    throw MissingError(std::string("cannot encode a PNG: ") + image.message);
}

namespace {

// Numbers of the format, in the order of its bytes.
void put(std::string& file, std::uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; ++i) file.push_back(static_cast<char>(value >> (8 * i)));
}

}   // namespace

std::string encode_tiff(Size size, std::span<const float> values)
{
    GNOMON_CHECK(values.size() == static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    static_assert(std::endian::native == std::endian::little);
    struct Entry {
        std::uint32_t tag, type, value;   // of one value each; types 3: 16 bits, 4: 32 bits
    };
    const std::uint32_t width = static_cast<std::uint32_t>(size.width),
                        height = static_cast<std::uint32_t>(size.height);
    const std::uint32_t bytes = 4 * width * height;
    const Entry entries[]{{256, 4, width}, {257, 4, height}, {258, 3, 32},    {259, 3, 1}, {262, 3, 1}, {273, 4, 0},
                          {277, 3, 1},     {278, 4, height}, {279, 4, bytes}, {284, 3, 1}, {339, 3, 3}};
    constexpr std::uint32_t k_header = 8, k_entry = 12;
    const std::uint32_t count = static_cast<std::uint32_t>(std::size(entries));
    const std::uint32_t pixels_at = k_header + 2 + k_entry * count + 4;

    std::string file = "II";
    put(file, 42, 2), put(file, k_header, 4), put(file, count, 2);
    for (const Entry& entry : entries) {
        put(file, entry.tag, 2), put(file, entry.type, 2), put(file, 1, 4);
        put(file, entry.tag == 273 ? pixels_at : entry.value, 4);   // where the only strip begins
    }
    put(file, 0, 4);   // no other image
    file.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    return file;
}

}   // namespace gnomon::cli
