// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadows of surfaces that thin light (scene::thins_light()), on top of other shadows: the part of light that they let
// through multiplies the visibility.
//
// The surfaces of the image are read back, one ray is traced from each of them to each light that it sees, and the
// product is sent to the device. The rays are those of the traced frame, so that both frames agree; light is not
// tinted, because visibility has one channel. Only scenes with such surfaces use it. Cost: a read-back for each layer
// and batch of lights, and a ray per lit pixel and light.

#include <memory>

#include "base/tasks.h"
#include "raster/gbuffer.h"
#include "ray/ray_scene.h"

namespace gnomon::raster {

class ThinnedShadows final : public LightVisibility {
 public:
    /// @param rays  follows the state of update(); with thinning surfaces
    ThinnedShadows(const std::shared_ptr<vk::Device>& device, const ray::RayScene& rays, Tasks& tasks,
                   std::unique_ptr<LightVisibility> others)
        : device_(device), rays_(rays), tasks_(tasks), others_(std::move(others))
    {
    }

    void update(vk::Commands& commands, const scene::SceneState& state, std::span<const glm::vec4, 6> planes) override;
    void fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
              const vk::Image& visibility) override;
    void end_frame(vk::Commands& commands) override { others_->end_frame(commands); }
    void count(FrameCounters& counters) const override { others_->count(counters); }

 private:
    std::shared_ptr<vk::Device> device_;
    const ray::RayScene& rays_;
    Tasks& tasks_;
    std::unique_ptr<LightVisibility> others_;
    const scene::SceneState* state_ = nullptr;
    vk::Buffer sent_;
};

}   // namespace gnomon::raster
