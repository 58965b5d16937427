// SPDX-License-Identifier: Apache-2.0
#pragma once
// A bitmap font of 5 x 7 dots for labels in images: digits, letters (lower case is drawn as capitals), some
// punctuation.

#include <array>
#include <cstdint>
#include <string>

#include "base/image.h"

namespace gnomon::image {

inline constexpr int k_glyph_width = 5;
inline constexpr int k_glyph_height = 7;

/// Seven rows from the top; bit 4 is the left dot. Unknown characters are drawn as a box.
std::array<std::uint8_t, k_glyph_height> glyph(char c);

/// Width of a text in pixels.
int text_width(const std::string& text, int dot);

/// Draws one line of grey text with its upper left corner at (left, top), clipped to `width`.
/// @param dot  side of a dot of the font in pixels
void draw_text(Image8& image, const std::string& text, int left, int top, int width, int dot, std::uint8_t ink);

}   // namespace gnomon::image
