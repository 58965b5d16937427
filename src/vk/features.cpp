// SPDX-License-Identifier: Apache-2.0
#include "vk/features.h"

#include <algorithm>
#include <cstring>
#include <span>

namespace gnomon::vk {

namespace {

struct NeededFeature {
    const char* name;
    VkBool32& (*in)(FeatureChain&);
};

// Lavapipe of Mesa 22.3 supports all of them, and so do desktop GPUs of recent years.
const NeededFeature k_needed[] = {
    {"multiDrawIndirect", [](FeatureChain& f) -> VkBool32& { return f.core.features.multiDrawIndirect; }},
    {"drawIndirectFirstInstance",
     [](FeatureChain& f) -> VkBool32& { return f.core.features.drawIndirectFirstInstance; }},
    {"geometryShader (for primitive numbers in fragments)",
     [](FeatureChain& f) -> VkBool32& { return f.core.features.geometryShader; }},
    {"depthClamp", [](FeatureChain& f) -> VkBool32& { return f.core.features.depthClamp; }},
    {"independentBlend", [](FeatureChain& f) -> VkBool32& { return f.core.features.independentBlend; }},
    {"fragmentStoresAndAtomics", [](FeatureChain& f) -> VkBool32& { return f.core.features.fragmentStoresAndAtomics; }},
    {"shaderStorageImageExtendedFormats",
     [](FeatureChain& f) -> VkBool32& { return f.core.features.shaderStorageImageExtendedFormats; }},
    {"scalarBlockLayout", [](FeatureChain& f) -> VkBool32& { return f.v12.scalarBlockLayout; }},
    {"dynamicRendering", [](FeatureChain& f) -> VkBool32& { return f.v13.dynamicRendering; }},
    {"synchronization2", [](FeatureChain& f) -> VkBool32& { return f.v13.synchronization2; }},
};

const NeededFeature k_needed_for_rays[] = {
    {"accelerationStructure", [](FeatureChain& f) -> VkBool32& { return f.structures.accelerationStructure; }},
    {"rayTracingPipeline", [](FeatureChain& f) -> VkBool32& { return f.ray_pipelines.rayTracingPipeline; }},
    {"bufferDeviceAddress", [](FeatureChain& f) -> VkBool32& { return f.v12.bufferDeviceAddress; }},
};

void note_missing_extensions(VkPhysicalDevice device, std::span<const char* const> wanted,
                             std::vector<std::string>& missing)
{
    std::uint32_t count = 0;
    check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr), "listing a device's extensions");
    std::vector<VkExtensionProperties> all(count);
    check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, all.data()), "listing a device's extensions");
    for (const char* extension : wanted)
        if (std::none_of(all.begin(), all.end(),
                         [&](const auto& e) { return std::strcmp(e.extensionName, extension) == 0; }))
            missing.emplace_back(extension);
}

}   // namespace

FeatureChain::FeatureChain()
{
    core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
}

void FeatureChain::add_ray_tracing()
{
    structures.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
    ray_pipelines.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR;
    v13.pNext = &structures;
    structures.pNext = &ray_pipelines;
}

void enable_features(FeatureChain& chain)
{
    for (const NeededFeature& needed : k_needed) needed.in(chain) = VK_TRUE;
}

std::vector<std::string> missing_features(VkPhysicalDevice device)
{
    std::vector<std::string> missing;
    FeatureChain present;
    vkGetPhysicalDeviceFeatures2(device, &present.core);
    for (const NeededFeature& needed : k_needed)
        if (!needed.in(present)) missing.emplace_back(needed.name);

    note_missing_extensions(device, k_device_extensions, missing);
    return missing;
}

void enable_ray_tracing(FeatureChain& chain)
{
    for (const NeededFeature& needed : k_needed_for_rays) needed.in(chain) = VK_TRUE;
}

std::vector<std::string> missing_ray_tracing(VkPhysicalDevice device)
{
    // Feature structures of an extension must be passed only to devices that have it.
    std::vector<std::string> missing;
    note_missing_extensions(device, k_ray_extensions, missing);
    if (!missing.empty()) return missing;
    FeatureChain present;
    present.add_ray_tracing();
    vkGetPhysicalDeviceFeatures2(device, &present.core);
    for (const NeededFeature& needed : k_needed_for_rays)
        if (!needed.in(present)) missing.emplace_back(needed.name);
    return missing;
}

}   // namespace gnomon::vk
