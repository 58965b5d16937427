// SPDX-License-Identifier: Apache-2.0
#pragma once
// The features every device of ours must have: one list, asked when devices are listed and enabled when one is made.

#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Extensions beyond Vulkan 1.3 that are needed.
inline constexpr const char* k_device_extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};

/// The chain of feature structures of Vulkan 1.0 to 1.3. Points into itself: neither copied nor moved.
struct FeatureChain {
    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};

    FeatureChain();
    FeatureChain(const FeatureChain&) = delete;
    FeatureChain& operator=(const FeatureChain&) = delete;
};

/// Turns on what is needed, and nothing else.
void need_features(FeatureChain& chain);
/// Names of needed features and extensions that a device lacks. The device must have Vulkan 1.3.
std::vector<std::string> missing_features(VkPhysicalDevice device);

}   // namespace gnomon::vk
