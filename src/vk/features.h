// SPDX-License-Identifier: Apache-2.0
#pragma once
// The features that every device must have: one list, checked when devices are listed and enabled when a device is
// created. Also the features for ray tracing, which are optional and enabled only if all of them are available.

#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Required extensions beyond Vulkan 1.3.
inline constexpr const char* k_device_extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};

/// Extensions for ray-tracing pipelines. Ray queries are not used, because some devices lack them.
inline constexpr const char* k_ray_extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                                   VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                                   VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME};

/// The chain of feature structures of Vulkan 1.0 to 1.3. Contains pointers to itself, so it is neither copied nor
/// moved.
struct FeatureChain {
    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures{};   // in the chain after add_ray_tracing()
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR ray_pipelines{};   // in the chain after add_ray_tracing()

    FeatureChain();
    /// Only for devices with the ray-tracing extensions.
    void add_ray_tracing();
    FeatureChain(const FeatureChain&) = delete;
    FeatureChain& operator=(const FeatureChain&) = delete;
};

/// Enables exactly the required features.
void enable_features(FeatureChain& chain);
/// Names of required features and extensions that a device lacks. The device must support Vulkan 1.3.
std::vector<std::string> missing_features(VkPhysicalDevice device);

/// Enables the features for ray tracing. @pre chain.add_ray_tracing()
void enable_ray_tracing(FeatureChain& chain);
/// Names of extensions and features for ray tracing that a device lacks.
std::vector<std::string> missing_ray_tracing(VkPhysicalDevice device);

}   // namespace gnomon::vk
