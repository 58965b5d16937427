// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light with visibility in the rasterised frame: the surfaces that the device drew are lit from the irradiance
// cache of the traced frame (irradiance_cache/irradiance_cache.h). The CPU finds the cache points of each pixel; cuts
// and sums of points are computed by the CPU or the device.
//
// Each layer's surfaces are read back and lit, and the irradiance is sent to the device. This costs one wait for the
// device per layer, and per pixel 72 bytes down and 16 bytes up. A pixel's light equals that of the traced frame
// wherever both see the same surface.

#include "base/tasks.h"
#include "irradiance_cache/irradiance_cache.h"
#include "raster/gbuffer.h"
#include "raster/sent_image.h"

namespace gnomon::irradiance_cache {
class GpuPoints;
}

namespace gnomon::raster {

class VisibleBounce final : public BouncedLight {
 public:
    /// @param rays       follows the state before every frame; like `tasks`, must outlive this
    /// @param on_device  the device computes cuts and sums (irradiance_cache/vulkan/gpu_points.h) and, if it traces
    /// rays (device_rays.h), from the first update() on also casts the rays of points
    /// @throws MissingError  too little device memory
    VisibleBounce(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state, const ray::RayScene& rays,
                  const irradiance_cache::CacheOptions& options, bool on_device, Tasks& tasks);

    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
              const vk::Image& irradiance) override;
    bool has_further_bounces() const override { return further_bounces_; }
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
    bool further_bounces_;
    irradiance_cache::IrradianceCache light_;
    irradiance_cache::GpuPoints* on_device_ = nullptr;   // the cache's engine; null: the CPU computes cuts and sums
    std::vector<std::unique_ptr<irradiance_cache::IrradianceCache::Batch>> batches_;   // by thread
    std::vector<Scratch> scratch_;
    std::vector<glm::vec4> arrives_;   // by pixel
    SentImage sent_;
};

}   // namespace gnomon::raster
