// SPDX-License-Identifier: Apache-2.0
#pragma once
// Translates uses of resources to Vulkan stages, accesses and layouts, and determines the barriers between uses.

#include <optional>

#include "vk/commands.h"

namespace gnomon::vk {

struct UseMeaning {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;   // of images
    bool writes = false;
};

/// @param shader_stages  of the pass: vertex and fragment, compute, or ray tracing
UseMeaning meaning(Use use, VkPipelineStageFlags2 shader_stages);

struct Wait {
    VkPipelineStageFlags2 from_stages = 0, to_stages = 0;
    VkAccessFlags2 from_access = 0, to_access = 0;
    VkImageLayout from_layout = VK_IMAGE_LAYOUT_UNDEFINED, to_layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

/// Records a use and returns the barrier that it requires; nothing if the last write is already visible to it.
/// @param image  whether the layout matters
std::optional<Wait> follow(UseState& state, const UseMeaning& use, bool image);

}   // namespace gnomon::vk
