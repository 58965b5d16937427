// SPDX-License-Identifier: Apache-2.0
#include "fuzz/repair.h"

#include <zlib.h>

#include <algorithm>

namespace gnomon::fuzz {

namespace {

constexpr std::size_t k_glb_header = 12, k_glb_chunk = 8, k_png_magic = 8;

std::uint32_t big_endian(const Bytes& bytes, std::size_t at)
{
    return static_cast<std::uint32_t>(bytes[at]) << 24 | static_cast<std::uint32_t>(bytes[at + 1]) << 16 |
           static_cast<std::uint32_t>(bytes[at + 2]) << 8 | bytes[at + 3];
}

void put_little(Bytes& bytes, std::size_t at, std::size_t value)
{
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

// The end of the JSON that starts at `at`: after the brace that closes it, padded with spaces to a multiple of four.
std::size_t end_of_json(const Bytes& bytes, std::size_t at)
{
    int depth = 0;
    bool quoted = false;
    for (; at < bytes.size(); ++at) {
        const char c = static_cast<char>(bytes[at]);
        if (c == '"' && bytes[at - 1] != '\\') quoted = !quoted;
        if (quoted) continue;
        depth += c == '{' ? 1 : c == '}' ? -1 : 0;
        if (depth == 0) break;
    }
    for (++at; at < bytes.size() && (bytes[at] == ' ' || at % 4 != 0); ++at) {
    }
    return std::min(at, bytes.size());
}

}   // namespace

void repair_png(Bytes& bytes)
{
    for (std::size_t at = k_png_magic; at + 12 <= bytes.size();) {
        const std::size_t length = std::min<std::size_t>(big_endian(bytes, at), bytes.size() - at - 12);
        const auto sum = static_cast<std::uint32_t>(crc32(0, &bytes[at + 4], static_cast<uInt>(length + 4)));
        for (std::size_t i = 0; i < 4; ++i) bytes[at + 8 + length + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
        at += length + 12;
    }
}

void repair_glb(Bytes& bytes)
{
    constexpr std::size_t k_json = k_glb_header + k_glb_chunk;
    if (bytes.size() < k_json + 2) return;
    const std::size_t end = end_of_json(bytes, k_json);
    put_little(bytes, 8, bytes.size());
    put_little(bytes, k_glb_header, end - k_json);
    if (end + k_glb_chunk <= bytes.size()) put_little(bytes, end, bytes.size() - end - k_glb_chunk);
}

}   // namespace gnomon::fuzz
