// SPDX-License-Identifier: Apache-2.0
#pragma once
// An image whose pixels the host computes: sends them to the device.

#include <span>

#include "base/math.h"
#include "vk/commands.h"

namespace gnomon::raster {

class SentImage {
 public:
    /// @param pixels  all of the image's, row by row; four 32-bit floats each
    void send(vk::Commands& commands, std::span<const glm::vec4> pixels, const vk::Image& image);

 private:
    vk::Buffer sent_;
};

}   // namespace gnomon::raster
