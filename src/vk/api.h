// SPDX-License-Identifier: Apache-2.0
#pragma once
// The Vulkan API through volk. Failures of the machine become a MissingError of one line (exit code 4), never an
// assertion.
//
// The entry points are volk's global pointers, which use the loader's dispatch, so that several devices can exist at
// once and a test can replace an entry point to simulate a failure.

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <volk.h>

#include <string>
#include <string_view>

namespace gnomon::vk {

/// A readable name: "out of device memory", "device lost", ...
std::string result_text(VkResult result);

/// @throws MissingError  always: "Vulkan: WHAT failed: RESULT"
[[noreturn]] void fail(VkResult result, std::string_view what);

inline void check(VkResult result, std::string_view what)
{
    if (result != VK_SUCCESS) fail(result, what);
}

}   // namespace gnomon::vk
