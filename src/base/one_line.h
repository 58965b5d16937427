// SPDX-License-Identifier: Apache-2.0
#pragma once
// Replaces control characters in text from files, because they could change a terminal's state when printed.

#include <string>
#include <utility>

namespace gnomon {

/// @return the text, '?' for every control character
inline std::string one_line(std::string text)
{
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    // Replace U+0080 to U+009F in UTF-8, to which AFF's Latin-1 is converted: terminals interpret these as well.
    for (std::size_t at = 0; (at = text.find('\xc2', at)) != std::string::npos; ++at)
        if (at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) >= 0x80 &&
            static_cast<unsigned char>(text[at + 1]) < 0xa0)
            text.replace(at, 2, "?");
    return text;
}

/// A name as a message shows it: in one line, and of 60 bytes at most.
inline std::string shown_name(std::string name)
{
    constexpr std::size_t k_most = 60;
    if (name.size() > k_most) {
        std::size_t end = k_most - 3;
        while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;   // whole characters of UTF-8
        name = name.substr(0, end) + "...";
    }
    return one_line(std::move(name));
}

}   // namespace gnomon
