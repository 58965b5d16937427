// SPDX-License-Identifier: Apache-2.0
#pragma once
// The resources of shadow look-ups on the device: light views, their records, and the receivers' textures or the items.
//
// Cost per frame: a comparison per view; records are uploaded when a light moved or was switched on or off.

#include "light_views/vulkan/gpu_light_views.h"
#include "shadow_textures/lookup.h"
#include "shadow_textures/vulkan/gpu_textures.h"
#include "shadow_textures/vulkan/lookup_shared.h"

namespace gnomon::shadow_textures {

/// Of shaders that include lookup.glsl or hard_edges.glsl: the records of views and lights.
inline std::vector<vk::BlockExpectation> look_up_blocks()
{
    return {vk::shared_block<shared::ViewRecord>("ViewRecords"), vk::shared_block<shared::LightRecord>("LightRecords")};
}

class LookupRecords {
 public:
    LookupRecords(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// Records the upload of records that changed.
    void update(vk::Commands& commands, const light_views::LightViews& views);

    /// Declares everything that lookup.glsl reads.
    /// @param textures  use the receivers' own textures; nullptr: use the items
    vk::Pass& declare(vk::Pass& pass, const light_views::GpuLightViews& buffers, const GpuTextures* textures) const;
    void bind(vk::Recorder& recorder, const light_views::GpuLightViews& buffers, const GpuTextures* textures) const;

    /// Declares only the records: ViewRecords, LightRecords.
    vk::Pass& declare_views(vk::Pass& pass) const;
    void bind_views(vk::Recorder& recorder) const;

    /// @param size  of the image
    static shared::LookupConstants constants(glm::uvec2 size, const light_views::LightViews& views,
                                             const GpuTextures* textures, const LookupOptions& options);

 private:
    const vk::Buffer& places(const GpuTextures* textures) const { return textures ? textures->places() : nothing_; }
    const vk::Buffer& words(const GpuTextures* textures) const { return textures ? textures->textures() : nothing_; }

    vk::Buffer view_records_, light_records_, casts_, nothing_;
    bool sent_casts_ = false;
    std::vector<shared::ViewRecord> sent_views_;
    std::vector<shared::LightRecord> sent_lights_;
};

}   // namespace gnomon::shadow_textures
