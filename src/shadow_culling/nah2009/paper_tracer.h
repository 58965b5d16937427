// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traces the shadow rays of one thread with the published shadow culling [Nah 2009, 2.4 and 2.5]: those that Table 2
// leaves are traced, and their results are noted for Table 3. For primary, reflected and refracted hits alike.
//
// The ray scene has separate trees for what cannot and what may change in the clip. A full traversal traces the former,
// then the latter for rays that are not occluded; a traversal of dynamic objects only traces the latter. Objects of the
// latter that are at rest now count as static: where one occludes a ray, the ray is followed from surface to surface.
//
// Cost: one look-up per ray, and the remaining rays.

#include <span>
#include <utility>
#include <vector>

#include "shadow_culling/nah2009/paper_culling.h"

namespace gnomon::shadow_culling {

class PaperTracer {
 public:
    using Notes = PaperCulling::Notes;

    /// Traces the shadow rays of one light. Threads may share `culling`, each with a tracer of its own.
    /// @param asked    the rays that a full trace would cast
    /// @param origins  by ray: the primitive that it leaves
    /// @param occluded  by ray: set to 1 where it counts as occluded, else to 0
    /// @param traced    optional, by ray: set to 1 where it was traced against everything, 2 against dynamic objects
    ///                  only, 0 not at all
    void answer(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                std::span<const PrimitiveId> origins, std::uint8_t* occluded, std::uint8_t* traced = nullptr);

    /// Its results in this frame, for PaperCulling::end_frame.
    Notes take_notes() { return std::exchange(notes_, {}); }

 private:
    struct Occluders {
        bool resting = false;   // an object that may change in the clip, and is static now
        bool dynamic = false;
    };
    void answer_some(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                     std::span<const PrimitiveId> origins, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                     std::uint8_t* traced);
    Occluders occluders_of(const PaperCulling& culling, const ray::RayScene& rays, const ray::RayQueue& queue,
                           std::size_t i);
    void trace_full(PaperCulling& culling, const ray::RayScene& rays, int light, std::span<const PrimitiveId> origins,
                    std::uint8_t* occluded);

    Notes notes_;
    ray::RayQueue full_, dynamic_;
    std::vector<std::uint32_t> full_ray_, dynamic_ray_;   // by ray of these queues: its index in `asked`
    std::vector<std::uint8_t> hit_;
    ray::RayQueue ray_;   // the one that is followed
    ray::Hits surface_;
};

}   // namespace gnomon::shadow_culling
