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
    : device_(device), options_(options), views_(state, view_options(options)), casters_(device, state)
{
    make_buffers();
}

// Makes what depends on the layout of the views.
void ShadowVisibility::make_buffers()
{
    layout_version_ = views_.layout_version();
    hard_.reset(), textures_.reset(), visibility_.reset(), buffers_.reset();   // first, because memory may be scarce
    buffers_ = std::make_unique<light_views::GpuLightViews>(device_, views_);
    visibility_ = std::make_unique<shadow_textures::GpuVisibility>(device_, views_);
    if (options_.look_up.filter == 0) hard_ = std::make_unique<shadow_textures::HardVisibility>(device_, views_);
    if (options_.method != ShadowTextures::coherent)
        textures_ = std::make_unique<shadow_textures::GpuTextures>(device_, views_);
}

void ShadowVisibility::update(vk::Commands& commands, const scene::SceneState& state)
{
    views_.update(state);
    if (layout_version_ != views_.layout_version()) make_buffers();
    casters_.update(commands, state);
    buffers_->record(commands, views_, casters_);
    if (hard_) hard_->update(commands, views_, casters_, state);
    draws_ = views_.counts().draws;
    if (options_.method == ShadowTextures::depth) textures_->record(commands, views_, *buffers_, casters_, state);
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
        visibility_->record(commands, views_, *buffers_, textures_.get(), image, visibility, options_.look_up, first,
                            count);
}

}   // namespace gnomon::raster
