// SPDX-License-Identifier: Apache-2.0
// Commands inside a pass; every use of a resource is checked against the pass's declarations.
#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "vk/commands.h"

namespace gnomon::vk {

void Recorder::declared(const Buffer* buffer, const Image* image, std::initializer_list<Use> any_of) const
{
    for (const ResourceUse& use : uses_)
        if (use.buffer == buffer && use.image == image &&
            std::find(any_of.begin(), any_of.end(), use.use) != any_of.end())
            return;
    fail_check(__FILE__, __LINE__,
               fmt::format("pass '{}' uses '{}' differently from its declaration", pass_,
                           buffer ? buffer->name() : image->name()));
}

void Recorder::bind(const Pipeline& pipeline)
{
    GNOMON_CHECK((pipeline.bind_point() == VK_PIPELINE_BIND_POINT_GRAPHICS) == (kind_ == Kind::render));
    GNOMON_CHECK((pipeline.bind_point() == VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR) == (kind_ == Kind::trace));
    GNOMON_CHECK(kind_ != Kind::copy && kind_ != Kind::build);
    vkCmdBindPipeline(buffer_, pipeline.bind_point(), pipeline.handle());
    pipeline_ = &pipeline;
    set_ = 0;
    pushed_ = pipeline.push_bytes() == 0;
}

const Binding& Recorder::binding(std::string_view name, VkDescriptorType type) const
{
    GNOMON_CHECK(pipeline_);
    for (const Binding& b : pipeline_->bindings())
        if (b.name == name) {
            if (b.type != type)
                fail_check(__FILE__, __LINE__,
                           fmt::format("'{}': binding '{}' has another type", pipeline_->name(), name));
            return b;
        }
    fail_check(__FILE__, __LINE__, fmt::format("'{}': no binding '{}'", pipeline_->name(), name));
}

void Recorder::write(const Binding& b, const VkDescriptorBufferInfo* buffer, const VkDescriptorImageInfo* image,
                     const VkBufferView* texels, const void* more)
{
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.pNext = more;
    write.dstBinding = b.binding;
    write.descriptorCount = 1;
    write.descriptorType = b.type;
    write.pBufferInfo = buffer;
    write.pImageInfo = image;
    write.pTexelBufferView = texels;
    vkCmdPushDescriptorSetKHR(buffer_, pipeline_->bind_point(), pipeline_->layout(), 0, 1, &write);
    set_ |= std::uint64_t{1} << (&b - pipeline_->bindings().data());
}

void Recorder::set(std::string_view name, const Buffer& buffer, VkDeviceSize offset, VkDeviceSize bytes)
{
    GNOMON_CHECK(pipeline_);
    const auto& all = pipeline_->bindings();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Binding& b) { return b.name == name; });
    const bool uniform = found != all.end() && found->type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    const Binding& b = binding(name, uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    if (uniform)
        declared(&buffer, nullptr, {Use::uniform});
    else if (b.writes)
        declared(&buffer, nullptr, {Use::storage_write});
    else
        declared(&buffer, nullptr, {Use::storage_read, Use::storage_write});
    if (!uniform)
        buffer.device().check_storage_range(buffer.name(), bytes == VK_WHOLE_SIZE ? buffer.bytes() - offset : bytes);
    const VkDescriptorBufferInfo info{buffer.handle(), offset, bytes};
    write(b, &info, nullptr, nullptr);
}

void Recorder::set_texels(std::string_view name, const Buffer& buffer, VkFormat format)
{
    declared(&buffer, nullptr, {Use::sampled});
    const VkBufferView view = buffer.texel_view(format, texel_bytes(format));
    write(binding(name, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER), nullptr, nullptr, &view);
}

void Recorder::set(std::string_view name, const Image& image)
{
    GNOMON_CHECK(pipeline_);
    const auto& all = pipeline_->bindings();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Binding& b) { return b.name == name; });
    const bool storage = found != all.end() && found->type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    const Binding& b = binding(name, storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE);
    if (!storage)
        declared(nullptr, &image, {Use::sampled});
    else if (b.writes)
        declared(nullptr, &image, {Use::storage_write});
    else
        declared(nullptr, &image, {Use::storage_read, Use::storage_write});
    const VkDescriptorImageInfo info{VK_NULL_HANDLE, image.view(), image.state().layout};
    write(b, nullptr, &info, nullptr);
}

void Recorder::set(std::string_view name, const Image& image, VkSampler sampler)
{
    declared(nullptr, &image, {Use::sampled});
    const VkDescriptorImageInfo info{sampler, image.view(), image.state().layout};
    write(binding(name, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER), nullptr, &info, nullptr);
}

void Recorder::set(std::string_view name, const AccelerationStructure& top)
{
    declared(&top.storage(), nullptr, {Use::traced});
    const VkAccelerationStructureKHR handle = top.handle();
    VkWriteDescriptorSetAccelerationStructureKHR info{};
    info.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR;
    info.accelerationStructureCount = 1;
    info.pAccelerationStructures = &handle;
    write(binding(name, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR), nullptr, nullptr, nullptr, &info);
}

void Recorder::push_constants(const void* data, std::size_t bytes)
{
    GNOMON_CHECK(pipeline_);
    GNOMON_CHECK_EQ(bytes, pipeline_->push_bytes());
    vkCmdPushConstants(buffer_, pipeline_->layout(), pipeline_->stages(), 0, static_cast<std::uint32_t>(bytes), data);
    pushed_ = true;
}

// Checks that all bindings of the pipeline have been set since it was bound.
void Recorder::ready() const
{
    GNOMON_CHECK(pipeline_);
    const auto& all = pipeline_->bindings();
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!(set_ >> i & 1))
            fail_check(__FILE__, __LINE__, fmt::format("'{}': '{}' is not set", pipeline_->name(), all[i].name));
    GNOMON_CHECK(pushed_);
}

void Recorder::viewport(const Rect& rect)
{
    const VkViewport viewport{static_cast<float>(rect.x),
                              static_cast<float>(rect.y),
                              static_cast<float>(rect.width),
                              static_cast<float>(rect.height),
                              0,
                              1};
    vkCmdSetViewport(buffer_, 0, 1, &viewport);
}

void Recorder::scissor(const Rect& rect)
{
    const VkRect2D area{{rect.x, rect.y}, {rect.width, rect.height}};
    vkCmdSetScissor(buffer_, 0, 1, &area);
}

void Recorder::cull(VkCullModeFlags mode)
{
    vkCmdSetCullMode(buffer_, mode);
}

void Recorder::vertex_buffer(std::uint32_t location, const Buffer& buffer, VkDeviceSize offset)
{
    declared(&buffer, nullptr, {Use::vertices});
    const VkBuffer handle = buffer.handle();
    vkCmdBindVertexBuffers(buffer_, location, 1, &handle, &offset);
}

void Recorder::index_buffer(const Buffer& buffer, VkDeviceSize offset)
{
    declared(&buffer, nullptr, {Use::vertices});
    vkCmdBindIndexBuffer(buffer_, buffer.handle(), offset, VK_INDEX_TYPE_UINT32);
}

void Recorder::draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
                    std::uint32_t first_instance)
{
    ready();
    ++calls_;
    vkCmdDraw(buffer_, vertices, instances, first_vertex, first_instance);
}

void Recorder::draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
                            std::int32_t vertex_offset, std::uint32_t first_instance)
{
    ready();
    ++calls_;
    vkCmdDrawIndexed(buffer_, indices, instances, first_index, vertex_offset, first_instance);
}

void Recorder::draw_indexed_indirect(const Buffer& buffer, VkDeviceSize offset, std::uint32_t draws)
{
    ready();
    declared(&buffer, nullptr, {Use::indirect});
    ++calls_;
    vkCmdDrawIndexedIndirect(buffer_, buffer.handle(), offset, draws, sizeof(VkDrawIndexedIndirectCommand));
}

void Recorder::clear_depth(const Rect& rect, float value)
{
    VkClearAttachment what{};
    what.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT;
    what.clearValue.depthStencil.depth = value;
    const VkClearRect where{{{rect.x, rect.y}, {rect.width, rect.height}}, 0, 1};
    vkCmdClearAttachments(buffer_, 1, &what, 1, &where);
}

void Recorder::dispatch(std::uint32_t x, std::uint32_t y, std::uint32_t z)
{
    ready();
    ++calls_;
    vkCmdDispatch(buffer_, x, y, z);
}

void Recorder::dispatch_over(std::uint32_t x, std::uint32_t y, std::uint32_t z)
{
    GNOMON_CHECK(pipeline_);
    const std::uint32_t* const size = pipeline_->local_size();
    dispatch((x + size[0] - 1) / size[0], (y + size[1] - 1) / size[1], (z + size[2] - 1) / size[2]);
}

void Recorder::trace(std::uint32_t width, std::uint32_t height)
{
    ready();
    ++calls_;
    const ShaderTable& table = pipeline_->table();
    vkCmdTraceRaysKHR(buffer_, &table.generation, &table.miss, &table.hit, &table.callable, width, height, 1);
}

void Recorder::build(std::span<const StructureBuild> builds, const Buffer& scratch)
{
    GNOMON_CHECK(kind_ == Kind::build);
    if (builds.empty()) return;
    declared(&scratch, nullptr, {Use::build_target});
    std::vector<BuildInfo> infos(builds.size());
    std::vector<VkAccelerationStructureBuildGeometryInfoKHR> geometries;
    std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> ranges;
    for (std::size_t i = 0; i < builds.size(); ++i) {
        const StructureBuild& b = builds[i];
        declared(&b.to->storage(), nullptr, {Use::build_target});
        for (const TriangleGeometry& g : b.desc->triangles)
            for (const Buffer* input : {g.positions, g.indices, g.matrices})
                if (input) declared(input, nullptr, {Use::build_input});
        if (b.desc->instances) declared(b.desc->instances, nullptr, {Use::build_input});
        infos[i].fill(*b.desc);
        infos[i].info.dstAccelerationStructure = b.to->handle();
        infos[i].info.scratchData.deviceAddress = b.scratch;
        geometries.push_back(infos[i].info);
        ranges.push_back(infos[i].ranges.data());
    }
    vkCmdBuildAccelerationStructuresKHR(buffer_, static_cast<std::uint32_t>(geometries.size()), geometries.data(),
                                        ranges.data());
}

void Recorder::copy(const Buffer& from, const Buffer& to, std::span<const VkBufferCopy> regions)
{
    if (regions.empty()) return;
    declared(&from, nullptr, {Use::copy_source});
    declared(&to, nullptr, {Use::copy_target});
    vkCmdCopyBuffer(buffer_, from.handle(), to.handle(), static_cast<std::uint32_t>(regions.size()), regions.data());
}

void Recorder::copy(const Buffer& from, const Image& to, std::span<const VkBufferImageCopy> regions)
{
    declared(&from, nullptr, {Use::copy_source});
    declared(nullptr, &to, {Use::copy_target});
    vkCmdCopyBufferToImage(buffer_, from.handle(), to.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(regions.size()), regions.data());
}

void Recorder::copy(const Image& from, const Buffer& to, std::span<const VkBufferImageCopy> regions)
{
    declared(nullptr, &from, {Use::copy_source});
    declared(&to, nullptr, {Use::copy_target});
    vkCmdCopyImageToBuffer(buffer_, from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                           static_cast<std::uint32_t>(regions.size()), regions.data());
}

void Recorder::copy(const Image& from, const Image& to, std::span<const VkImageCopy> regions)
{
    if (regions.empty()) return;
    declared(nullptr, &from, {Use::copy_source});
    declared(nullptr, &to, {Use::copy_target});
    vkCmdCopyImage(buffer_, from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(regions.size()), regions.data());
}

void Recorder::fill(const Buffer& buffer, std::uint32_t word, VkDeviceSize offset, VkDeviceSize bytes)
{
    declared(&buffer, nullptr, {Use::copy_target});
    vkCmdFillBuffer(buffer_, buffer.handle(), offset, bytes, word);
}

void Recorder::clear(const Image& image, float value)
{
    declared(nullptr, &image, {Use::copy_target});
    VkClearColorValue color{};
    std::fill(std::begin(color.float32), std::end(color.float32), value);
    const VkImageSubresourceRange all{image.aspect(), 0, 1, 0, image.desc().layers};
    vkCmdClearColorImage(buffer_, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &all);
}

}   // namespace gnomon::vk
