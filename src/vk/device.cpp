// SPDX-License-Identifier: Apache-2.0
#include "vk/device.h"

#include <fmt/format.h>

#include "gnomon/error.h"
#include "vk/features.h"

namespace gnomon::vk {

namespace {

DeviceInfo choose(const Instance& instance)
{
    const std::vector<DeviceInfo> all = instance.devices();
    if (all.empty()) throw MissingError("Vulkan: there is no device (no driver is installed)");
    if (!all.front().suitable)
        throw MissingError(fmt::format("Vulkan: no suitable device: '{}': {}", all.front().name,
                                       fmt::join(all.front().reasons, ", ")));
    return all.front();
}

RayLimits ask_ray_limits(VkPhysicalDevice device)
{
    VkPhysicalDeviceAccelerationStructurePropertiesKHR structures{};
    structures.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR pipelines{};
    pipelines.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR;
    pipelines.pNext = &structures;
    VkPhysicalDeviceProperties2 all{};
    all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    all.pNext = &pipelines;
    vkGetPhysicalDeviceProperties2(device, &all);
    return {pipelines.shaderGroupHandleSize,
            pipelines.shaderGroupHandleAlignment,
            pipelines.shaderGroupBaseAlignment,
            structures.minAccelerationStructureScratchOffsetAlignment,
            pipelines.maxRayDispatchInvocationCount,
            structures.maxInstanceCount,
            structures.maxPrimitiveCount};
}

}   // namespace

std::shared_ptr<Device> Device::open()
{
    return std::shared_ptr<Device>(new Device);
}

Device::Device() : instance_(Instance::get()), info_(choose(*instance_))
{
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(info_.handle, &properties);
    limits_ = properties.limits;
    timestamp_period_ = limits_.timestampComputeAndGraphics ? limits_.timestampPeriod : 0;

    std::vector<const char*> extensions(std::begin(k_device_extensions), std::end(k_device_extensions));
    FeatureChain features;
    enable_features(features);
    if (traces_rays()) {
        extensions.insert(extensions.end(), std::begin(k_ray_extensions), std::end(k_ray_extensions));
        features.add_ray_tracing();
        enable_ray_tracing(features);
        ray_limits_ = ask_ray_limits(info_.handle);
    }

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = info_.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;

    VkDeviceCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    create.pNext = &features.core;
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    create.ppEnabledExtensionNames = extensions.data();
    check(vkCreateDevice(info_.handle, &create, nullptr, &handle_), fmt::format("opening '{}'", info_.name));
    vkGetDeviceQueue(handle_, info_.queue_family, 0, &queue_);
    memory_ = std::make_unique<Memory>(info_.handle, handle_, traces_rays(), instance_->validates());
}

Device::~Device()
{
    vkDeviceWaitIdle(handle_);
    memory_.reset();
    vkDestroyDevice(handle_, nullptr);
}

void Device::check_storage_range(const std::string& name, VkDeviceSize bytes) const
{
    if (bytes > limits_.maxStorageBufferRange)
        throw MissingError(fmt::format("Vulkan: '{}' needs {} MiB, but the device can address only {} MiB", name,
                                       (bytes + (1 << 20) - 1) >> 20, limits_.maxStorageBufferRange >> 20));
}

void Device::name(VkObjectType type, std::uint64_t object, const std::string& text) const
{
    if (!instance_->has_debug_utils()) return;
    VkDebugUtilsObjectNameInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT;
    info.objectType = type;
    info.objectHandle = object;
    info.pObjectName = text.c_str();
    vkSetDebugUtilsObjectNameEXT(handle_, &info);
}

}   // namespace gnomon::vk
