// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/paper_tracer.h"

#include "base/check.h"

namespace gnomon::shadow_culling {

void PaperTracer::answer(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                         std::span<const PrimitiveId> origins, std::uint8_t* occluded, std::uint8_t* traced)
{
    GNOMON_CHECK_EQ(asked.size(), origins.size());
    full_.clear(), moving_.clear();
    full_ray_.clear(), moving_ray_.clear();

    // Sort the rays by their decision of Table 2.
    for (std::uint32_t i = 0; i < origins.size(); ++i) {
        const ShadowDecision decision = culling.decide(origins[i], light, notes_);
        if (traced)
            traced[i] = decision == ShadowDecision::in_shadow ? 0 : decision == ShadowDecision::dynamic_only ? 2 : 1;
        if (decision == ShadowDecision::in_shadow) {
            occluded[i] = 1;
            continue;
        }
        const bool all = decision == ShadowDecision::full_traversal;
        (all ? full_ : moving_).push(asked.origin(i), asked.tnear[i], asked.direction(i), asked.tfar[i]);
        (all ? full_ray_ : moving_ray_).push_back(i);
    }

    // Trace the remaining rays.
    trace_full(culling, rays, light, origins, occluded);
    hit_.resize(moving_.size() + ray::k_packet_pad);
    rays.occluded(moving_, 0, moving_.size(), hit_.data(), ray::Against::dynamic_only);
    for (std::size_t i = 0; i < moving_.size(); ++i) occluded[moving_ray_[i]] = hit_[i];
}

// Traces static objects first, so that their effect is also known for rays that a dynamic object occludes.
void PaperTracer::trace_full(PaperCulling& culling, const ray::RayScene& rays, int light,
                             std::span<const PrimitiveId> origins, std::uint8_t* occluded)
{
    hit_.resize(full_.size() + ray::k_packet_pad);
    rays.occluded(full_, 0, full_.size(), hit_.data(), ray::Against::static_only);
    // Trace the rays that pass the static objects against the dynamic ones; move them to the front of the queue.
    std::size_t passed = 0;
    for (std::size_t i = 0, count = full_.size(); i < count; ++i) {
        const std::uint32_t r = full_ray_[i];
        if (hit_[i]) {
            occluded[r] = 1;
            culling.note(origins[r], light, StaticPart::occluded, false, notes_);
            continue;
        }
        for (auto* a : {&full_.ox, &full_.oy, &full_.oz, &full_.tnear, &full_.dx, &full_.dy, &full_.dz, &full_.tfar})
            (*a)[passed] = (*a)[i];
        full_ray_[passed++] = r;
    }
    rays.occluded(full_, 0, passed, hit_.data(), ray::Against::dynamic_only);
    for (std::size_t i = 0; i < passed; ++i) {
        const std::uint32_t r = full_ray_[i];
        occluded[r] = hit_[i];
        culling.note(origins[r], light, StaticPart::free, hit_[i] != 0, notes_);
    }
}

}   // namespace gnomon::shadow_culling
