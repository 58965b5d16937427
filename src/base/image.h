// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images in memory: rows from top to bottom, channels interleaved.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/check.h"

namespace gnomon {

/// @tparam T  std::uint8_t (0 to 255), float (linear unless said) or std::uint32_t (ids)
template <class T>
struct Image {
    int width = 0;
    int height = 0;
    int channels = 0;
    std::vector<T> data;   // height * width * channels

    Image() = default;
    Image(int w, int h, int c) : width(w), height(h), channels(c), data(static_cast<std::size_t>(w) * h * c) {}

    bool empty() const { return data.empty(); }
    T* pixel(int x, int y) { return data.data() + (static_cast<std::size_t>(y) * width + x) * channels; }
    const T* pixel(int x, int y) const { return data.data() + (static_cast<std::size_t>(y) * width + x) * channels; }
};

using Image8 = Image<std::uint8_t>;
using ImageF = Image<float>;
using ImageIds = Image<std::uint32_t>;

/// sRGB encoding of linear light and its inverse (IEC 61966-2-1).
float srgb_from_linear(float linear);
float linear_from_srgb(float encoded);
/// The nearest code of 8-bit sRGB, by a table of where codes begin: 0 below 0, 255 from 1 on.
std::uint8_t srgb8_from_linear(float linear);
/// The linear values of the 256 codes of 8-bit sRGB.
const float* linear_from_srgb8();

}   // namespace gnomon
