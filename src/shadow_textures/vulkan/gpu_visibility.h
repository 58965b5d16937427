// SPDX-License-Identifier: Apache-2.0
#pragma once
// Computes the visibility of each light at each pixel from shadow textures.
//
// Cost: pixels times lights times the filter's texels. The records of views are uploaded when a light moved.

#include "shadow_textures/vulkan/lookup_records.h"

namespace gnomon::shadow_textures {

/// The surfaces of an image, one per pixel.
struct ImageInputs {
    const vk::Image* positions = nullptr;   // world space, float
    const vk::Image* normals = nullptr;     // geometric, unit, on the viewer's side
    const vk::Image* objects = nullptr;     // unsigned: object + 1, 0 where there is none
    const vk::Image* smooth = nullptr;      // of the smooth horizon, likewise; w: height. Null: the geometric ones
};

class GpuVisibility {
 public:
    GpuVisibility(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views);

    /// @param textures  use the receivers' own textures; nullptr: use the items
    /// @param out       R8_UNORM, storage, an array with one layer per light: 255 lit, 0 in shadow or facing away
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const GpuTextures* textures, const ImageInputs& inputs, const vk::Image& out,
                const LookupOptions& options);
    /// The same for lights first ... first + count - 1, in layers 0 ... count - 1.
    void record(vk::Commands& commands, const light_views::LightViews& views, const light_views::GpuLightViews& buffers,
                const GpuTextures* textures, const ImageInputs& inputs, const vk::Image& out,
                const LookupOptions& options, std::uint32_t first, std::uint32_t count);

    /// Starts to count results as printed; call before the first record() of a frame.
    void begin_counts(vk::Commands& commands) const;
    /// shared::LookupCounts of the records since begin_counts(); readable after the next submit.
    vk::Buffer read_counts(vk::Commands& commands) const { return commands.read_back(counts_); }

 private:
    vk::Pipeline pipeline_;
    LookupRecords records_;
    vk::Buffer counts_;
};

}   // namespace gnomon::shadow_textures
