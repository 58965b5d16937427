// SPDX-License-Identifier: Apache-2.0
#include "vk/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "vk/barriers.h"

namespace gnomon::vk {

namespace {

constexpr VkPipelineStageFlags2 k_drawing =
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
constexpr VkPipelineStageFlags2 k_tracing = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;

}   // namespace

Commands::Commands(const std::shared_ptr<Device>& device) : device_(device), submission_(device)
{
    if (device->timestamp_period() > 0) queries_ = make_timestamps(device, 2 * k_max_timed);
}

Commands::~Commands() = default;

void Commands::begin()
{
    if (recording_) return;
    submission_.begin();
    if (queries_) vkCmdResetQueryPool(submission_.buffer(), queries_.get(), 0, 2 * k_max_timed);
    recording_ = true;
    timed_.clear();
    draw_calls_ = 0;
}

void Commands::barriers(const std::vector<ResourceUse>& uses, Recorder::Kind kind)
{
    const VkPipelineStageFlags2 shaders = kind == Recorder::Kind::render  ? k_drawing
                                          : kind == Recorder::Kind::trace ? k_tracing
                                                                          : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    std::vector<VkBufferMemoryBarrier2> buffers;
    std::vector<VkImageMemoryBarrier2> images;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        const ResourceUse& first = uses[i];
        const auto same = [&](const ResourceUse& u) { return u.buffer == first.buffer && u.image == first.image; };
        if (std::any_of(uses.begin(), uses.begin() + static_cast<std::ptrdiff_t>(i), same)) continue;

        // Combine all uses of one resource in this pass.
        UseMeaning use = meaning(first.use, shaders);
        for (std::size_t j = i + 1; j < uses.size(); ++j) {
            if (!same(uses[j])) continue;
            const UseMeaning more = meaning(uses[j].use, shaders);
            GNOMON_CHECK(!first.image || more.layout == use.layout);   // one layout per pass
            use.stages |= more.stages;
            use.access |= more.access;
            use.writes = use.writes || more.writes;
        }
        UseState& state = first.image ? first.image->state() : first.buffer->state();
        const std::optional<Wait> wait = follow(state, use, first.image != nullptr);
        if (!wait) continue;
        // Convert the wait to a barrier.
        if (first.image) {
            VkImageMemoryBarrier2& barrier = images.emplace_back();
            barrier = {};
            barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
            barrier.srcStageMask = wait->from_stages, barrier.srcAccessMask = wait->from_access;
            barrier.dstStageMask = wait->to_stages, barrier.dstAccessMask = wait->to_access;
            barrier.oldLayout = wait->from_layout, barrier.newLayout = wait->to_layout;
            barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            barrier.image = first.image->handle();
            barrier.subresourceRange = {first.image->aspect(), 0, 1, 0, first.image->desc().layers};
        } else {
            VkBufferMemoryBarrier2& barrier = buffers.emplace_back();
            barrier = {};
            barrier.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2;
            barrier.srcStageMask = wait->from_stages, barrier.srcAccessMask = wait->from_access;
            barrier.dstStageMask = wait->to_stages, barrier.dstAccessMask = wait->to_access;
            barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            barrier.buffer = first.buffer->handle();
            barrier.size = VK_WHOLE_SIZE;
        }
    }
    if (buffers.empty() && images.empty()) return;
    VkDependencyInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.bufferMemoryBarrierCount = static_cast<std::uint32_t>(buffers.size());
    info.pBufferMemoryBarriers = buffers.data();
    info.imageMemoryBarrierCount = static_cast<std::uint32_t>(images.size());
    info.pImageMemoryBarriers = images.data();
    vkCmdPipelineBarrier2(submission_.buffer(), &info);
}

void Commands::upload(const std::string& name, std::span<const Upload> uploads)
{
    constexpr VkDeviceSize alignment = 16;
    VkDeviceSize total = 0;
    for (const Upload& u : uploads) total += (u.bytes.size() + alignment - 1) / alignment * alignment;
    if (total == 0) return;
    const Buffer& staging = staging_.emplace_back(device_, name + " (staging)", total, Access::upload);

    // Copy the bytes to a staging buffer, and group the copies by target.
    std::vector<std::pair<const Buffer*, std::vector<VkBufferCopy>>> copies;
    VkDeviceSize at = 0;
    for (const Upload& u : uploads) {
        if (u.bytes.empty()) continue;
        GNOMON_CHECK_LE(u.offset + u.bytes.size(), u.to->bytes());
        std::memcpy(staging.mapped() + at, u.bytes.data(), u.bytes.size());
        auto found = std::find_if(copies.begin(), copies.end(), [&](const auto& c) { return c.first == u.to; });
        if (found == copies.end()) found = copies.insert(copies.end(), {u.to, {}});
        found->second.push_back({at, u.offset, u.bytes.size()});
        at += (u.bytes.size() + alignment - 1) / alignment * alignment;
    }
    Pass copying = pass(name);
    copying.reads(staging, Use::copy_source);
    for (const auto& [buffer, regions] : copies) copying.writes(*buffer, Use::copy_target);
    copying.copy([&](Recorder& r) {
        for (const auto& [buffer, regions] : copies) r.copy(staging, *buffer, regions);
    });
}

Buffer Commands::read_back(const Buffer& from, VkDeviceSize bytes)
{
    if (bytes == VK_WHOLE_SIZE) bytes = from.bytes();
    Buffer to(device_, from.name() + " (read back)", bytes, Access::readback);
    read_back(from, to, bytes);
    return to;
}

void Commands::read_back(const Buffer& from, const Buffer& to, VkDeviceSize bytes)
{
    GNOMON_CHECK_LE(bytes, from.bytes());
    pass("read back " + from.name()).reads(from, Use::copy_source).writes(to, Use::copy_target).copy([&](Recorder& r) {
        const VkBufferCopy first{0, 0, bytes};
        r.copy(from, to, {&first, 1});
    });
    barriers({{&to, nullptr, Use::host_read}}, Recorder::Kind::copy);
}

Buffer Commands::read_back(const Image& from, std::uint32_t layer)
{
    const VkDeviceSize bytes = VkDeviceSize{from.width()} * from.height() * texel_bytes(from.format());
    Buffer to(device_, from.name() + " (read back)", bytes, Access::readback);
    pass("read back " + from.name()).reads(from, Use::copy_source).writes(to, Use::copy_target).copy([&](Recorder& r) {
        VkBufferImageCopy all{};
        all.imageSubresource = {from.aspect(), 0, layer, 1};
        all.imageExtent = {from.width(), from.height(), 1};
        r.copy(from, to, {&all, 1});
    });
    barriers({{&to, nullptr, Use::host_read}}, Recorder::Kind::copy);
    return to;
}

void Commands::submit()
{
    begin();
    recording_ = false;
    submission_.submit();
    staging_.clear();

    timings_.clear();
    if (!timed_.empty()) {
        std::vector<std::uint64_t> stamps(2 * timed_.size());
        check(vkGetQueryPoolResults(device_->handle(), queries_.get(), 0, static_cast<std::uint32_t>(stamps.size()),
                                    stamps.size() * 8, stamps.data(), 8, VK_QUERY_RESULT_64_BIT),
              "reading timestamps");
        for (std::size_t i = 0; i < timed_.size(); ++i)
            timings_.push_back({timed_[i], static_cast<double>(stamps[2 * i + 1] - stamps[2 * i]) *
                                               device_->timestamp_period() * 1e-6});
    }
    if (device_->instance().validates()) check_validation();
}

}   // namespace gnomon::vk
