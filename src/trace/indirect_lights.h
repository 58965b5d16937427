// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light in the traced frame: from the irradiance cache, and from light maps without visibility.

#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "trace/indirect_light.h"

namespace gnomon::trace {

struct CachedIndirectOptions {
    // The spacing of cache points seen in mirrors and behind glass is multiplied by this, as long as it is no more than
    // `mirrored_reach` times the last ray's length. It is divided by the square root of the path's throughput.
    float mirrored_spacing = 4, mirrored_reach = 0.5f;
    // That limit multiplies it by no less than this: of cache points seen in mirrors and behind glass, and of those
    // met by rays of lobes, whose cones are wide. It bounds how many points a small image of much detail has.
    float mirrored_least = 1, lobe_least = 1.0f / 32;
    int bounces = 1;   // of the cache
};

/// Bounces with visibility.
class CachedIndirect final : public IndirectLight {
 public:
    using Options = CachedIndirectOptions;
    explicit CachedIndirect(irradiance_cache::IrradianceCache& cache, const Options& options = {})
        : cache_(cache), options_(options)
    {
    }
    void begin_frame(const FrameContext& frame) override { cache_.update(frame.state, frame.rays, frame.tasks); }
    bool has_further_bounces() const override { return options_.bounces > 1; }
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Indirect end_frame(std::span<const std::unique_ptr<Worker>> workers) override;

 private:
    class Work;
    irradiance_cache::IrradianceCache& cache_;
    Options options_;
};

/// One bounce by the light quad-tree or by reflective shadow maps.
class MapIndirect final : public IndirectLight {
 public:
    explicit MapIndirect(light_quadtree::MapLight& light) : light_(light) {}
    /// Also gathers light at the image's sparse receivers, where the method has them.
    void begin_frame(const FrameContext& frame) override;
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Indirect end_frame(std::span<const std::unique_ptr<Worker>> workers) override;

 private:
    class Work;
    light_quadtree::MapLight& light_;
};

}   // namespace gnomon::trace
