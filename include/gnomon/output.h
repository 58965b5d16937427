// SPDX-License-Identifier: Apache-2.0
#pragma once
// Layers of a frame, converted into memory of the caller's.

#include <cstddef>
#include <string>

namespace gnomon {

/// The type of a pixel's values.
/// - f32: float. f16: IEEE 754 half precision, rounded to the nearest, ties to even.
/// - u32: unsigned 32-bit integer, the type of ids.
/// - rgba8: 4 bytes, R G B A: light as the image is shown, by the frame's exposure and tone mapping and in sRGB; A is
///   255.
enum class PixelFormat { f32, f16, u32, rgba8 };

/// A request to write one layer of each rendered frame into the caller's memory. The renderer writes it before render()
/// returns, and keeps no pointer to it afterwards.
struct Output {
    /// A layer, or one channel of it by its full name: "" (the image), "depth", "normal.X", "id.object". Layers beside
    /// the image need the options that make them: RenderOptions::layers, ids or motion.
    std::string layer;
    /// f32 and f16: all layers but ids. u32: ids. rgba8: whole layers of the channels R, G and B.
    PixelFormat format = PixelFormat::f32;
    void* data = nullptr;   // the first byte of the memory; any alignment
    /// Bytes from one pixel to the next; 0: pixels are adjacent. Channels of a pixel are always adjacent.
    std::ptrdiff_t pixel_stride = 0;
    /// Bytes from one row to the next; 0: rows are adjacent. Negative: the image's lowest row is the first in memory,
    /// and the others follow upwards.
    std::ptrdiff_t row_stride = 0;
    std::size_t bytes = 0;   // size of the memory from `data`; it is checked, and nothing is written beyond it
};

}   // namespace gnomon
