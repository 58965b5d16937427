// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shadow pass of one frame with the published shadow culling, for bench culling: hits of any kind and depth, and
// the image of the primary ones for the occlusion test.

#include <span>
#include <vector>

#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_tracer.h"

namespace gnomon::bench {

class PaperBench {
 public:
    PaperBench(const scene::SceneState& state, const ray::RayScene& rays, int threads,
               const shadow_culling::PaperOptions& options);

    /// Before a frame's primary hits: empties the image.
    void clear_image(Size size);
    /// One pixel's primary hit; from any thread.
    void set_pixel(int x, int y, scene::ObjectId object, std::uint32_t triangle, const glm::vec3& origin,
                   const glm::vec3& direction)
    {
        image_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] = {
            culling_.primitive(object, triangle), origin, direction};
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays);
    /// All lights for a batch of points; from worker `worker`.
    /// @param occluded  [light][point]: 1 where something that blocks light lies between; left alone where the light is
    ///                 behind the surface
    /// @param rays     optional, [light][point]: 1 where a ray was traced against everything, 2 against dynamic objects
    /// alone
    void shadow(int worker, std::span<const shadow_culling::ShadowPoint> points, std::uint8_t* occluded,
                std::uint8_t* rays = nullptr);
    void end_frame();

    const shadow_culling::PaperCulling& culling() const { return culling_; }
    double extra_tests_per_pixel() const
    {
        return static_cast<double>(culling_.counters().extra_tests) / static_cast<double>(image_.size());
    }

 private:
    struct Worker {
        shadow_culling::PaperTracer tracer;
        ray::RayQueue asked;
        std::vector<std::uint32_t> point;   // by ray of `asked`
        std::vector<shadow_culling::PrimitiveId> origins;
        std::vector<std::uint8_t> hit, traced;
    };

    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    shadow_culling::PaperCulling culling_;
    int width_ = 0;
    std::vector<shadow_culling::PrimaryHit> image_;
    std::vector<Worker> workers_;
};

}   // namespace gnomon::bench
