// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the shadow pass of one frame with the published shadow culling, for bench culling: on hits of any depth, with
// the image of the primary hits for the occlusion test.

#include <span>
#include <vector>

#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_tracer.h"

namespace gnomon::bench {

class PaperBench {
 public:
    PaperBench(const scene::SceneState& state, const ray::RayScene& rays, int threads,
               const shadow_culling::PaperOptions& options);

    /// Empties the image. Call it before set_pixel() in every frame.
    void clear_image(Size size);
    /// Stores the primary hit of a pixel; from any thread.
    void set_pixel(int x, int y, scene::ObjectId object, std::uint32_t triangle, const glm::vec3& origin,
                   const glm::vec3& direction)
    {
        image_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] = {
            culling_.primitive(object, triangle), origin, direction};
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays);
    /// Computes the shadows of all lights for a batch of points; from worker `worker`.
    /// @param occluded  [light][point]: 1 where an opaque object lies between; unchanged where the surface faces away
    /// @param rays      optional, [light][point]: 1 where a ray was traced against everything, 2 where one was traced
    ///                  against dynamic objects only
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
        ray::RayQueue queue;
        std::vector<std::uint32_t> point;   // by ray of `queue`
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
