// SPDX-License-Identifier: Apache-2.0
#pragma once
// The environment technique of traced frames (trace/environment_lighting.h) in the rasterised frame: surfaces that the
// device drew are read back and lit by cells of directions and by discs of suns, and their light is sent to the device.
//
// A pixel's light equals that of the traced frame without reflected rays, except for glossy surfaces that are smoother
// than k_least_roughness: those show the image as one of that roughness does, because no ray shows it.
//
// Cost: a wait for the device per layer of surfaces, 104 bytes per pixel down and 16 up, and what the technique costs.
// Nothing while surfaces, lights and objects stay the same.

#ifdef GNOMON_VULKAN

#include <memory>
#include <vector>

#include "raster/gbuffer.h"
#include "raster/sent_image.h"
#include "trace/environment_lighting.h"

namespace gnomon::frame {

class RasterEnvironment final : public raster::SurroundingLight {
 public:
    /// From here on, glossy surfaces see an image as in traced frames.
    static constexpr float k_least_roughness = 0.15f;

    /// @param rays  follows the state before every frame; like `tasks`, must outlive this
    RasterEnvironment(const ray::RayScene& rays, Tasks& tasks) : rays_(rays), tasks_(tasks) {}

    /// Must be called before every frame. @param technique  must outlive the frame
    void use(trace::EnvironmentTechnique& technique) { technique_ = &technique; }

    void begin_frame(const scene::SceneState& state, const scene::View& view) override;
    bool brings(scene::LightId light) const override;
    bool has_image() const override { return !technique_->empty(); }
    glm::vec3 open_irradiance(const glm::vec3& normal) const override
    {
        return technique_->light().light().irradiance(normal);
    }
    void fill(vk::Commands& commands, const raster::GBuffer& surfaces, const scene::View& view,
              const vk::Image& radiance) override;
    std::span<const float> visible(scene::LightId light) const override;
    void end_frame(FrameCounters& counters) override;

 private:
    // The surfaces of a layer, on the host.
    struct Surfaces {
        vk::Buffer positions, normals, geometric, smooth, diffuse, specular, ids;
    };
    // Of one thread.
    struct Worker {
        trace::EnvironmentLighting lighting;
        std::vector<trace::TilePoint> points;
        std::vector<shadow_culling::ShadowPoint> shadow_points;
        std::vector<glm::vec3> normals;
    };
    void add_point(const Surfaces& read, std::size_t pixel, const scene::View& view, Worker& own) const;
    void light_tile(const Surfaces& read, std::size_t number, const scene::View& view, Worker& own);

    const ray::RayScene& rays_;
    Tasks& tasks_;
    trace::EnvironmentTechnique* technique_ = nullptr;
    const scene::SceneState* state_ = nullptr;
    std::vector<std::unique_ptr<Worker>> workers_;   // of a frame, by thread
    std::vector<glm::vec4> radiance_;                // by pixel
    std::vector<std::vector<float>> visible_;        // by light, by pixel; empty: no sun
    raster::SentImage sent_;
};

}   // namespace gnomon::frame

#endif
