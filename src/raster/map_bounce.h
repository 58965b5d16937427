// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light from light maps in the rasterised frame, computed on the device (light_quadtree/vulkan). While neither
// scene nor view change, the light map and the light of sparse receivers are kept; the sum at every pixel, or its
// interpolation, is repeated, as in the paper.

#include "light_quadtree/vulkan/gpu_map_light.h"
#include "raster/gbuffer.h"

namespace gnomon::raster {

class MapBounce final : public BouncedLight {
 public:
    /// @throws MissingError  too little device memory
    MapBounce(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
              const light_quadtree::MapLightOptions& options)
        : light_(device, state, options)
    {
    }

    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state) override
    {
        const std::uint32_t before = light_.map().version();
        light_.map().record(commands, scene, state);
        kept_map_ = before != 0 && light_.map().version() == before;
        count_ = light_.read_count(commands);
    }
    void fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
              const vk::Image& irradiance) override
    {
        const light_quadtree::MapSurfaces seen{&surfaces.position, &surfaces.normal,  view.size,    view.eye,
                                               view.pixel_width,   view.pixel_spread, surfaces.kept};
        light_.record_grid(commands, seen);
        light_.record_light(commands, seen, irradiance);
    }
    /// Computes map and receivers anew in the next frame.
    void forget() { light_.forget(); }
    FrameCounters::Indirect end_frame() override
    {
        return {.clusters = light_.lights(count_), .kept_map = kept_map_, .kept_receivers = light_.kept_grid()};
    }

 private:
    light_quadtree::GpuMapLight light_;
    vk::Buffer count_;   // number of this frame's clusters
    bool kept_map_ = false;
};

}   // namespace gnomon::raster
