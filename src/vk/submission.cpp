// SPDX-License-Identifier: Apache-2.0
#include "vk/submission.h"

namespace gnomon::vk {

Submission::Submission(const std::shared_ptr<Device>& device) : device_(device)
{
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.queueFamilyIndex = device->queue_family();
    VkCommandPool pool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device->handle(), &pool_info, nullptr, &pool), "creating a command pool");
    pool_ = {device, pool, [](const Device& d, VkCommandPool p) { vkDestroyCommandPool(d.handle(), p, nullptr); }};

    VkCommandBufferAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    info.commandPool = pool;
    info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    info.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device->handle(), &info, &buffer_), "creating a command buffer");

    VkFenceCreateInfo fence_info{};
    fence_info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    VkFence fence = VK_NULL_HANDLE;
    check(vkCreateFence(device->handle(), &fence_info, nullptr, &fence), "creating a fence");
    fence_ = {device, fence, [](const Device& d, VkFence f) { vkDestroyFence(d.handle(), f, nullptr); }};
}

void Submission::begin()
{
    check(vkResetCommandPool(device_->handle(), pool_.get(), 0), "recording");
    VkCommandBufferBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(buffer_, &info), "recording");
}

void Submission::submit()
{
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

Owned<VkQueryPool> make_timestamps(const std::shared_ptr<Device>& device, std::uint32_t count)
{
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = count;
    VkQueryPool queries = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device->handle(), &info, nullptr, &queries), "making timestamps");
    return {device, queries, [](const Device& d, VkQueryPool q) { vkDestroyQueryPool(d.handle(), q, nullptr); }};
}

}   // namespace gnomon::vk
