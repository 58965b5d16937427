// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadows of the rasterised frame, from shadow textures or items that are looked up in light views. What each method
// does is listed in shadow_textures/shadow_method.h. All give the same image, except where two objects are exactly
// equally near to a light (items show the one with the higher number).
//
// Hard edges (a filter of 0) come from the casters' triangles, whatever the method; no texture is made for them.
// With LookupOptions::as_printed, textures or items decide alone, with any filter, and what they decide wrongly is
// counted.

#include <memory>

#include "gnomon/renderer.h"
#include "light_views/light_views.h"
#include "raster/gbuffer.h"
#include "shadow_textures/vulkan/hard_visibility.h"
#include "shadow_textures/vulkan/method_textures.h"

namespace gnomon::raster {

struct ShadowOptions {
    ShadowTextures method = ShadowTextures::items;   // not off
    shadow_textures::LookupOptions look_up;
    /// Finer than the default of light views, because the edges of shadows are seen closely here.
    light_views::AtlasOptions atlas{.view_size = 2048, .budget_texels = 1 << 25};
    // Lights that SurroundingLight brings, and that have no shadows here: those of an environment image; others that
    // are directional.
    bool image_apart = false, suns_apart = false;
};

class ShadowVisibility final : public LightVisibility {
 public:
    /// @throws MissingError  more lights than the atlas's budget holds, or too little device memory
    ShadowVisibility(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                     const ShadowOptions& options = {});

    void update(vk::Commands& commands, const scene::SceneState& state, std::span<const glm::vec4, 6> planes) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
              const vk::Image& visibility) override;
    void end_frame(vk::Commands& commands) override;
    void count(FrameCounters& counters) const override;

    const light_views::LightViews& views() const { return views_; }
    /// What look-ups read: the depths and items of the views, and the receivers' textures. New after an update() that
    /// changed the layout of the views.
    const shadow_textures::MethodTextures& method() const { return *method_; }

 private:
    void make_buffers();

    std::shared_ptr<vk::Device> device_;
    ShadowOptions options_;
    light_views::LightViews views_;
    light_views::CasterGeometry casters_;
    // Made for the layout of the views.
    std::uint32_t layout_version_ = 0;
    std::unique_ptr<shadow_textures::MethodTextures> method_;
    std::unique_ptr<shadow_textures::GpuVisibility> visibility_;
    std::unique_ptr<shadow_textures::HardVisibility> hard_;   // null: filtered edges, or as printed
    vk::Buffer counts_;                                       // as printed: of this frame
};

}   // namespace gnomon::raster
