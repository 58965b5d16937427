// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the image takes from shadow textures: how much of each light each of its pixels sees.
//
// Cost: pixels times lights times the filter's texels. The records of views are sent when a light moved.

#include "shadow_textures/vulkan/lookup_records.h"

namespace gnomon::shadow_textures {

/// The image's points, as many pixels each.
struct ImageInputs {
    const vk::Image* positions = nullptr;   // world space, float
    const vk::Image* normals = nullptr;     // geometric, unit, on the viewer's side
    const vk::Image* objects = nullptr;     // unsigned: object + 1, 0 where nothing is
};

class GpuVisibility {
 public:
    GpuVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// @param textures  the receivers' own textures are looked up; nullptr: the items instead
    /// @param out       R8_UNORM, storage, an array with a layer a light: 255 lit, 0 in shadow or facing away
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const GpuTextures* textures, const ImageInputs& inputs, const vk::Image& out,
                const LookupOptions& options);
    /// The same for lights first ... first + count - 1, in layers 0 ... count - 1.
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const GpuTextures* textures, const ImageInputs& inputs, const vk::Image& out,
                const LookupOptions& options, std::uint32_t first, std::uint32_t count);

 private:
    vk::Pipeline pipeline_;
    LookupRecords records_;
};

}   // namespace gnomon::shadow_textures
