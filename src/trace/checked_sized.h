// SPDX-License-Identifier: Apache-2.0
#pragma once
// Visibility of lights with size that records what another technique remembers, and checks each of its proven answers
// with rays: the data of --overlay shadow-states, beside CheckedShadows. The image is that of the other technique.

#include "trace/sized_visibility.h"
#include "trace/state_map.h"

namespace gnomon::trace {

/// The mark of a pixel for several lights together: one that all have, else penumbra, unless some were traced.
StateMark joined(StateMark a, StateMark b);

class CheckedSized final : public SizedVisibility {
 public:
    /// @param map       CheckedShadows starts it for each frame
    /// @param panel_of  by light: its panel in the map; -1: none
    CheckedSized(SizedVisibility& tested, StateMap& map, std::vector<int> panel_of)
        : tested_(tested), map_(map), panel_of_(std::move(panel_of))
    {
    }
    void begin_frame(const FrameContext& frame, const scene::SizedLights& lights) override;
    std::unique_ptr<Worker> make_worker() override;
    /// @return the counters of the other technique, with rays_wrong
    FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) override;

 private:
    class Work;
    SizedVisibility& tested_;
    StateMap& map_;
    std::vector<int> panel_of_;
    SampledVisibility rays_;
    const scene::SizedLights* lights_ = nullptr;
};

}   // namespace gnomon::trace
