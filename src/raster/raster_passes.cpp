// SPDX-License-Identifier: Apache-2.0
// The pipelines and passes of the rasterised frame.
#include <algorithm>

#include "gpu_scene/scene_blocks.h"
#include "raster/raster_formats.h"
#include "raster/raster_frame.h"

namespace gnomon::raster {

namespace {

using shared::BouncePush;
using shared::DrawPush;
using shared::ResolvePush;
using shared::ShadePush;
using shared::SurroundingPush;
using vk::Use;

constexpr std::uint32_t k_visibility_vert[] =
#include "raster/visibility.vert.inc"
    ;
constexpr std::uint32_t k_visibility_frag[] =
#include "raster/visibility.frag.inc"
    ;
constexpr std::uint32_t k_masked_vert[] =
#include "raster/visibility_masked.vert.inc"
    ;
constexpr std::uint32_t k_masked_frag[] =
#include "raster/visibility_masked.frag.inc"
    ;
constexpr std::uint32_t k_peel_frag[] =
#include "raster/visibility_peel.frag.inc"
    ;
constexpr std::uint32_t k_resolve_comp[] =
#include "raster/resolve.comp.inc"
    ;
constexpr std::uint32_t k_shade_comp[] =
#include "raster/shade.comp.inc"
    ;
constexpr std::uint32_t k_surrounding_comp[] =
#include "raster/surrounding.comp.inc"
    ;
constexpr std::uint32_t k_bounce_comp[] =
#include "raster/bounce.comp.inc"
    ;

}   // namespace

void RasterFrame::make_pipelines()
{
    using vk::ComputeDesc;
    using vk::GraphicsDesc;
    const vk::BlockExpectation draw_push = vk::shared_push<DrawPush>();
    const std::vector frame_block{vk::shared_block<shared::RasterFrame>("Frame")};
    opaque_ = vk::Pipeline(device_, GraphicsDesc{.name = "ids",
                                                 .vertex = {"visibility.vert", k_visibility_vert},
                                                 .fragment = {"visibility.frag", k_visibility_frag},
                                                 .colors = {k_id_format},
                                                 .depth = k_depth_format,
                                                 .blocks = vk::all_blocks(draw_push, gpu_scene::draw_blocks())});
    masked_ = vk::Pipeline(device_, GraphicsDesc{.name = "ids with holes",
                                                 .vertex = {"visibility_masked.vert", k_masked_vert},
                                                 .fragment = {"visibility_masked.frag", k_masked_frag},
                                                 .colors = {k_id_format},
                                                 .depth = k_depth_format,
                                                 .blocks = vk::all_blocks(draw_push, gpu_scene::scene_data_blocks())});
    peel_ = vk::Pipeline(device_, GraphicsDesc{.name = "peel",
                                               .vertex = {"visibility.vert", k_visibility_vert},
                                               .fragment = {"visibility_peel.frag", k_peel_frag},
                                               .colors = {k_id_format},
                                               .depth = k_depth_format,
                                               .blocks = vk::all_blocks(draw_push, gpu_scene::draw_blocks())});
    resolve_ = vk::Pipeline(
        device_, ComputeDesc{.name = "surfaces",
                             .code = {"resolve.comp", k_resolve_comp},
                             .blocks = vk::all_blocks(
                                 vk::shared_push<ResolvePush>(), gpu_scene::scene_data_blocks(),
                                 std::vector{vk::shared_block<gpu_scene::shared::GpuLayers>("layers")}, frame_block)});
    shade_ = vk::Pipeline(
        device_,
        ComputeDesc{.name = "lights",
                    .code = {"shade.comp", k_shade_comp},
                    .blocks = vk::all_blocks(vk::shared_push<ShadePush>(), frame_block,
                                             std::vector{vk::shared_block<gpu_scene::shared::GpuLight>("lights")})});
    surrounding_ = vk::Pipeline(device_, ComputeDesc{.name = "light of surroundings",
                                                     .code = {"surrounding.comp", k_surrounding_comp},
                                                     .blocks = {vk::shared_push<SurroundingPush>()}});
    bounce_ = vk::Pipeline(device_, ComputeDesc{.name = "bounced light",
                                                .code = {"bounce.comp", k_bounce_comp},
                                                .blocks = vk::all_blocks(vk::shared_push<BouncePush>(), frame_block)});
}

void RasterFrame::draw_groups(vk::Recorder& r, scene::SurfaceClass surface) const
{
    for (const gpu_scene::DrawGroup& group : scene_.groups()) {
        if (group.surface != surface) continue;
        r.cull(group.cull);
        r.draw_indexed_indirect(scene_.commands_buffer, group.first * sizeof(VkDrawIndexedIndirectCommand),
                                group.count);
    }
}

void RasterFrame::draw_ids(const DrawPush& push)
{
    const auto has = [&](scene::SurfaceClass surface) {
        return std::any_of(scene_.groups().begin(), scene_.groups().end(),
                           [&](const gpu_scene::DrawGroup& g) { return g.surface == surface; });
    };
    commands_.pass("ids")
        .reads(scene_.objects, Use::storage_read)
        .reads(scene_.draws, Use::storage_read)
        .reads(scene_.materials, Use::storage_read)
        .reads(scene_.textures, Use::storage_read)
        .reads(scene_.texels, Use::sampled)
        .reads(scene_.texcoords, Use::storage_read)
        .reads(scene_.colors, Use::storage_read)
        .reads(scene_.positions, Use::vertices)
        .reads(scene_.indices, Use::vertices)
        .reads(scene_.commands_buffer, Use::indirect)
        .color({.image = &opaque_ids_, .clear = VkClearColorValue{}})
        .depth({.image = &opaque_depth_, .clear = 0.0f})
        .render([&](vk::Recorder& r) {
            const auto bind = [&](const vk::Pipeline& pipeline) {
                r.bind(pipeline);
                r.set("objects", scene_.objects);
                r.set("draws", scene_.draws);
                r.push(push);
                r.vertex_buffer(0, scene_.positions);
                r.index_buffer(scene_.indices);
            };
            if (has(scene::SurfaceClass::opaque)) {
                bind(opaque_);
                draw_groups(r, scene::SurfaceClass::opaque);
            }
            if (has(scene::SurfaceClass::masked)) {
                bind(masked_);
                r.set("materials", scene_.materials);
                r.set("textures", scene_.textures);
                r.set_texels("texels", scene_.texels, gpu_scene::GpuScene::k_texel_format);
                r.set("texcoords", scene_.texcoords);
                r.set("colors", scene_.colors);
                draw_groups(r, scene::SurfaceClass::masked);
            }
        });
}

void RasterFrame::peel(const DrawPush& push, const vk::Image& last_depth, const vk::Image& depth)
{
    commands_.pass("peel")
        .uses(peel_)
        .binds("objects", scene_.objects)
        .binds("draws", scene_.draws)
        .binds("opaque_depth", opaque_depth_)
        .binds("last_depth", last_depth)
        .reads(scene_.positions, Use::vertices)
        .reads(scene_.indices, Use::vertices)
        .reads(scene_.commands_buffer, Use::indirect)
        .color({.image = &peeled_ids_, .clear = VkClearColorValue{}})
        .depth({.image = &depth, .clear = 0.0f})
        .render([&](vk::Recorder& r) {
            r.push(push);
            r.vertex_buffer(0, scene_.positions);
            r.index_buffer(scene_.indices);
            draw_groups(r, scene::SurfaceClass::transparent);
        });
}

void RasterFrame::resolve(const ResolvePush& push)
{
    commands_.pass("surfaces")
        .uses(resolve_)
        .binds("objects", scene_.objects)
        .binds("draws", scene_.draws)
        .binds("materials", scene_.materials)
        .binds("layers", scene_.layers)
        .binds("textures", scene_.textures)
        .binds_texels("texels", scene_.texels, gpu_scene::GpuScene::k_texel_format)
        .binds("texcoords", scene_.texcoords)
        .binds("colors", scene_.colors)
        .binds("positions", scene_.positions)
        .binds("normals", scene_.normals)
        .binds("tangents", scene_.tangents)
        .binds("indices", scene_.indices)
        .binds("Frame", frame_)
        .binds_texels("environment", environment_, k_wide_format)
        .binds("opaque_ids", opaque_ids_)
        .binds("peeled_ids", peeled_ids_)
        .binds("color", color_)
        .binds("through", through_)
        .binds("share", share_)
        .binds("g_position", surfaces_.position)
        .binds("g_normal", surfaces_.normal)
        .binds("g_geometric", surfaces_.geometric)
        .binds("g_smooth", surfaces_.smooth)
        .binds("g_diffuse", surfaces_.diffuse)
        .binds("g_specular", surfaces_.specular)
        .binds("g_ids", surfaces_.ids)
        .compute([&](vk::Recorder& r) {
            r.push(push);
            r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
        });
}

// Adds all lights. Where lights with size and surroundings light by themselves, the lights that approximate them are
// left out.
void RasterFrame::light(const RasterOptions& options, const scene::View& view, bool layers)
{
    const std::vector<scene::Light>& lights = described_->lights;
    const auto left_out = [&](std::uint32_t l) {
        return (sized_ && lights[l].of_surface) || (surroundings_ && surroundings_->brings(l));
    };
    const auto all = static_cast<std::uint32_t>(lights.size());
    for (std::uint32_t first = 0, end = 0; first < all; first = end) {
        for (end = first + 1; end < all && left_out(end) == left_out(first);) ++end;
        if (!left_out(first)) light_by(first, end, options, layers);
    }
    if (sized_) sized_->add(commands_, {surfaces_, share_, frame_, view}, color_, direct_, layers);
    if (surroundings_) light_by_surroundings(view, options, layers);
}

void RasterFrame::light_by_surroundings(const scene::View& view, const RasterOptions& options, bool layers)
{
    // Surfaces that were kept have the light that they had: whatever changes in the scene makes them anew.
    if (!surfaces_.kept) surroundings_->fill(commands_, surfaces_, view, surrounding_light_);
    commands_.pass("light of surroundings")
        .uses(surrounding_)
        .binds("surroundings", surrounding_light_)
        .binds("share", share_)
        .binds("color", color_)
        .binds("direct", direct_)
        .compute([&](vk::Recorder& r) {
            r.push(SurroundingPush{layers ? 1u : 0u});
            r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
        });
    if (!layers) return;
    const std::size_t lights = described_->lights.size();
    for (std::size_t l = 0; l < lights; ++l) {
        const std::span<const float> visible = surroundings_->visible(static_cast<scene::LightId>(l));
        if (visible.empty()) continue;
        if (surrounding_visible_.data.empty())
            surrounding_visible_ = ImageF(size_.width, size_.height, static_cast<int>(lights));
        for (std::size_t i = 0; i < visible.size(); ++i)
            surrounding_visible_.data[i * lights + l] += visible[i] / static_cast<float>(options.samples);
    }
}

// Adds a run of lights, in batches where shadows are filled in. Of the layers of lit pixels a shader may get fewer at
// once than a batch has: the pass then goes over the batch again for the others. It adds to the colours the first time
// alone, so that these do not depend on the number of layers.
void RasterFrame::light_by(std::uint32_t begin, std::uint32_t end, const RasterOptions& options, bool layers)
{
    const std::uint32_t lights = end - begin, batch = visibility_ ? std::max(1u, options.light_batch) : lights;
    const VkDeviceSize one = lit_pixels(size_) * sizeof(float), most = device_->limits().maxStorageBufferRange;
    const auto at_once = static_cast<std::uint32_t>(layers ? std::min<VkDeviceSize>(most / one, lights) : lights);
    for (std::uint32_t first = begin; first < end; first += batch) {
        const std::uint32_t count = std::min(batch, end - first);
        if (visibility_) visibility_->fill(commands_, surfaces_, first, count, lights_visible_);
        commands_.pass("lights")
            .uses(shade_)
            .binds("Frame", frame_)
            .binds("lights", scene_.lights)
            .binds("color", color_)
            .binds("direct", direct_)
            .binds("share", share_)
            .binds("g_position", surfaces_.position)
            .binds("g_normal", surfaces_.normal)
            .binds("g_geometric", surfaces_.geometric)
            .binds("g_smooth", surfaces_.smooth)
            .binds("g_diffuse", surfaces_.diffuse)
            .binds("g_specular", surfaces_.specular)
            .binds("visibility", lights_visible_)
            .writes(lit_)
            .compute([&](vk::Recorder& r) {
                for (std::uint32_t lit = 0; lit < count; lit += at_once) {
                    const std::uint32_t bound = std::min(at_once, count - lit);
                    r.set("lit_layers", lit_, layers ? (first + lit) * one : 0, layers ? bound * one : lit_.bytes());
                    r.push(ShadePush{first, count, visibility_ ? 1u : 0u, lit == 0 ? 1u : 0u, layers ? 1u : 0u, lit,
                                     layers ? bound : 0, static_cast<std::uint32_t>(lit_pixels(size_))});
                    r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
                }
            });
    }
}

void RasterFrame::bounce(const scene::View& view, bool layers)
{
    if (!bounced_) return;
    bounced_->fill(commands_, surfaces_, view, irradiance_);
    commands_.pass("bounced light")
        .uses(bounce_)
        .binds("Frame", frame_)
        .binds("color", color_)
        .binds("indirect", indirect_)
        .binds("share", share_)
        .binds("g_position", surfaces_.position)
        .binds("g_normal", surfaces_.normal)
        .binds("g_geometric", surfaces_.geometric)
        .binds("g_diffuse", surfaces_.diffuse)
        .binds("g_specular", surfaces_.specular)
        .binds("irradiance", irradiance_)
        .compute([&](vk::Recorder& r) {
            r.push(BouncePush{layers ? 1u : 0u});
            r.dispatch_over(static_cast<std::uint32_t>(size_.width), static_cast<std::uint32_t>(size_.height));
        });
}

void RasterFrame::clear(const vk::Image& image, float value)
{
    if (vk::is_depth(image.format())) {
        commands_.pass("clear " + image.name()).depth({.image = &image, .clear = value}).render([](vk::Recorder&) {});
        return;
    }
    commands_.pass("clear " + image.name()).writes(image, Use::copy_target).copy([&](vk::Recorder& r) {
        r.clear(image, value);
    });
}

void RasterFrame::copy(const vk::Image& from, const vk::Image& to)
{
    commands_.pass("keep " + from.name())
        .reads(from, Use::copy_source)
        .writes(to, Use::copy_target)
        .copy([&](vk::Recorder& r) {
            VkImageCopy all{};
            all.srcSubresource = all.dstSubresource = {from.aspect(), 0, 0, 1};
            all.extent = {from.width(), from.height(), 1};
            r.copy(from, to, {&all, 1});
        });
}

}   // namespace gnomon::raster
