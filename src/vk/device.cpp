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

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = info_.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;

    FeatureChain features;
    need_features(features);
    VkDeviceCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    create.pNext = &features.core;
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.enabledExtensionCount = std::size(k_device_extensions);
    create.ppEnabledExtensionNames = k_device_extensions;
    check(vkCreateDevice(info_.handle, &create, nullptr, &handle_), fmt::format("opening '{}'", info_.name));
    vkGetDeviceQueue(handle_, info_.queue_family, 0, &queue_);
    memory_ = std::make_unique<Memory>(info_.handle, handle_);
}

Device::~Device()
{
    vkDeviceWaitIdle(handle_);
    memory_.reset();
    vkDestroyDevice(handle_, nullptr);
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
