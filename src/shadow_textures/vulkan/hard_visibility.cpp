// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/hard_visibility.h"

#include "base/check.h"

namespace gnomon::shadow_textures {

namespace {

constexpr std::uint32_t k_code[] =
#include "shadow_textures/vulkan/visibility_hard.comp.inc"
    ;

std::vector<vk::BlockExpectation> blocks()
{
    using namespace light_views::shared;
    return vk::all_blocks(
        vk::shared_push<shared::LookupConstants>(), look_up_blocks(),
        std::vector{vk::shared_block<CellTriangle>("CellTriangles"), vk::shared_block<AlphaMaterial>("AlphaMaterials"),
                    vk::shared_block<CellBlock>("StaticBlocks"), vk::shared_block<CellBlock>("MovingBlocks"),
                    vk::shared_block<CellEntry>("StaticEntries"), vk::shared_block<CellEntry>("MovingEntries")});
}

}   // namespace

HardVisibility::HardVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views)
    : pipeline_(device, vk::ComputeDesc{.name = "hard shadows",
                                        .code = {"shadow_textures/vulkan/visibility_hard.comp", k_code},
                                        .blocks = blocks()}),
      sampler_(vk::make_sampler(device, {})),
      records_(device, views),
      cells_(device, views)
{
}

void HardVisibility::update(vk::Commands& commands, const light_views::LightViews& views,
                            const light_views::CasterGeometry& casters, const scene::SceneState& state)
{
    records_.update(commands, views);
    cells_.update(commands, views, casters, state);
}

void HardVisibility::record(vk::Commands& commands, const light_views::LightViews& views,
                            const light_views::CasterGeometry& casters, const ImageInputs& inputs, const vk::Image& out,
                            std::uint32_t first, std::uint32_t count)
{
    if (count == 0) return;
    GNOMON_CHECK_LE(count, out.desc().layers);
    GNOMON_CHECK_LE(first + count, views.atlas().first_tile.size() - 1);
    vk::Pass pass = commands.pass("hard shadows");
    records_.declare_views(pass);
    casters.declare_alpha(pass);
    cells_.declare(pass);
    const vk::Image* smooth = inputs.smooth ? inputs.smooth : inputs.normals;
    for (const vk::Image* image : {inputs.positions, inputs.normals, inputs.objects, inputs.smooth})
        if (image) pass.reads(*image, vk::Use::sampled);
    pass.writes(out).compute([&](vk::Recorder& recorder) {
        recorder.bind(pipeline_);
        recorder.set("positions", *inputs.positions, sampler_.get());
        recorder.set("normals", *inputs.normals, sampler_.get());
        recorder.set("objects", *inputs.objects, sampler_.get());
        recorder.set("smooth_normals", *smooth, sampler_.get());
        records_.bind_views(recorder);
        casters.bind_alpha(recorder);
        cells_.bind(recorder);
        recorder.set("visibility", out);
        const glm::uvec2 size(inputs.positions->width(), inputs.positions->height());
        shared::LookupConstants constants = LookupRecords::constants(size, views, nullptr, LookupOptions());
        constants.first_light = first;
        recorder.push(constants);
        recorder.dispatch_over(size.x, size.y, count);
    });
}

}   // namespace gnomon::shadow_textures
