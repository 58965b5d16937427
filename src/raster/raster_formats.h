// SPDX-License-Identifier: Apache-2.0
#pragma once
// Formats and sizes that the images and the passes of the rasterised frame agree on.

#include "gnomon/types.h"
#include "vk/resource.h"

namespace gnomon::raster {

constexpr VkFormat k_id_format = VK_FORMAT_R32G32_UINT;
constexpr VkFormat k_depth_format = VK_FORMAT_D32_SFLOAT;
constexpr VkFormat k_wide_format = VK_FORMAT_R32G32B32A32_SFLOAT;

/// Pixels from one light's layer of lit pixels to the next. Each layer can be bound, because offsets that are whole
/// multiples of 256 bytes always can.
inline std::size_t lit_pixels(Size size)
{
    const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    return (pixels + 63) / 64 * 64;
}

}   // namespace gnomon::raster
