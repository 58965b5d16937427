// SPDX-License-Identifier: Apache-2.0
#pragma once
// Records a method's light views and textures [Oh and Shin 2004], in two steps, which the bench measures apart.
//
// Cost: that of GpuLightViews::record and of GpuTextures.

#include <memory>

#include "shadow_textures/shadow_method.h"
#include "shadow_textures/vulkan/gpu_textures.h"

namespace gnomon::shadow_textures {

/// The method's part of the options of light views.
light_views::LightViewsOptions view_options(ShadowTextures method, light_views::LightViewsOptions options = {});

class MethodTextures {
 public:
    /// @param reads_textures  false: no look-up reads the receivers' textures, so none are made (hard edges)
    MethodTextures(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views,
                   ShadowTextures method, bool reads_textures = true);

    /// Updates the depths and items of the views, by their current plans.
    void record_views(vk::Commands& commands, const light_views::LightViews& views,
                      const light_views::CasterGeometry& casters);
    /// Makes the textures. Call after record_views().
    void record_textures(vk::Commands& commands, const light_views::LightViews& views,
                         const light_views::CasterGeometry& casters, const scene::SceneState& state,
                         const InSight& in_sight = {}, PreviousMethod previous = PreviousMethod::by_extents);

    const light_views::GpuLightViews& buffers() const { return buffers_; }
    /// The receivers' textures, for look-ups; null: the items.
    const GpuTextures* textures() const { return textures_.get(); }
    TextureCounts counts() const { return textures_ ? textures_->counts() : TextureCounts(); }

 private:
    ShadowTextures method_;
    light_views::GpuLightViews buffers_;
    std::unique_ptr<GpuTextures> textures_;
};

}   // namespace gnomon::shadow_textures
