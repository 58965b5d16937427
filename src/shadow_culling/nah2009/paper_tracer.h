// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shadow rays of one thread under the published shadow culling [Nah 2009, 2.4 and 2.5]: what Table 2 leaves to
// trace is traced, and what it met is noted for Table 3. Primary, reflected and refracted hits alike.
//
// The ray scene keeps what stands still and what moves in trees of their own, so a full traversal is the first tree,
// then the second where the first let the ray pass; a traversal of dynamic objects alone is the second.
//
// Cost: one look-up a ray; the rays that are left.

#include <span>
#include <utility>
#include <vector>

#include "shadow_culling/nah2009/paper_culling.h"

namespace gnomon::shadow_culling {

class PaperTracer {
 public:
    using Notes = PaperCulling::Notes;

    /// Answers one light's shadow rays. Threads may share `culling`, each with a tracer of its own.
    /// @param asked    the rays, as a full trace would cast them
    /// @param origins  by ray: the primitive that it leaves
    /// @param occluded  by ray: 1 where it is taken as occluded, else 0
    /// @param traced   optional, by ray: 1 where it was traced against everything, 2 against dynamic objects alone, 0
    /// not at all
    void answer(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                std::span<const PrimitiveId> origins, std::uint8_t* occluded, std::uint8_t* traced = nullptr);

    /// What it learned in this frame, for PaperCulling::end_frame.
    Notes take_notes() { return std::exchange(notes_, {}); }

 private:
    void trace_full(PaperCulling& culling, const ray::RayScene& rays, int light, std::span<const PrimitiveId> origins,
                    std::uint8_t* occluded);

    Notes notes_;
    ray::RayQueue full_, moving_;
    std::vector<std::uint32_t> full_ray_, moving_ray_;   // by ray of these queues: which was asked
    std::vector<std::uint8_t> hit_;
};

}   // namespace gnomon::shadow_culling
