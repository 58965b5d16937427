// SPDX-License-Identifier: Apache-2.0
#define VOLK_IMPLEMENTATION
#include "vk/api.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::vk {

std::string result_text(VkResult result)
{
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "out of host memory";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "out of device memory";
        case VK_ERROR_INITIALIZATION_FAILED:
            return "initialisation failed";
        case VK_ERROR_DEVICE_LOST:
            return "the device was lost";
        case VK_ERROR_LAYER_NOT_PRESENT:
            return "a layer is not installed";
        case VK_ERROR_EXTENSION_NOT_PRESENT:
            return "an extension is missing";
        case VK_ERROR_FEATURE_NOT_PRESENT:
            return "a feature is missing";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "no driver is installed";
        case VK_ERROR_TOO_MANY_OBJECTS:
            return "too many objects";
        case VK_ERROR_FORMAT_NOT_SUPPORTED:
            return "a format is not supported";
        case VK_TIMEOUT:
            return "timeout";
        default:
            return fmt::format("result {}", static_cast<int>(result));
    }
}

void fail(VkResult result, std::string_view what)
{
    throw MissingError(fmt::format("Vulkan: {} failed: {}", what, result_text(result)));
}

}   // namespace gnomon::vk
