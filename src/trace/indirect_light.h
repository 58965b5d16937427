// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interface of the techniques that find the light that arrives by bounces at points of the traced frame
// (indirect_lights.h, frame/reference_indirect.h).

#include <memory>
#include <vector>

#include "trace/point_batch.h"

namespace gnomon::trace {

/// Irradiance at the points of a batch that receive indirect light. The last three lists belong to random estimates.
struct IndirectResult {
    std::vector<std::uint32_t> point;          // of the batch, ascending
    std::vector<glm::vec3> irradiance;         // after one bounce or more
    std::vector<glm::vec3> surroundings;       // unbounced, from the sky, an environment image or emissive surfaces
    std::vector<glm::vec3> irradiance_error;   // standard error of `irradiance`
    std::vector<glm::vec3> error;              // of the sum of both
    // What the lobes of glossy points reflect to the viewer of emissive surfaces and of the background.
    std::vector<std::uint32_t> lobe_point;   // of the batch, ascending; twice for a coated one
    std::vector<glm::vec3> lobe_radiance;
    std::vector<glm::vec3> lobe_error;   // standard error
};

class IndirectLight {
 public:
    virtual ~IndirectLight() = default;

    /// After the state advanced and the ray scene followed. Outside the frame's parallel part, as end_frame().
    virtual void begin_frame(const FrameContext& frame) = 0;
    /// Results are random estimates, with surroundings and errors.
    virtual bool is_estimate() const { return false; }
    /// Results have what the lobes of glossy points reflect of emissive surfaces and of the background: rays reflected
    /// there show the other light alone.
    virtual bool reflects_lobes() const { return false; }
    /// Results have light of more than one bounce, so that nothing must stand in for it.
    virtual bool has_further_bounces() const { return false; }
    /// The surroundings in the results replace this light: its direct light must not be added.
    virtual bool replaces(const scene::Light&) const { return false; }

    /// What the first hits of a tile found, which are the same in the next frame.
    class Remembered {
     public:
        virtual ~Remembered() = default;
        virtual std::size_t bytes() const = 0;
    };

    /// The scratch memory of one thread, for one frame.
    class Worker {
     public:
        virtual ~Worker() = default;
        /// Called before a tile's first batch.
        virtual void begin_tile(const Tile&) {}
        /// Overwrites `result`.
        virtual void gather(const PointBatch& batch, IndirectResult& result) = 0;
        /// The same for first hits that will be gathered again in the next frame.
        /// @return  null if nothing is remembered of them
        virtual std::unique_ptr<Remembered> gather_and_remember(const PointBatch& batch, IndirectResult& result)
        {
            gather(batch, result);
            return nullptr;
        }
        /// Overwrites `result` with that of gather() for the batch that is remembered.
        /// @return  false if what is remembered does not hold any more
        virtual bool gather_again(Remembered&, IndirectResult&) { return false; }
    };
    virtual std::unique_ptr<Worker> make_worker() = 0;

    /// @param workers  those that took part
    virtual FrameCounters::Indirect end_frame(std::span<const std::unique_ptr<Worker>> workers) = 0;
};

}   // namespace gnomon::trace
