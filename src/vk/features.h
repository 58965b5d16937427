// SPDX-License-Identifier: Apache-2.0
#pragma once
// The features every device of ours must have: one list, asked when devices are listed and enabled when one is made.
// And those of ray tracing, which a device may lack: enabled where all of them are there.

#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Extensions beyond Vulkan 1.3 that are needed.
inline constexpr const char* k_device_extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};

/// Those by which rays are traced in pipelines. Ray queries are not among them: there are devices without.
inline constexpr const char* k_ray_extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                                   VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                                   VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME};

/// The chain of feature structures of Vulkan 1.0 to 1.3. Points into itself: neither copied nor moved.
struct FeatureChain {
    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures{};   // in the chain after add_rays()
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR ray_pipelines{};   // so is this

    FeatureChain();
    /// For devices that know the extensions of ray tracing.
    void add_rays();
    FeatureChain(const FeatureChain&) = delete;
    FeatureChain& operator=(const FeatureChain&) = delete;
};

/// Turns on what is needed, and nothing else.
void need_features(FeatureChain& chain);
/// Names of needed features and extensions that a device lacks. The device must have Vulkan 1.3.
std::vector<std::string> missing_features(VkPhysicalDevice device);

/// Turns on what traces rays. @pre chain.add_rays()
void need_rays(FeatureChain& chain);
/// Names of extensions and features for tracing rays that a device lacks.
std::vector<std::string> missing_for_rays(VkPhysicalDevice device);

}   // namespace gnomon::vk
