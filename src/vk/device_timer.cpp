// SPDX-License-Identifier: Apache-2.0
#include "vk/device_timer.h"

#include "gnomon/error.h"

namespace gnomon::vk {

DeviceTimer::DeviceTimer(const std::shared_ptr<Device>& device) : device_(device)
{
    if (device->timestamp_period() <= 0) throw MissingError("Vulkan: the device has no timestamps");
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.queueFamilyIndex = device->queue_family();
    VkCommandPool pool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device->handle(), &pool_info, nullptr, &pool), "making a command pool");
    pool_ = {device, pool, [](const Device& d, VkCommandPool p) { vkDestroyCommandPool(d.handle(), p, nullptr); }};

    VkCommandBufferAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    info.commandPool = pool;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device->handle(), &info, &buffer_), "making a command buffer");

    VkQueryPoolCreateInfo query_info{};
    query_info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    query_info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    query_info.queryCount = 2;
    VkQueryPool queries = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device->handle(), &query_info, nullptr, &queries), "making timestamps");
    queries_ = {device, queries, [](const Device& d, VkQueryPool q) { vkDestroyQueryPool(d.handle(), q, nullptr); }};

    VkFenceCreateInfo fence_info{};
    fence_info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    VkFence fence = VK_NULL_HANDLE;
    check(vkCreateFence(device->handle(), &fence_info, nullptr, &fence), "making a fence");
    fence_ = {device, fence, [](const Device& d, VkFence f) { vkDestroyFence(d.handle(), f, nullptr); }};
}

void DeviceTimer::stamp(std::uint32_t which)
{
    check(vkResetCommandPool(device_->handle(), pool_.get(), 0), "recording");
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(buffer_, &begin), "recording");
    vkCmdResetQueryPool(buffer_, queries_.get(), which, 1);
    vkCmdWriteTimestamp2(buffer_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_.get(), which);
    check(vkEndCommandBuffer(buffer_), "recording");
    VkCommandBufferSubmitInfo commands{};
    commands.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    commands.commandBuffer = buffer_;
    VkSubmitInfo2 info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &commands;
    const VkFence fence = fence_.get();
    check(vkResetFences(device_->handle(), 1, &fence), "sending work");
    check(vkQueueSubmit2(device_->queue(), 1, &info, fence), "sending work");
    check(vkWaitForFences(device_->handle(), 1, &fence, VK_TRUE, UINT64_MAX), "waiting for the device");
}

double DeviceTimer::stop()
{
    stamp(1);
    std::uint64_t stamps[2];
    check(vkGetQueryPoolResults(device_->handle(), queries_.get(), 0, 2, sizeof stamps, stamps, 8,
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "reading timestamps");
    return static_cast<double>(stamps[1] - stamps[0]) * device_->timestamp_period() * 1e-6;
}

}   // namespace gnomon::vk
