// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/paper_tracer.h"

#include <cmath>

#include "base/check.h"

namespace gnomon::shadow_culling {

namespace {

// A ray passes at most so many surfaces while its occluders are told apart; what is beyond counts as dynamic.
constexpr int k_most_surfaces = 256;

std::uint8_t code_of(ShadowDecision decision)
{
    switch (decision) {
        case ShadowDecision::full_traversal:
            return 1;
        case ShadowDecision::dynamic_only:
            return 2;
        case ShadowDecision::in_shadow:
        case ShadowDecision::lit:
            break;
    }
    return 0;
}

}   // namespace

void PaperTracer::answer(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                         std::span<const PrimitiveId> origins, std::uint8_t* occluded, std::uint8_t* traced)
{
    GNOMON_CHECK_EQ(asked.size(), origins.size());
    // Modes that are written at once bear on the next ray: one after the other, then.
    const std::size_t step = culling.options().writes_at_once ? 1 : origins.size();
    for (std::size_t begin = 0; begin < origins.size(); begin += step)
        answer_some(culling, rays, light, asked, origins, begin, begin + step, occluded, traced);
}

void PaperTracer::answer_some(PaperCulling& culling, const ray::RayScene& rays, int light, const ray::RayQueue& asked,
                              std::span<const PrimitiveId> origins, std::size_t begin, std::size_t end,
                              std::uint8_t* occluded, std::uint8_t* traced)
{
    full_.clear(), dynamic_.clear();
    full_ray_.clear(), dynamic_ray_.clear();

    // Sort the rays by their decision of Table 2.
    for (std::size_t i = begin; i < end; ++i) {
        const ShadowDecision decision = culling.decide(origins[i], light, notes_);
        const std::uint8_t code = code_of(decision);
        if (traced) traced[i] = code;
        occluded[i] = decision == ShadowDecision::in_shadow;
        if (code == 0) continue;
        (code == 1 ? full_ : dynamic_).push(asked.origin(i), asked.tnear[i], asked.direction(i), asked.tfar[i]);
        (code == 1 ? full_ray_ : dynamic_ray_).push_back(static_cast<std::uint32_t>(i));
    }

    // Trace the remaining rays.
    trace_full(culling, rays, light, origins, occluded);
    hit_.resize(dynamic_.size() + ray::k_packet_pad);
    rays.occluded(dynamic_, 0, dynamic_.size(), hit_.data(), ray::Against::dynamic_only);
    for (std::size_t i = 0; i < dynamic_.size(); ++i) {
        // The ray scene's dynamic objects are those of the clip. Of these, some may be at rest now.
        if (hit_[i] && culling.some_rest()) hit_[i] = occluders_of(culling, rays, dynamic_, i).dynamic;
        occluded[dynamic_ray_[i]] = hit_[i];
    }
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
        Occluders by{false, hit_[i] != 0};
        if (hit_[i] && culling.some_rest()) by = occluders_of(culling, rays, full_, i);
        culling.note(origins[r], light, by.resting ? StaticPart::occluded : StaticPart::free, by.dynamic, notes_);
    }
}

// Follows the ray from surface to surface, because the ray scene tells apart only what may change in the clip.
PaperTracer::Occluders PaperTracer::occluders_of(const PaperCulling& culling, const ray::RayScene& rays,
                                                 const ray::RayQueue& queue, std::size_t i)
{
    if (!culling.any_dynamic()) return {true, false};
    Occluders found;
    float tnear = queue.tnear[i];
    ray_.clear();
    ray_.push(queue.origin(i), tnear, queue.direction(i), queue.tfar[i]);
    surface_.resize(1);
    for (int surfaces = 0; surfaces < k_most_surfaces && !(found.resting && found.dynamic); ++surfaces) {
        ray_.tnear[0] = tnear;
        rays.closest(ray_, 0, 1, surface_, ray::Sides::both, ray::Against::dynamic_only);
        const scene::ObjectId object = surface_.object[0];
        if (object == scene::none) break;
        if (!culling.lets_light_through(object, surface_.triangle[0]))
            (culling.is_dynamic(object) ? found.dynamic : found.resting) = true;
        tnear = std::nextafter(std::max(surface_.t[0], tnear), k_infinity);
    }
    // Where the two queries disagree about an edge, nothing is learned of static objects.
    if (!found.resting) found.dynamic = true;
    return found;
}

}   // namespace gnomon::shadow_culling
