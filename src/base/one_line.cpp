// SPDX-License-Identifier: Apache-2.0
#include "base/one_line.h"

#include <optional>
#include <string_view>

namespace gnomon {

namespace {
struct Character {
    char32_t code = 0;
    std::size_t bytes = 1;
};

// The character at a place of a text in UTF-8 [Unicode 15.0, table 3-7]; none if the bytes there are not one.
std::optional<Character> character_at(std::string_view text, std::size_t at)
{
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
    const unsigned lead = byte(0);
    if (lead < 0x80) return Character{lead, 1};
    const std::size_t bytes = lead < 0xc0 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf8 ? 4 : 0;
    if (bytes == 0 || bytes > text.size() - at) return std::nullopt;
    char32_t code = lead & (0x7fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0u) != 0x80) return std::nullopt;
        code = code << 6 | (byte(i) & 0x3fu);
    }
    constexpr char32_t k_least[] = {0, 0, 0x80, 0x800, 0x10000};   // by bytes: longer forms are not allowed
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    if (code < k_least[bytes] || code > 0x10ffff || surrogate) return std::nullopt;
    return Character{code, bytes};
}

// Controls, line and paragraph separators, and marks that order the text from right to left.
bool changes_terminal(char32_t c)
{
    return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x61c || c == 0x200e || c == 0x200f ||
           (c >= 0x2028 && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}
}   // namespace

std::string one_line(const std::string& text)
{
    std::string line;
    line.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        const std::optional<Character> character = character_at(text, at);
        const std::size_t bytes = character ? character->bytes : 1;
        if (character && !changes_terminal(character->code))
            line.append(text, at, bytes);
        else
            line += '?';
        at += bytes;
    }
    return line;
}

std::string shown_name(std::string name)
{
    constexpr std::size_t k_most = 60;
    if (name.size() > k_most) {
        std::size_t end = k_most - 3;
        while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;   // whole characters of UTF-8
        name = name.substr(0, end) + "...";
    }
    return one_line(name);
}

}   // namespace gnomon
