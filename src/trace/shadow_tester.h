// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interface of the techniques that find which lights reach which points of the traced frame (shadow_testers.h).

#include <memory>
#include <vector>

#include "trace/point_batch.h"
#include "trace/state_map.h"

namespace gnomon::trace {

/// The remembered shadow of a point, for the overlay of shadow states.
struct PointState {
    StateMark mark = StateMark::unknown;
    bool untrusted = false;   // see StateCell
};

class ShadowTester {
 public:
    virtual ~ShadowTester() = default;

    /// After the state advanced and the ray scene followed. Outside the frame's parallel part, as end_frame().
    virtual void begin_frame(const FrameContext& frame) = 0;

    /// The scratch memory of one thread, for one frame.
    class Worker {
     public:
        virtual ~Worker() = default;
        /// Takes a tile's first hits, of the first sample alone.
        virtual void note_primary_hits(const PrimaryRays&) {}
        /// Prepares for all lights of a batch; called once, before its find_lit().
        virtual void prepare(const PointBatch&) {}
        /// Appends the points of the prepared batch that a light reaches, in order.
        virtual void find_lit(const PointBatch& batch, scene::LightId light, std::vector<std::uint32_t>& lit) = 0;
        /// What is remembered of a point of the prepared batch and a light; StateMark::moving where the point's object
        /// is dynamic to this technique.
        virtual PointState state_of(const PointBatch&, std::uint32_t, scene::LightId) const { return {}; }
    };
    virtual std::unique_ptr<Worker> make_worker() = 0;

    /// @param workers  those that took part
    virtual FrameCounters::Shadow end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks) = 0;
};

}   // namespace gnomon::trace
