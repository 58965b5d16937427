// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stretches an image to the pixels of the screen that it covers, bilinearly, as a graphics card does. Software that
// stands in for a graphics card takes ten times as long.

#include <cstdint>
#include <vector>

#include "base/image.h"
#include "gnomon/types.h"

namespace gnomon::viewer {

class Stretcher {
 public:
    /// @param image  of three channels
    /// @param size   above 0
    /// @return  four bytes for each pixel: blue, green, red and 255, row by row from the top. Valid until the next call
    const std::vector<std::uint8_t>& stretched(const Image8& image, Size size);

 private:
    // Where an output pixel lies between two of the image.
    struct Between {
        std::size_t first, second;
        std::uint16_t weight;   // of the second one, in parts of k_whole
    };
    static std::vector<Between> places(int from, int to);
    void stretch_row(const std::uint8_t* row, std::vector<std::uint8_t>& to) const;

    std::vector<Between> across_;
    std::vector<std::uint8_t> upper_, lower_, out_;
};

}   // namespace gnomon::viewer
