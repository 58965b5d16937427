// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadows of the rasterised frame, from shadow textures that are looked up in light views.
//
// ShadowTextures::coherent: light views keep the depths of static objects, and the item of each texel takes the place
// of all receivers' textures (see shadow_textures/vulkan/gpu_textures.h). ShadowTextures::depth and per_caster draw
// everything anew in every frame and look up each receiver's own texture: the same images, at those methods' cost.

#include <memory>

#include "gnomon/renderer.h"
#include "light_views/light_views.h"
#include "raster/gbuffer.h"
#include "shadow_textures/vulkan/hard_visibility.h"

namespace gnomon::raster {

struct ShadowOptions {
    ShadowTextures method = ShadowTextures::coherent;   // not off
    shadow_textures::LookupOptions look_up;
    /// Finer than the default of light views, because the edges of shadows are seen closely here.
    light_views::AtlasOptions atlas{.view_size = 2048, .budget_texels = 1 << 25};
};

class ShadowVisibility final : public LightVisibility {
 public:
    /// @throws MissingError  more lights than the atlas's budget holds, or too little device memory
    ShadowVisibility(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                     const ShadowOptions& options = {});

    void update(vk::Commands& commands, const scene::SceneState& state) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
              const vk::Image& visibility) override;
    std::uint64_t draws() const override { return draws_; }

    const light_views::LightViews& views() const { return views_; }

 private:
    void make_buffers();

    std::shared_ptr<vk::Device> device_;
    ShadowOptions options_;
    light_views::LightViews views_;
    light_views::CasterGeometry casters_;
    // Made for the layout of the views.
    std::uint32_t layout_version_ = 0;
    std::unique_ptr<light_views::GpuLightViews> buffers_;
    std::unique_ptr<shadow_textures::GpuTextures> textures_;   // null: coherent
    std::unique_ptr<shadow_textures::GpuVisibility> visibility_;
    std::unique_ptr<shadow_textures::HardVisibility> hard_;   // null: filtered edges
    std::uint64_t draws_ = 0;
};

}   // namespace gnomon::raster
