// SPDX-License-Identifier: Apache-2.0
#pragma once
// One line whatever a file's own text holds: control characters in a message could do anything to a terminal.

#include <string>

namespace gnomon {

/// @return the text, '?' for every control character
inline std::string one_line(std::string text)
{
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text;
}

}   // namespace gnomon
