// SPDX-License-Identifier: Apache-2.0
#include "light_views/vulkan/gpu_light_views.h"

#include <bit>

namespace gnomon::light_views {

namespace {

constexpr std::uint32_t k_vert[] =
#include "light_views/vulkan/caster.vert.inc"
    ;
constexpr std::uint32_t k_frag[] =
#include "light_views/vulkan/caster.frag.inc"
    ;
constexpr std::uint32_t k_masked_frag[] =
#include "light_views/vulkan/caster_masked.frag.inc"
    ;

constexpr VkFormat k_depth_format = VK_FORMAT_D32_SFLOAT, k_item_format = VK_FORMAT_R32_UINT;

vk::Rect in_page(const Tile& tile, const Rect& rect)
{
    return {tile.x + rect.x0, tile.y + rect.y0, static_cast<std::uint32_t>(rect.width()),
            static_cast<std::uint32_t>(rect.height())};
}

VkImageCopy region(const Tile& tile, const Rect& rect)
{
    VkImageCopy copy{};
    const auto layer = static_cast<std::uint32_t>(tile.page);
    copy.srcSubresource = copy.dstSubresource = {0, 0, layer, 1};   // the aspects differ per image
    copy.srcOffset = copy.dstOffset = {tile.x + rect.x0, tile.y + rect.y0, 0};
    copy.extent = {static_cast<std::uint32_t>(rect.width()), static_cast<std::uint32_t>(rect.height()), 1};
    return copy;
}

}   // namespace

GpuLightViews::GpuLightViews(const std::shared_ptr<vk::Device>& device, const LightViews& views)
    : device_(device), pages_(std::max(views.atlas().pages, 1))
{
    const auto side = static_cast<std::uint32_t>(std::max(views.atlas().page_size, 1));
    const auto image = [&](const char* name, VkFormat format, VkImageUsageFlags usage) {
        return vk::Image(device, {.name = name,
                                  .width = side,
                                  .height = side,
                                  .layers = static_cast<std::uint32_t>(pages_),
                                  .format = format,
                                  .usage = usage | VK_IMAGE_USAGE_SAMPLED_BIT,
                                  .array = true});
    };
    for (Layers* layers : {&rendering_, &statics_}) {
        const bool statics = layers == &statics_;
        layers->depth = image(statics ? "static light depths" : "light depths", k_depth_format,
                              VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
        layers->item =
            image(statics ? "static light items" : "light items", k_item_format, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    }
    sampler_ = vk::make_sampler(device, {});
    for (const bool perspective : {true, false})
        for (const bool masked : {true, false}) {
            vk::GraphicsDesc desc;
            desc.name = masked ? "alpha-tested casters" : "casters";
            desc.vertex = {"light_views/vulkan/caster.vert", k_vert};
            if (masked)
                desc.fragment = {"light_views/vulkan/caster_masked.frag", k_masked_frag};
            else
                desc.fragment = {"light_views/vulkan/caster.frag", k_frag};
            desc.colors = {k_item_format};
            desc.blocks = {vk::shared_push<shared::CasterConstants>()};
            if (masked) desc.blocks.push_back(vk::shared_block<shared::AlphaMaterial>("AlphaMaterials"));
            desc.depth = k_depth_format;
            desc.depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
            // Keep objects in front of a directional light's view, because they cast shadows into it.
            desc.depth_clamp = !perspective;
            pipelines_[perspective ? 0 : 1][masked ? 1 : 0] = vk::Pipeline(device, desc);
        }
}

GpuLightViews::Batch GpuLightViews::begin_batch(std::uint32_t view, const Rect& scissor, bool ties) const
{
    Batch batch;
    batch.view = view;
    batch.scissor = scissor;
    batch.ties = ties;
    batch.first = static_cast<std::uint32_t>(commands_.size());
    batch.first_masked = static_cast<std::uint32_t>(masked_.size());
    return batch;
}

void GpuLightViews::add_object(Batch& batch, const CasterGeometry& casters, scene::ObjectId object)
{
    if (const CasterGeometry::Part& part = casters.opaque(object); part.index_count > 0) {
        commands_.push_back(casters.draw(object, part));
        ++batch.count;
    }
    for (const CasterGeometry::Part& part : casters.masked(object)) {
        masked_.push_back({casters.draw(object, part), part.material});
        ++batch.masked_count;
    }
}

void GpuLightViews::end_batch(Phase& phase, Batch batch)
{
    if (batch.count + batch.masked_count > 0) phase.batches.push_back(batch);
}

// Converts the plans to clears, copies and draws.
void GpuLightViews::gather(const LightViews& views, const CasterGeometry& casters)
{
    commands_.clear(), masked_.clear();
    for (Phase* phase : {&rebuild_, &settle_, &dynamics_}) phase->batches.clear(), phase->cleared.clear();
    erase_.clear(), keep_rebuilt_.clear(), keep_settled_.clear();

    for (std::uint32_t v = 0; v < views.views().size(); ++v) {
        const LightView& view = views.views()[v];
        const ViewPlan& plan = view.plan;
        if (plan.kind == ViewPlan::Kind::idle) continue;
        const Rect whole = view.projection.whole();
        // Steps 1 and 2: rectangles to copy and to clear.
        for (const Rect& rect : plan.erase) erase_.push_back(region(view.tile, rect));
        for (const Rect& rect : plan.rebuild) {
            rebuild_.cleared.emplace_back(v, rect);
            keep_rebuilt_.push_back(region(view.tile, rect));
        }
        // Step 3: draw static objects, one batch per rectangle.
        for (std::size_t i = 0; i < plan.redraw.size();) {
            const std::uint32_t rect = plan.redraw[i].rect;
            Batch batch = begin_batch(v, plan.rebuild[rect], false);
            for (; i < plan.redraw.size() && plan.redraw[i].rect == rect; ++i)
                add_object(batch, casters, plan.redraw[i].object);
            end_batch(rebuild_, batch);
        }
        // Step 5: draw objects that came to rest.
        Batch settling = begin_batch(v, whole, true);
        for (const ViewPlan::Settle& settle : plan.settle) {
            add_object(settling, casters, settle.object);
            keep_settled_.push_back(region(view.tile, settle.rect));
        }
        end_batch(settle_, settling);
        // Step 7: draw dynamic objects.
        const bool restless = plan.kind == ViewPlan::Kind::restless;
        if (restless) dynamics_.cleared.emplace_back(v, whole);
        Batch moving = begin_batch(v, whole, !restless);
        for (const scene::ObjectId object : plan.dynamics) add_object(moving, casters, object);
        end_batch(dynamics_, moving);
    }
}

void GpuLightViews::clear_all(vk::Commands& commands)
{
    for (const Layers* layers : {&rendering_, &statics_})
        for (int page = 0; page < pages_; ++page) {
            const auto layer = static_cast<std::uint32_t>(page);
            commands.pass("light views: empty")
                .color({.image = &layers->item, .layer = layer, .clear = VkClearColorValue{}})
                .depth({.image = &layers->depth, .layer = layer, .clear = 0.0f})
                .render([](vk::Recorder&) {});
        }
    cleared_ = true;
}

void GpuLightViews::copy(vk::Commands& commands, const char* name, const Layers& from, const Layers& to,
                         const std::vector<VkImageCopy>& regions) const
{
    if (regions.empty()) return;
    commands.pass(name)
        .reads(from.depth, vk::Use::copy_source)
        .reads(from.item, vk::Use::copy_source)
        .writes(to.depth, vk::Use::copy_target)
        .writes(to.item, vk::Use::copy_target)
        .copy([&](vk::Recorder& recorder) {
            std::vector<VkImageCopy> of_aspect = regions;
            for (const auto& [source, target] : {std::pair(&from.depth, &to.depth), std::pair(&from.item, &to.item)}) {
                for (VkImageCopy& r : of_aspect)
                    r.srcSubresource.aspectMask = r.dstSubresource.aspectMask = source->aspect();
                recorder.copy(*source, *target, of_aspect);
            }
        });
}

void GpuLightViews::draw(vk::Commands& commands, const char* name, const Phase& phase, const LightViews& views,
                         const CasterGeometry& casters) const
{
    if (phase.batches.empty() && phase.cleared.empty()) return;
    for (int page = 0; page < pages_; ++page) {
        const auto on_page = [&](std::uint32_t view) { return views.views()[view].tile.page == page; };
        const bool any =
            std::any_of(phase.batches.begin(), phase.batches.end(), [&](const Batch& b) { return on_page(b.view); }) ||
            std::any_of(phase.cleared.begin(), phase.cleared.end(), [&](const auto& c) { return on_page(c.first); });
        if (!any) continue;
        const auto layer = static_cast<std::uint32_t>(page);
        vk::Pass pass = commands.pass(name);
        casters.declare(pass).reads(statics_.depth, vk::Use::sampled).reads(statics_.item, vk::Use::sampled);
        if (!commands_.empty()) pass.reads(indirect_, vk::Use::indirect);
        pass.color({.image = &rendering_.item, .layer = layer})
            .depth({.image = &rendering_.depth, .layer = layer})
            .render([&](vk::Recorder& recorder) {
                // Clear rectangles.
                for (const auto& [v, rect] : phase.cleared) {
                    if (!on_page(v)) continue;
                    const vk::Rect r = in_page(views.views()[v].tile, rect);
                    VkClearAttachment what[2]{};
                    what[0].aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
                    what[1].aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT;
                    const VkClearRect where{{{r.x, r.y}, {r.width, r.height}}, 0, 1};
                    vkCmdClearAttachments(recorder.handle(), 2, what, 1, &where);
                }
                // Draw the batches, with as few changes of pipeline as possible.
                const vk::Pipeline* bound = nullptr;
                const auto bind = [&](const LightView& view, bool masked) {
                    const vk::Pipeline& wanted = pipeline(view.projection.perspective, masked);
                    if (bound == &wanted) return;
                    bound = &wanted;
                    recorder.bind(wanted);
                    casters.bind(recorder, masked);
                    recorder.set("static_depth", statics_.depth, sampler());
                    recorder.set("static_item", statics_.item, sampler());
                };
                for (const Batch& batch : phase.batches) {
                    if (!on_page(batch.view)) continue;
                    const LightView& view = views.views()[batch.view];
                    recorder.viewport(in_page(view.tile, view.projection.whole()));
                    recorder.scissor(in_page(view.tile, batch.scissor));
                    shared::CasterConstants constants{view.projection.clip_from_world, layer, batch.ties ? 1u : 0u, 0,
                                                      0};
                    if (batch.count > 0) {
                        bind(view, false);
                        recorder.push(constants);
                        recorder.draw_indexed_indirect(indirect_, batch.first * sizeof(VkDrawIndexedIndirectCommand),
                                                       batch.count);
                    }
                    for (std::uint32_t i = 0; i < batch.masked_count; ++i) {
                        const MaskedDraw& masked = masked_[batch.first_masked + i];
                        bind(view, true);
                        constants.material = masked.material;
                        recorder.push(constants);
                        recorder.draw_indexed(masked.command.indexCount, 1, masked.command.firstIndex,
                                              masked.command.vertexOffset, masked.command.firstInstance);
                    }
                }
            });
    }
}

void GpuLightViews::record(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters)
{
    if (!cleared_) clear_all(commands);
    gather(views, casters);
    if (!commands_.empty()) {
        const std::size_t bytes = commands_.size() * sizeof(VkDrawIndexedIndirectCommand);
        if (!indirect_ || indirect_.bytes() < bytes)
            indirect_ = vk::Buffer(device_, "light view draws", std::bit_ceil(bytes));
        const vk::Upload upload = vk::upload_of(indirect_, std::span<const VkDrawIndexedIndirectCommand>(commands_));
        commands.upload("light view draws", std::span(&upload, 1));
    }
    copy(commands, "light views: erase", statics_, rendering_, erase_);
    draw(commands, "light views: rebuild", rebuild_, views, casters);
    copy(commands, "light views: keep", rendering_, statics_, keep_rebuilt_);
    draw(commands, "light views: settle", settle_, views, casters);
    copy(commands, "light views: keep", rendering_, statics_, keep_settled_);
    draw(commands, "light views: draw", dynamics_, views, casters);
}

}   // namespace gnomon::light_views
