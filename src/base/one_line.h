// SPDX-License-Identifier: Apache-2.0
#pragma once
// Replaces what is no visible text in names and messages, because it could change a terminal's state when printed.

#include <string>

namespace gnomon {

/// @return the text, '?' for every control character, every character that changes the direction of the text or ends a
///         line, and every byte that is not part of a character in UTF-8
std::string one_line(const std::string& text);

/// A name as a message shows it: in one line, and of 60 bytes at most.
std::string shown_name(std::string name);

}   // namespace gnomon
