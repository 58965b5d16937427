// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <cstdint>

#include "hostile/made_scenes.h"

namespace gnomon::test {

namespace {
std::string word(unsigned long value)
{
    std::string text;
    for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>(value >> shift & 0xff);
    return text;
}

std::string chunk(const std::string& kind_and_data)
{
    const auto* bytes = reinterpret_cast<const Bytef*>(kind_and_data.data());
    return word(kind_and_data.size() - 4) + kind_and_data +
           word(::crc32(0, bytes, static_cast<uInt>(kind_and_data.size())));
}
}   // namespace

std::string made_png(unsigned width, unsigned height, bool whole)
{
    // Grey, 8 bits; a row is its filter and its pixels.
    const std::size_t rows = whole ? (std::size_t{width} + 1) * height : 1000;
    std::string raw(rows, '\0'), packed(::compressBound(rows), '\0');
    if (whole)
        for (std::size_t i = 0; i < rows; ++i)
            if (i % (width + 1)) raw[i] = static_cast<char>(0xa0 + (i / 7 & 0x3f));
    uLongf size = packed.size();
    ::compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()), rows);
    packed.resize(size);
    return "\x89PNG\r\n\x1a\n" + chunk("IHDR" + word(width) + word(height) + std::string("\x08\0\0\0\0", 5)) +
           chunk("IDAT" + packed) + chunk("IEND");
}

std::string made_ppm(unsigned width, unsigned height, bool whole)
{
    std::string text = "P6\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
    return text + std::string(whole ? std::size_t{3} * width * height : 100, '\x90');
}

}   // namespace gnomon::test
