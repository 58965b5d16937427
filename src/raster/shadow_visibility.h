// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadows of the rasterised frame: light views that follow what moves, and shadow textures looked up in them.
//
// Coherent: light views keep what stood still, and the item of each texel stands for all receivers' textures at once
// (see shadow_textures/vulkan/gpu_textures.h). By depth, and by casters between: everything is drawn anew in every
// frame, and each receiver's own texture is looked up; the same images, at their methods' cost.

#include "gnomon/renderer.h"
#include "light_views/light_views.h"
#include "raster/gbuffer.h"
#include "shadow_textures/vulkan/hard_visibility.h"

namespace gnomon::raster {

struct ShadowOptions {
    ShadowTextures method = ShadowTextures::coherent;   // not off
    shadow_textures::LookupOptions look_up;
    /// Finer than a light view is by default: edges of shadows are looked at closely here.
    light_views::AtlasOptions atlas{.view_size = 2048, .budget_texels = 1 << 25};
};

class ShadowVisibility final : public LightVisibility {
 public:
    /// @throws MissingError  more lights than the atlas's budget holds, or too little device memory
    ShadowVisibility(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                     const ShadowOptions& options = {});

    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state,
                const scene::View& view) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
              const vk::Image& visibility) override;
    std::uint64_t draws() const override { return draws_; }

    const light_views::LightViews& views() const { return views_; }

 private:
    ShadowOptions options_;
    light_views::LightViews views_;
    light_views::CasterGeometry casters_;
    light_views::GpuLightViews buffers_;
    std::unique_ptr<shadow_textures::GpuTextures> textures_;   // null: items are looked up
    shadow_textures::GpuVisibility visibility_;
    std::unique_ptr<shadow_textures::HardVisibility> hard_;   // where edges are hard
    std::uint64_t draws_ = 0;
};

}   // namespace gnomon::raster
