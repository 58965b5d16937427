// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light views on the device: carries out the plans of LightViews, for all views of one page of the atlas together.
//
// Two atlases (static and rendering) have two layers each: depth (32-bit float, reversed) and item (object + 1). A
// frame without changes records nothing. All draws use one vertex shader with an invariant position, and every
// rectangle is redrawn with the viewport of its whole view; so the same triangle gives the same depth, bit for bit.
// Cost: that of the plans. Memory: 16 bytes per texel of the atlas.

#include "light_views/light_views.h"
#include "light_views/vulkan/caster_geometry.h"

namespace gnomon::light_views {

class GpuLightViews {
 public:
    /// @throws MissingError  too little device memory for the atlas
    GpuLightViews(const std::shared_ptr<vk::Device>& device, const LightViews& views);

    /// Records the steps of the views' current plans. The geometry must be up to date.
    void record(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters);

    const vk::Image& depth() const { return rendering_.depth; }
    const vk::Image& item() const { return rendering_.item; }
    const vk::Image& static_depth() const { return statics_.depth; }
    const vk::Image& static_item() const { return statics_.item; }
    /// Nearest-neighbour, for texelFetch.
    VkSampler sampler() const { return sampler_.get(); }

 private:
    struct Layers {
        vk::Image depth, item;
    };
    // Draws in one view under one scissor: ranges of indirect commands, and single alpha-tested parts.
    struct Batch {
        std::uint32_t view = 0;
        Rect scissor;   // in texels of the view
        bool ties = false;
        std::uint32_t first = 0, count = 0;                 // opaque: indirect commands
        std::uint32_t first_masked = 0, masked_count = 0;   // ranges in masked_
    };
    struct MaskedDraw {
        VkDrawIndexedIndirectCommand command;
        std::uint32_t material;
    };
    struct Phase {
        std::vector<Batch> batches;
        std::vector<std::pair<std::uint32_t, Rect>> cleared;   // view and rectangle in it
    };
    void gather(const LightViews& views, const CasterGeometry& casters);
    void add_object(Batch& batch, const CasterGeometry& casters, scene::ObjectId object);
    Batch begin_batch(std::uint32_t view, const Rect& scissor, bool ties) const;
    void end_batch(Phase& phase, Batch batch);
    void clear_all(vk::Commands& commands);
    void copy(vk::Commands& commands, const char* name, const Layers& from, const Layers& to,
              const std::vector<VkImageCopy>& regions) const;
    void draw(vk::Commands& commands, const char* name, const Phase& phase, const LightViews& views,
              const CasterGeometry& casters) const;
    const vk::Pipeline& pipeline(bool perspective, bool masked) const
    {
        return pipelines_[perspective ? 0 : 1][masked ? 1 : 0];
    }

    std::shared_ptr<vk::Device> device_;
    int pages_ = 0;
    Layers rendering_, statics_;
    vk::Owned<VkSampler> sampler_;
    vk::Pipeline pipelines_[2][2];   // perspective or not, opaque or alpha-tested
    bool cleared_ = false;
    // Of this frame:
    std::vector<VkDrawIndexedIndirectCommand> commands_;
    std::vector<MaskedDraw> masked_;
    Phase rebuild_, settle_, dynamics_;
    std::vector<VkImageCopy> erase_, keep_rebuilt_, keep_settled_;
    vk::Buffer indirect_;
};

}   // namespace gnomon::light_views
