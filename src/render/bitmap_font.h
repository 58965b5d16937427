// SPDX-License-Identifier: Apache-2.0
#pragma once
// A font of 5 x 7 dots, for labels in pictures: digits, letters (small ones are drawn as capitals), little punctuation.

#include <array>
#include <cstdint>

namespace gnomon::render {

inline constexpr int k_glyph_width = 5;
inline constexpr int k_glyph_height = 7;

/// Seven rows from the top; bit 4 is the left dot. Unknown characters are a box.
std::array<std::uint8_t, k_glyph_height> glyph(char c);

}   // namespace gnomon::render
