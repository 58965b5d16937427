// SPDX-License-Identifier: Apache-2.0
#pragma once
// Visibility of lights with size by remembered, proven shadows (area_light/area_visibility.h).
//
// Flat lights, of one polygon or several, are answered by it. Clusters that rest are, where they are proven lit or dark
// (area_light/cluster_visibility.h); other clusters, and what the technique cannot decide, by rays.
// It outlives frames: make one for a scene state, and let it follow.

#include "area_light/cell_places.h"
#include "area_light/cluster_visibility.h"
#include "trace/sized_visibility.h"

namespace gnomon::trace {

class ProvenVisibility final : public SizedVisibility {
 public:
    explicit ProvenVisibility(const area_light::AreaOptions& options = {}) : options_(options), clusters_(options) {}

    /// The state must be the one of the call before, or one that continues it.
    void begin_frame(const FrameContext& frame, const scene::SizedLights& lights) override;
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

    /// Of the last frame; all zero before the first.
    const area_light::VisibilityCounters& counters() const { return counters_; }
    area_light::AreaCounters parts() const;
    std::size_t bytes() const;

 private:
    class Work;
    void sort_lights(const scene::SizedLights& lights);
    static constexpr std::uint32_t k_none = 0xffffffffu;
    area_light::AreaOptions options_;
    std::unique_ptr<area_light::AreaVisibility> visibility_;
    area_light::ClusterVisibility clusters_;
    const scene::SizedLights* lights_ = nullptr;
    const scene::SceneState* state_ = nullptr;   // of the frame
    const ray::RayScene* rays_ = nullptr;
    std::uint32_t version_ = 0;            // of the lights
    std::vector<std::uint32_t> planar_;    // by light: index among the planar ones; k_none: a cluster
    std::vector<std::uint32_t> cluster_;   // by light: index among the clusters that rest; k_none: another
    std::vector<area_light::AreaLight> planar_lights_;
    std::vector<area_light::CellPlaces> places_;   // by planar light
    area_light::VisibilityCounters counters_;
};

}   // namespace gnomon::trace
