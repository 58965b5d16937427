// SPDX-License-Identifier: Apache-2.0
#pragma once
// A shadow test that records what another one remembers, and checks each of its answers by tracing every ray: the data
// of --overlay shadow-states. The image is that of the other test.

#include "trace/shadow_testers.h"
#include "trace/state_map.h"

namespace gnomon::trace {

class CheckedShadows final : public ShadowTester {
 public:
    /// @param map  its lights are set; the rest is overwritten by each frame. Both outlive this.
    CheckedShadows(ShadowTester& tested, StateMap& map) : tested_(tested), map_(map) {}
    void begin_frame(const FrameContext& frame) override;
    std::unique_ptr<Worker> make_worker() override;
    /// @return the counters of the other test, with rays_wrong
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    ShadowTester& tested_;
    StateMap& map_;
    const scene::SceneState* state_ = nullptr;
    const ray::RayScene* rays_ = nullptr;
};

}   // namespace gnomon::trace
