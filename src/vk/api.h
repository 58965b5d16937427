// SPDX-License-Identifier: Apache-2.0
#pragma once
// The Vulkan API through volk, and what its result codes become: a failure of the machine is a MissingError of one line
// (exit code 4), never an assertion.
//
// The entry points are volk's global pointers; they go through the loader's own dispatch, so that several devices can
// live at once, and a test can replace one to play a fault.

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <volk.h>

#include <string>
#include <string_view>

namespace gnomon::vk {

/// "out of device memory", "device lost", ... for people.
std::string result_text(VkResult result);

/// @throws MissingError  always: "Vulkan: WHAT failed: RESULT"
[[noreturn]] void fail(VkResult result, std::string_view what);

inline void check(VkResult result, std::string_view what)
{
    if (result != VK_SUCCESS) fail(result, what);
}

}   // namespace gnomon::vk
