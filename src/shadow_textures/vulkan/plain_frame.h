// SPDX-License-Identifier: Apache-2.0
#pragma once
// A minimal frame with shadow textures, as measured in their paper [Oh and Shin 2004, 4]: every object is drawn once
// from the camera and its texture is sampled for shading. There are no materials, no culling and no alpha tests, so the
// rest of the frame costs as little as possible beside the shadows.
//
// Cost: every caster's triangles once, and a look-up per light and fragment.

#include "shadow_textures/vulkan/lookup_records.h"
#include "shadow_textures/vulkan/plain_shared.h"

namespace gnomon::shadow_textures {

class PlainFrame {
 public:
    PlainFrame(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views, std::uint32_t width,
               std::uint32_t height);

    /// @param clip_from_world  of the camera; reversed depth, y down
    /// @param textures         use the receivers' own textures; nullptr: use the items
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const GpuTextures* textures, const light_views::CasterGeometry& casters, const scene::SceneState& state,
                const glm::mat4& clip_from_world, const glm::vec3& eye, const LookupOptions& options = {});

    const vk::Image& color() const { return color_; }   // RGBA, 8 bits

 private:
    vk::Pipeline pipeline_;
    LookupRecords records_;
    vk::Image color_, depth_;
    vk::Buffer draws_;
    std::vector<VkDrawIndexedIndirectCommand> sent_draws_;
};

}   // namespace gnomon::shadow_textures
