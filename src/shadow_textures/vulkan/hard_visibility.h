// SPDX-License-Identifier: Apache-2.0
#pragma once
// Computes the visibility of lights at each pixel with hard shadow edges: those of the casters' triangles, not of
// texels (hard_edges.glsl). The light views only provide the changes; their depths are not used.
//
// Cost: pixels times lights times the triangles over a cell, which is high where thousands of leaves overlap.

#include "light_views/vulkan/caster_cells.h"
#include "shadow_textures/vulkan/gpu_visibility.h"

namespace gnomon::shadow_textures {

class HardVisibility {
 public:
    HardVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// Updates the lists for this frame's views and geometry. Call once per frame, before `record`.
    void update(vk::Commands& commands, const light_views::LightViews& views,
                const light_views::CasterGeometry& casters, const scene::SceneState& state);

    /// @param out  as for GpuVisibility::record, with lights first ... first + count - 1
    void record(vk::Commands& commands, const light_views::LightViews& views,
                const light_views::CasterGeometry& casters, const ImageInputs& inputs, const vk::Image& out,
                std::uint32_t first, std::uint32_t count);

    const light_views::CasterCells& cells() const { return cells_; }

 private:
    vk::Pipeline pipeline_;
    vk::Owned<VkSampler> sampler_;
    LookupRecords records_;
    light_views::CasterCells cells_;
};

}   // namespace gnomon::shadow_textures
