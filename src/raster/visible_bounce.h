// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounced light with shadows in the rasterised frame: the surfaces are the device's, the light is that of the traced
// frame's remembered points (irradiance_cache/irradiance_cache.h). The processor finds which points speak for a pixel;
// cuts and sums of points are its own or the device's.
//
// Each layer's surfaces are read back, lit, and what arrives is sent to the device: a wait for the device a layer, 72
// bytes a pixel down and 16 up. A pixel's light is that of the traced frame wherever both see the same surface.

#include "base/tasks.h"
#include "irradiance_cache/irradiance_cache.h"
#include "raster/gbuffer.h"

namespace gnomon::irradiance_cache {
class GpuPoints;
}

namespace gnomon::raster {

class VisibleBounce final : public BouncedLight {
 public:
    /// @param rays       follows the state before every frame; like `tasks`, must outlive this
    /// @param on_device  cuts and sums are the device's (irradiance_cache/vulkan/gpu_points.h); so are rays of points,
    /// if it traces rays (device_rays.h), from the first update() on
    /// @throws MissingError  too little device memory
    VisibleBounce(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state, const ray::RayScene& rays,
                  const irradiance_cache::CacheOptions& options, bool on_device, Tasks& tasks);

    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
              const vk::Image& irradiance) override;
    FrameCounters::Indirect end_frame() override;

    const irradiance_cache::IrradianceCache& light() const { return light_; }

 private:
    struct Scratch {
        std::vector<irradiance_cache::IndirectPoint> points;
        std::vector<std::uint32_t> pixels;
        std::vector<glm::vec3> light;
    };
    std::shared_ptr<vk::Device> device_;
    const ray::RayScene& rays_;
    Tasks& tasks_;
    irradiance_cache::IrradianceCache light_;
    irradiance_cache::GpuPoints* on_device_ = nullptr;   // its engine, if cuts and sums are the device's
    std::vector<std::unique_ptr<irradiance_cache::IrradianceCache::Batch>> batches_;   // by thread
    std::vector<Scratch> scratch_;
    std::vector<glm::vec4> arrives_;   // by pixel
    vk::Buffer sent_;
};

}   // namespace gnomon::raster
