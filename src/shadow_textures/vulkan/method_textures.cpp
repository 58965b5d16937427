// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/method_textures.h"

namespace gnomon::shadow_textures {

light_views::LightViewsOptions view_options(ShadowTextures method, light_views::LightViewsOptions options)
{
    options.coherence = keeps_views(method);
    options.receivers = makes_textures(method);
    return options;
}

MethodTextures::MethodTextures(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views,
                               ShadowTextures method, bool reads_textures)
    : method_(method), buffers_(device, views)
{
    if (makes_textures(method) && reads_textures) textures_ = std::make_unique<GpuTextures>(device, views);
}

void MethodTextures::record_views(vk::Commands& commands, const light_views::LightViews& views,
                                  const light_views::CasterGeometry& casters)
{
    buffers_.record(commands, views, casters);
}

void MethodTextures::record_textures(vk::Commands& commands, const light_views::LightViews& views,
                                     const light_views::CasterGeometry& casters, const scene::SceneState& state,
                                     const InSight& in_sight, PreviousMethod previous)
{
    if (!textures_) return;
    if (method_ == ShadowTextures::per_caster)
        textures_->record_per_caster(commands, views, casters, state, previous, in_sight);
    else
        textures_->record(commands, views, buffers_, casters, state, in_sight);
}

}   // namespace gnomon::shadow_textures
