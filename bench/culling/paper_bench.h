// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the shadow pass of one frame with the published shadow culling, for bench culling: on hits of any depth, with
// the image of the primary hits for the occlusion test.
//
// Modes that are written at once (PaperOptions::writes_at_once) are read and written pixel by pixel, in scanline order.
// What a ray finds does not depend on modes, so all rays are traced in packets before, and the pass over the pixels
// decides which of them were needed. The counts are those of a tracer that traces these alone; the times are not.

#include <span>
#include <vector>

#include "base/tasks.h"
#include "bench/core/bench_points.h"
#include "shadow_culling/nah2009/paper_tracer.h"

namespace gnomon::bench {

class PaperBench {
 public:
    PaperBench(const scene::SceneState& state, const ray::RayScene& rays, int threads,
               const shadow_culling::PaperOptions& options);

    /// Empties the image. Call it before set_pixel() in every frame.
    void clear_image(Size size);
    /// Stores the primary hit of a pixel; from any thread.
    void set_pixel(const SeenPixel& p)
    {
        image_[static_cast<std::size_t>(p.y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(p.x)] = {
            culling_.primitive(p.object, p.triangle, p.u, p.v), p.origin, p.direction};
    }

    /// The shading points of a tile, and where its results go.
    struct Batch {
        const BenchPoints* points = nullptr;
        std::uint8_t* occluded =
            nullptr;   // [light][point]: 1 where an opaque object lies between; unchanged where the surface faces away
        std::uint8_t* rays = nullptr;   // optional, [light][point]: 1 where a ray was traced against everything, 2
                                        // where one was traced against dynamic objects only
    };
    /// Computes the shadows of all lights, from begin_frame to end_frame.
    void run(const scene::SceneState& state, const ray::RayScene& rays, std::span<const Batch> batches, Tasks& tasks);

    const shadow_culling::PaperCulling& culling() const { return culling_; }
    double extra_tests_per_pixel() const
    {
        return static_cast<double>(culling_.counters().extra_tests) / static_cast<double>(image_.size());
    }

 private:
    struct Found;
    void shadow(int worker, const Batch& batch);
    void run_in_scanline_order(std::span<const Batch> batches, Tasks& tasks);
    template <class Take>
    void queue_facing(std::span<const shadow_culling::ShadowPoint> points, scene::LightId light, Take&& take) const;

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
