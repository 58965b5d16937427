// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a use of a resource means to the device, and what must be waited for between two.

#include <optional>

#include "vk/commands.h"

namespace gnomon::vk {

struct UseMeaning {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;   // of images
    bool writes = false;
};

/// @param shader_stages  those of the pass: vertex and fragment, or compute, or those that trace rays
UseMeaning meaning(Use use, VkPipelineStageFlags2 shader_stages);

struct Wait {
    VkPipelineStageFlags2 from_stages = 0, to_stages = 0;
    VkAccessFlags2 from_access = 0, to_access = 0;
    VkImageLayout from_layout = VK_IMAGE_LAYOUT_UNDEFINED, to_layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

/// Notes a use and says what must be waited for before it; nothing where the last write is visible to it already.
/// @param image  whether the layout counts
std::optional<Wait> follow(UseState& state, const UseMeaning& use, bool image);

}   // namespace gnomon::vk
