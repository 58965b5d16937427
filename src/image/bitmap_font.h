// SPDX-License-Identifier: Apache-2.0
#pragma once
// A font of 5 x 7 dots, for labels in images: digits, letters (small ones are drawn as capitals), little punctuation.

#include <array>
#include <cstdint>
#include <string>

#include "base/image.h"

namespace gnomon::image {

inline constexpr int k_glyph_width = 5;
inline constexpr int k_glyph_height = 7;

/// Seven rows from the top; bit 4 is the left dot. Unknown characters are a box.
std::array<std::uint8_t, k_glyph_height> glyph(char c);

/// Pixels that a text takes from left to right.
int text_width(const std::string& text, int dot);

/// Draws one line of grey text with its upper left corner at (left, top); cuts off what is wider than `width`.
/// @param dot  pixels a dot of the font
void draw_text(Image8& image, const std::string& text, int left, int top, int width, int dot, std::uint8_t ink);

}   // namespace gnomon::image
