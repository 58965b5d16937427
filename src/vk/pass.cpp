// SPDX-License-Identifier: Apache-2.0
// Declares passes, and records what surrounds their bodies: barriers, rendering scope, label, timestamps.
#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "vk/commands.h"

namespace gnomon::vk {

Pass& Pass::uses(const Pipeline& pipeline)
{
    pipeline_ = &pipeline;
    return *this;
}

const Binding& Pass::binding(const char* name) const
{
    GNOMON_CHECK(pipeline_);
    const auto& all = pipeline_->bindings();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Binding& b) { return b.name == name; });
    if (found == all.end())
        fail_check(__FILE__, __LINE__, fmt::format("'{}': no binding '{}'", pipeline_->name(), name));
    return *found;
}

Pass& Pass::binds(const char* name, const Buffer& buffer)
{
    const Binding& b = binding(name);
    bound_.push_back({.binding = name, .buffer = &buffer});
    uses_.push_back({&buffer, nullptr,
                     b.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER ? Use::uniform
                     : b.writes                                  ? Use::storage_write
                                                                 : Use::storage_read});
    return *this;
}

Pass& Pass::binds(const char* name, const Image& image)
{
    const Binding& b = binding(name);
    bound_.push_back({.binding = name, .image = &image});
    uses_.push_back({nullptr, &image,
                     b.type != VK_DESCRIPTOR_TYPE_STORAGE_IMAGE ? Use::sampled
                     : b.writes                                 ? Use::storage_write
                                                                : Use::storage_read});
    return *this;
}

Pass& Pass::binds_texels(const char* name, const Buffer& buffer, VkFormat format)
{
    binding(name);
    bound_.push_back({.binding = name, .buffer = &buffer, .format = format});
    uses_.push_back({&buffer, nullptr, Use::sampled});
    return *this;
}

void Pass::fill_bindings(Recorder& recorder) const
{
    recorder.bind(*pipeline_);
    for (const Bound& bound : bound_) {
        if (bound.image)
            recorder.set(bound.binding, *bound.image);
        else if (bound.format != VK_FORMAT_UNDEFINED)
            recorder.set_texels(bound.binding, *bound.buffer, bound.format);
        else
            recorder.set(bound.binding, *bound.buffer);
    }
}

Pass& Pass::reads(const Buffer& buffer, Use use)
{
    uses_.push_back({&buffer, nullptr, use});
    return *this;
}

Pass& Pass::reads(const Image& image, Use use)
{
    uses_.push_back({nullptr, &image, use});
    return *this;
}

Pass& Pass::writes(const Buffer& buffer, Use use)
{
    GNOMON_CHECK(use == Use::storage_write || use == Use::copy_target || use == Use::build_target);
    uses_.push_back({&buffer, nullptr, use});
    return *this;
}

Pass& Pass::writes(const Image& image, Use use)
{
    GNOMON_CHECK(use == Use::storage_write || use == Use::copy_target);
    uses_.push_back({nullptr, &image, use});
    return *this;
}

Pass& Pass::color(const ColorTarget& target)
{
    colors_.push_back(target);
    uses_.push_back({nullptr, target.image, Use::color_target});
    return *this;
}

Pass& Pass::depth(const DepthTarget& target)
{
    depth_ = target;
    uses_.push_back({nullptr, target.image, target.write ? Use::depth_target : Use::depth_test});
    return *this;
}

Pass& Pass::area(const Rect& rect)
{
    area_ = rect;
    return *this;
}

void Pass::render(const std::function<void(Recorder&)>& body)
{
    GNOMON_CHECK(depth_ || !colors_.empty());
    record(Recorder::Kind::render, body);
}

void Pass::compute(const std::function<void(Recorder&)>& body)
{
    record(Recorder::Kind::compute, body);
}

void Pass::trace(const std::function<void(Recorder&)>& body)
{
    record(Recorder::Kind::trace, body);
}

void Pass::build(const std::function<void(Recorder&)>& body)
{
    record(Recorder::Kind::build, body);
}

void Pass::copy(const std::function<void(Recorder&)>& body)
{
    record(Recorder::Kind::copy, body);
}

void Pass::begin_rendering(VkCommandBuffer buffer) const
{
    const Image& any = depth_ ? *depth_->image : *colors_[0].image;
    const Rect whole{0, 0, any.width(), any.height()};
    const Rect area = area_.value_or(whole);
    std::vector<VkRenderingAttachmentInfo> colors;
    for (const ColorTarget& target : colors_) {
        VkRenderingAttachmentInfo& info = colors.emplace_back();
        info = {};
        info.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        info.imageView = target.image->layer_view(target.layer);
        info.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        info.loadOp = target.clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        if (target.clear) info.clearValue.color = *target.clear;
    }
    VkRenderingAttachmentInfo depth{};
    if (depth_) {
        depth.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        depth.imageView = depth_->image->layer_view(depth_->layer);
        depth.imageLayout =
            depth_->write ? VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL;
        depth.loadOp = depth_->clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        depth.storeOp = depth_->write ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_NONE;
        if (depth_->clear) depth.clearValue.depthStencil.depth = *depth_->clear;
    }
    VkRenderingInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    info.renderArea = {{area.x, area.y}, {area.width, area.height}};
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<std::uint32_t>(colors.size());
    info.pColorAttachments = colors.data();
    info.pDepthAttachment = depth_ ? &depth : nullptr;
    vkCmdBeginRendering(buffer, &info);
}

namespace {

// Labels the commands that are recorded during its lifetime. Also ends the label on exceptions, because drivers may
// keep open ones.
class Label {
 public:
    Label(VkCommandBuffer buffer, const std::string& name, bool there) : buffer_(there ? buffer : VK_NULL_HANDLE)
    {
        VkDebugUtilsLabelEXT label{};
        label.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT;
        label.pLabelName = name.c_str();
        if (buffer_) vkCmdBeginDebugUtilsLabelEXT(buffer_, &label);
    }
    ~Label()
    {
        if (buffer_) vkCmdEndDebugUtilsLabelEXT(buffer_);
    }
    Label(const Label&) = delete;
    Label& operator=(const Label&) = delete;

 private:
    VkCommandBuffer buffer_;
};

}   // namespace

void Pass::record(Recorder::Kind kind, const std::function<void(Recorder&)>& body)
{
    commands_.begin();
    const VkCommandBuffer buffer = commands_.submission_.buffer();
    const Label label(buffer, name_, commands_.device_->instance().has_debug_utils());
    commands_.barriers(uses_, kind);
    const auto slot = static_cast<std::uint32_t>(commands_.timed_.size());
    const bool timed = commands_.queries_ && slot < Commands::k_max_timed;
    if (timed) {
        commands_.timed_.push_back(name_);
        vkCmdWriteTimestamp2(buffer, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, commands_.queries_.get(), 2 * slot);
    }

    Recorder recorder(buffer, kind, uses_, name_);
    if (kind == Recorder::Kind::render) {
        begin_rendering(buffer);
        const Image& any = depth_ ? *depth_->image : *colors_[0].image;
        const Rect area = area_.value_or(Rect{0, 0, any.width(), any.height()});
        recorder.viewport(area);
        recorder.scissor(area);
        recorder.cull(VK_CULL_MODE_NONE);
    }
    if (pipeline_) fill_bindings(recorder);
    body(recorder);
    if (kind == Recorder::Kind::render) vkCmdEndRendering(buffer);
    commands_.draw_calls_ += recorder.calls_;

    if (timed)
        vkCmdWriteTimestamp2(buffer, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, commands_.queries_.get(), 2 * slot + 1);
}

}   // namespace gnomon::vk
