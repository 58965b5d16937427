// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounced light from a light map, without occlusion, on the device: the published light quad-tree [Ki and Oh 2007], and
// the sampling to which it is compared [Dachsbacher and Stamminger 2005]. The device version of MapLight, with the same
// kernel.
//
// With MapLightOptions::as_printed, every receiver goes through the tree by itself, one pass a level: the same sums, to
// the bit. Kept buffers: while neither the map nor the surfaces change, the light of the grid is used again.
//
// Surfaces and results are images. Sparse receivers lie at pixels of the image. Cost: the map's (gpu_light_map.h);
// lights times receivers. Memory: 48 bytes per receiver of the grid.

#include "light_quadtree/map_light.h"
#include "light_quadtree/vulkan/gpu_light_map.h"

namespace gnomon::light_quadtree {

/// An image's surfaces: four 32-bit floats per pixel.
struct MapSurfaces {
    const vk::Image* position;   // w: 0 where no light is computed
    const vk::Image* normal;     // unit, shading
    Size size;                   // of the image
    glm::vec3 eye{0};
    float pixel_width = 0, pixel_spread = 0;   // of the view, as in scene::View
    bool kept = false;                         // the surfaces are those of the last record_grid()
};

class GpuMapLight {
 public:
    /// @param options  with method quadtree or rsm
    /// @throws MissingError  too little device memory
    GpuMapLight(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                const MapLightOptions& options);

    GpuLightMap& map() { return map_; }
    const GpuLightMap& map() const { return map_; }

    /// Records the light at the grid's receivers, unless it is kept; call before record_light() if there is a grid.
    void record_grid(vk::Commands& commands, const MapSurfaces& surfaces);
    /// Whether the last record_grid() used the light of the one before.
    bool kept_grid() const { return kept_grid_; }
    /// Forgets map and grid, so that everything is computed anew.
    void forget();
    /// Records the light at every pixel, into an image of the same size (four 32-bit floats, a storage image).
    void record_light(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance);
    /// The same for a list of points in any image layout; position.w is a point's pixel in the image, counted from 1.
    void record_listed(vk::Commands& commands, const MapSurfaces& points, const vk::Image& irradiance);

    /// Number of lights: samples, or clusters as counted by the device, which read_count() returns.
    vk::Buffer read_count(vk::Commands& commands) const { return commands.read_back(map_.counts()); }
    std::uint64_t lights(const vk::Buffer& count) const;
    int grid_step(Size size) const;
    std::size_t bytes() const;

 private:
    void record(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance, bool grid,
                bool listed);
    void record_pass(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance,
                     const shared::GatherPush& push, const glm::uvec2& points);
    void fit_texels();
    void send_pattern(vk::Commands& commands, std::uint32_t samples);
    void copy_texels(vk::Commands& commands);

    std::shared_ptr<vk::Device> device_;
    MapLightOptions options_;
    GpuLightMap map_;
    vk::Pipeline pipeline_;
    // For sampling: the pattern, and the map's texels.
    vk::Pipeline copy_pipeline_;
    vk::Buffer pattern_;
    vk::Image pattern_image_, texels_;
    std::uint32_t pattern_samples_ = 0;   // in it
    std::uint32_t copied_ = 0;            // version of the map at the last copy
    vk::Image grid_position_, grid_normal_, grid_light_, none_;
    std::uint32_t grid_version_ = 0;   // of the map at the last record of the grid; 0: none
    bool kept_grid_ = false;
};

}   // namespace gnomon::light_quadtree
