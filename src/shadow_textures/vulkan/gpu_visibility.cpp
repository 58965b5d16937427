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
    : pipeline_(device,
                vk::ComputeDesc{.name = "shadow look-up", .code = {"shadow_textures/vulkan/visibility.comp", k_code}}),
      records_(device, views)
{
}

void GpuVisibility::record(vk::Commands& commands, const light_views::LightViews& views,
                           const light_views::GpuLightViews& buffers, const GpuTextures* textures,
                           const PictureInputs& picture, const vk::Image& out, const LookupOptions& options)
{
    const std::size_t lights = views.atlas().first_tile.size() - 1;
    if (lights == 0) return;
    GNOMON_CHECK_LE(lights, out.desc().layers);
    records_.update(commands, views);
    vk::Pass pass = commands.pass("shadow look-up");
    records_.declare(pass, buffers, textures);
    for (const vk::Image* image : {picture.positions, picture.normals, picture.objects})
        pass.reads(*image, vk::Use::sampled);
    pass.writes(out).compute([&](vk::Recorder& recorder) {
        recorder.bind(pipeline_);
        recorder.set("positions", *picture.positions, buffers.sampler());
        recorder.set("normals", *picture.normals, buffers.sampler());
        recorder.set("objects", *picture.objects, buffers.sampler());
        records_.bind(recorder, buffers, textures);
        recorder.set("visibility", out);
        const glm::uvec2 size(picture.positions->width(), picture.positions->height());
        recorder.push(LookupRecords::constants(size, views, textures, options));
        recorder.dispatch_over(size.x, size.y, static_cast<std::uint32_t>(lights));
    });
}

}   // namespace gnomon::shadow_textures
