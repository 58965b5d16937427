// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/gpu_visibility.h"

#include "base/check.h"

namespace gnomon::shadow_textures {

namespace {

constexpr std::uint32_t k_code[] =
#include "shadow_textures/vulkan/visibility.comp.inc"
    ;

}   // namespace

GpuVisibility::GpuVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views)
    : pipeline_(device, vk::ComputeDesc{.name = "shadow look-up",
                                        .code = {"shadow_textures/vulkan/visibility.comp", k_code},
                                        .blocks = vk::all_blocks(
                                            vk::shared_push<shared::LookupConstants>(), look_up_blocks(),
                                            std::vector{vk::shared_block<shared::TexturePlace>("Places"),
                                                        vk::shared_block<shared::LookupCounts>("Counts")})}),
      records_(device, views),
      counts_(device, "look-up counts", sizeof(shared::LookupCounts))
{
}

void GpuVisibility::begin_counts(vk::Commands& commands) const
{
    commands.pass("forget look-up counts").writes(counts_, vk::Use::copy_target).copy([&](vk::Recorder& r) {
        r.fill(counts_, 0);
    });
}

void GpuVisibility::record(vk::Commands& commands, const light_views::LightViews& views,
                           const light_views::GpuLightViews& buffers, const GpuTextures* textures,
                           const ImageInputs& inputs, const vk::Image& out, const LookupOptions& options)
{
    const auto lights = static_cast<std::uint32_t>(views.atlas().first_tile.size() - 1);
    record(commands, views, buffers, textures, inputs, out, options, 0, lights);
}

void GpuVisibility::record(vk::Commands& commands, const light_views::LightViews& views,
                           const light_views::GpuLightViews& buffers, const GpuTextures* textures,
                           const ImageInputs& inputs, const vk::Image& out, const LookupOptions& options,
                           std::uint32_t first, std::uint32_t count)
{
    if (count == 0) return;
    GNOMON_CHECK_LE(count, out.desc().layers);
    GNOMON_CHECK_LE(first + count, views.atlas().first_tile.size() - 1);
    records_.update(commands, views);
    vk::Pass pass = commands.pass("shadow look-up");
    records_.declare(pass, buffers, textures);
    const vk::Image* smooth = inputs.smooth ? inputs.smooth : inputs.normals;
    for (const vk::Image* image : {inputs.positions, inputs.normals, inputs.objects, inputs.smooth})
        if (image) pass.reads(*image, vk::Use::sampled);
    pass.writes(out).writes(counts_).compute([&](vk::Recorder& recorder) {
        recorder.bind(pipeline_);
        recorder.set("Counts", counts_);
        recorder.set("positions", *inputs.positions, buffers.sampler());
        recorder.set("normals", *inputs.normals, buffers.sampler());
        recorder.set("objects", *inputs.objects, buffers.sampler());
        recorder.set("smooth_normals", *smooth, buffers.sampler());
        records_.bind(recorder, buffers, textures);
        recorder.set("visibility", out);
        const glm::uvec2 size(inputs.positions->width(), inputs.positions->height());
        shared::LookupConstants constants = LookupRecords::constants(size, views, textures, options);
        constants.first_light = first;
        recorder.push(constants);
        recorder.dispatch_over(size.x, size.y, count);
    });
}

}   // namespace gnomon::shadow_textures
