// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shadow tests of the traced frame: every ray traced, certified shadow culling, and the culling of [Nah 2009].

#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "trace/shadow_tester.h"
#include "trace/trace_log.h"

namespace gnomon::trace {

/// One light's shadow rays, as a test that remembers nothing casts them: one from each point that faces the light and
/// that the light's range and cone contain.
struct ShadowRays {
    ray::RayQueue rays;
    std::vector<std::uint32_t> point;   // by ray: of the batch

    void queue(const scene::SceneState& state, const PointBatch& batch, scene::LightId light);
};

/// Traces every shadow ray.
class EveryShadowRay final : public ShadowTester {
 public:
    /// @param log  optional, then for one thread: takes the rays
    explicit EveryShadowRay(TraceLog* log = nullptr) : log_(log) {}
    void begin_frame(const FrameContext& frame) override { state_ = &frame.state, rays_ = &frame.rays; }
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    TraceLog* log_;
    const scene::SceneState* state_ = nullptr;
    const ray::RayScene* rays_ = nullptr;
};

/// Skips the rays whose result is proven; the image is the same to the bit.
class CertifiedShadows final : public ShadowTester {
 public:
    /// @param defer_certificates  end_frame() makes no certificates: the caller calls CertifiedCulling::judge()
    explicit CertifiedShadows(shadow_culling::CertifiedCulling& culling, bool defer_certificates = false)
        : culling_(culling), defer_certificates_(defer_certificates)
    {
    }
    void begin_frame(const FrameContext& frame) override;
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    shadow_culling::CertifiedCulling& culling_;
    const scene::SceneState* state_ = nullptr;
    bool defer_certificates_;
};

/// Skips rays by the published heuristic; the image can be wrong. With PaperOptions::writes_at_once, the frame must be
/// traced by one thread, in tiles of one pixel.
class NahShadows final : public ShadowTester {
 public:
    explicit NahShadows(shadow_culling::PaperCulling& culling) : culling_(culling) {}
    void begin_frame(const FrameContext& frame) override;
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    void see_pixel(std::size_t pixel);

    shadow_culling::PaperCulling& culling_;
    const scene::SceneState* state_ = nullptr;
    const ray::RayScene* rays_ = nullptr;
    int image_width_ = 0;
    std::vector<shadow_culling::PrimaryHit> primary_hits_;   // by pixel of the image, for the occlusion test
};

}   // namespace gnomon::trace
