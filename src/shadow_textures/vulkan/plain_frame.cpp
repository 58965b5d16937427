// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/plain_frame.h"

#include "base/bits.h"

namespace gnomon::shadow_textures {

namespace {

constexpr std::uint32_t k_vert[] =
#include "shadow_textures/vulkan/plain_frame.vert.inc"
    ;
constexpr std::uint32_t k_frag[] =
#include "shadow_textures/vulkan/plain_frame.frag.inc"
    ;

}   // namespace

PlainFrame::PlainFrame(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views,
                       std::uint32_t width, std::uint32_t height)
    : records_(device, views),
      color_(device, {.name = "plain frame",
                      .width = width,
                      .height = height,
                      .format = VK_FORMAT_R8G8B8A8_UNORM,
                      .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT}),
      depth_(device, {.name = "plain frame's depth",
                      .width = width,
                      .height = height,
                      .format = VK_FORMAT_D32_SFLOAT,
                      .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT}),
      draws_(device, "plain frame's draws",
             std::max<std::size_t>(views.object_count(), 1) * sizeof(VkDrawIndexedIndirectCommand))
{
    vk::GraphicsDesc desc;
    desc.name = "plain frame";
    desc.vertex = {"shadow_textures/vulkan/plain_frame.vert", k_vert};
    desc.fragment = {"shadow_textures/vulkan/plain_frame.frag", k_frag};
    desc.colors = {color_.format()};
    desc.depth = depth_.format();
    desc.blocks = vk::all_blocks(vk::shared_push<shared::PlainConstants>(), look_up_blocks());
    desc.blocks.push_back(vk::shared_block<shared::TexturePlace>("Places"));
    pipeline_ = vk::Pipeline(device, desc);
}

void PlainFrame::record(vk::Commands& commands, const light_views::LightViews& views,
                        const light_views::GpuLightViews& buffers, const GpuTextures* textures,
                        const light_views::CasterGeometry& casters, const scene::SceneState& state,
                        const glm::mat4& clip_from_world, const glm::vec3& eye, const LookupOptions& options)
{
    records_.update(commands, views);

    // Rebuild the list of visible objects, which rarely changes.
    std::vector<VkDrawIndexedIndirectCommand> draws;
    for (scene::ObjectId o = 0; o < views.object_count(); ++o)
        if (state.object_visible(o) && casters.opaque(o).index_count > 0)
            draws.push_back(casters.draw(o, casters.opaque(o)));
    if (!same_bits(draws, sent_draws_)) {
        const vk::Upload upload = vk::upload_of(draws_, std::span<const VkDrawIndexedIndirectCommand>(draws));
        commands.upload("plain frame's draws", std::span(&upload, 1));
        sent_draws_ = draws;
    }

    vk::Pass pass = commands.pass("plain frame");
    casters.declare(pass);
    records_.declare(pass, buffers, textures).reads(draws_, vk::Use::indirect);
    pass.color({.image = &color_, .clear = VkClearColorValue{{0, 0, 0, 1}}})
        .depth({.image = &depth_, .clear = 0.0f})
        .render([&](vk::Recorder& recorder) {
            if (draws.empty()) return;
            recorder.bind(pipeline_);
            casters.bind(recorder, false);
            records_.bind(recorder, buffers, textures);
            const auto lights = static_cast<std::uint32_t>(views.atlas().first_tile.size() - 1);
            recorder.push(shared::PlainConstants{
                clip_from_world, eye, lights,
                LookupRecords::constants({color_.width(), color_.height()}, views, textures, options)});
            recorder.draw_indexed_indirect(draws_, 0, static_cast<std::uint32_t>(draws.size()));
        });
}

}   // namespace gnomon::shadow_textures
