// SPDX-License-Identifier: Apache-2.0
#include "raster/shadow_visibility.h"

namespace gnomon::raster {

namespace {

light_views::LightViewsOptions view_options(const ShadowOptions& options)
{
    light_views::LightViewsOptions result;
    result.atlas = options.atlas;
    result.coherence = options.method == ShadowTextures::coherent;
    result.receivers = options.method == ShadowTextures::depth;
    return result;
}

}   // namespace

ShadowVisibility::ShadowVisibility(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                                   const ShadowOptions& options)
    : options_(options),
      views_(state, view_options(options)),
      casters_(device, state),
      buffers_(device, views_),
      visibility_(device, views_)
{
    if (options.look_up.filter == 0) hard_ = std::make_unique<shadow_textures::HardVisibility>(device, views_);
    if (options.method != ShadowTextures::coherent)
        textures_ = std::make_unique<shadow_textures::GpuTextures>(device, views_);
}

void ShadowVisibility::update(vk::Commands& commands, const scene::SceneState& state)
{
    views_.update(state);
    casters_.update(commands, state);
    buffers_.record(commands, views_, casters_);
    if (hard_) hard_->update(commands, views_, casters_, state);
    draws_ = views_.counts().draws;
    if (options_.method == ShadowTextures::depth) textures_->record(commands, views_, buffers_, casters_, state);
    if (options_.method == ShadowTextures::per_caster) textures_->record_per_caster(commands, views_, casters_, state);
    if (textures_) draws_ += textures_->counts().draws;
}

void ShadowVisibility::fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
                            const vk::Image& visibility)
{
    const shadow_textures::ImageInputs image{&surfaces.position, &surfaces.geometric, &surfaces.ids};
    if (hard_)
        hard_->record(commands, views_, casters_, image, visibility, first, count);
    else
        visibility_.record(commands, views_, buffers_, textures_.get(), image, visibility, options_.look_up, first,
                           count);
}

}   // namespace gnomon::raster
