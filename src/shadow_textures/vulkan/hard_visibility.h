// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the image takes from the lights where edges of shadows are to be hard: those of the casters' triangles, not of
// texels (hard_edges.glsl). The light views still say what changed; their depths are not looked at.
//
// Cost: pixels times lights times the triangles over a cell; with ten thousand leaves between, many.

#include "light_views/vulkan/caster_cells.h"
#include "shadow_textures/vulkan/gpu_visibility.h"

namespace gnomon::shadow_textures {

class HardVisibility {
 public:
    HardVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// Follows the views and the geometry of this frame. Call before `record`, once a frame.
    void update(vk::Commands& commands, const light_views::LightViews& views,
                const light_views::CasterGeometry& casters, const scene::SceneState& state);

    /// @param out  as GpuVisibility::record has it: lights first ... first + count - 1
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
