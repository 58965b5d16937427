// SPDX-License-Identifier: Apache-2.0
// Answers a batch of shadow queries for one light: first from known states, then from the mask of dynamic objects, then
// by rays.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "ray/origin.h"
#include "scene/light_reach.h"
#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::shadow_culling {

namespace {

// Eight bytes of 0 or 1 as one word.
constexpr std::uint64_t k_ones = 0x0101010101010101ull;

template <class Byte>
std::uint64_t eight_at(const Byte* bytes)
{
    static_assert(sizeof(Byte) == 1);
    std::uint64_t eight;
    std::memcpy(&eight, bytes, 8);
    return eight;
}

}   // namespace

// A light in the form that the queries of this frame need.
struct CertifiedCulling::FrameLight {
    int index;
    scene::LightReach reach;
    float end;   // of its shadow rays
};

bool CertifiedCulling::may_meet_dynamic(const Batch& batch, const FrameLight& light, std::uint32_t point) const
{
    constexpr std::size_t k_most_boxes = 8;   // with more boxes, a ray is cheaper
    if (batch.dynamic_objects.size() > k_most_boxes) return true;
    const glm::vec3& origin = batch.points[point].origin;
    const glm::vec3 direction = light.reach.from(origin);
    return std::any_of(batch.dynamic_objects.begin(), batch.dynamic_objects.end(),
                       [&](const Box3& box) { return visibility::segment_meets(box, origin, direction, light.end); });
}

// Answers queries with known states, eight points at a time, and lists the others.
void CertifiedCulling::sort_open(Batch& batch, const FrameLight& light, std::uint8_t* occluded) const
{
    const std::size_t count = batch.points.size();
    const int shift = 2 * (light.index % k_lights_per_group);
    const std::uint8_t* const states =
        batch.states.data() + static_cast<std::size_t>(light.index / k_lights_per_group) * batch.stride;
    std::uint32_t* const asked_point = batch.asked.point.data();
    std::uint8_t* const moving = batch.asked.moving.data();
    std::uint8_t* const is_open = batch.open.data();
    std::size_t asked = 0;
    std::uint64_t known_count = 0;
    const bool test_dynamic_too = !options_.certificates.left_out.has(Check::dynamic_tested);
    for (std::size_t first = 0; first < count; first += 8) {
        // States are 00 unknown, 01 none, 10 full, 11 partial.
        const std::uint64_t eight = eight_at(states + first);
        const std::uint64_t low = (eight >> shift) & k_ones, high = (eight >> (shift + 1)) & k_ones;
        const std::uint64_t full = high & ~low, known = low ^ high;
        std::memcpy(occluded + first, &full, 8);
        known_count += static_cast<std::uint64_t>(__builtin_popcountll(known));   // they face the light
        std::uint64_t rest =
            test_dynamic_too && batch.strip_open[first / Batch::k_strip] ? k_ones & ~full : ~known & k_ones;
        for (; rest != 0; rest &= rest - 1) {
            const std::size_t in_eight = static_cast<std::size_t>(__builtin_ctzll(rest)) / 8, p = first + in_eight;
            if (p >= count) break;
            const auto point = static_cast<std::uint32_t>(p);
            const ShadowPoint& here = batch.points[p];
            const bool open = !((known >> (8 * in_eight)) & 1);
            bool dark = false;
            if (open) {
                const glm::vec3 direction = light.reach.from(here.origin);
                dark = !light.reach.faces(direction, here.normal) || light.reach.outside_cone(direction);
                occluded[p] = dark;
            }
            // Write unconditionally, advance only where the point is not dark, because a branch would be unpredictable.
            asked_point[asked] = point;
            moving[asked] = batch.record[p] == k_no_record;
            is_open[asked] = open;
            asked += !dark;
        }
    }
    batch.asked.count = asked;
    batch.counters.skipped += known_count;
}

// Queries the mask of dynamic objects, and queues the rays that are still needed.
void CertifiedCulling::test_dynamic(Batch& batch, const FrameLight& light, std::uint8_t* occluded)
{
    using Answer = DynamicMask::Answer;
    DynamicMask::Asked& asked = batch.asked;
    const bool draw = !batch.dynamic_objects.empty();
    if (draw) mask_->answer(static_cast<std::uint32_t>(light.index), batch.points, asked);
    for (std::size_t first = 0; first < asked.count; first += 8) {
        // Settle eight points at a time where no dynamic object occludes and static geometry is known not to occlude.
        std::uint64_t rest = k_ones;
        if (draw) {
            const std::uint64_t answers = eight_at(asked.answer.data() + first);
            const std::uint64_t open = eight_at(batch.open.data() + first);
            const std::uint64_t free = (answers >> 1) & ~answers & k_ones;   // the two bits 10
            const std::uint64_t settled = free & (~open | eight_at(asked.clear.data() + first));
            rest = k_ones & ~settled;
            const std::size_t left = asked.count - first;
            const std::uint64_t here = left < 8 ? (std::uint64_t{1} << (8 * left)) - 1 : ~std::uint64_t{0};
            batch.counters.skipped += static_cast<std::uint64_t>(__builtin_popcountll(settled & open & here));
        }
        for (; rest != 0; rest &= rest - 1) {
            const std::size_t i = first + static_cast<std::size_t>(__builtin_ctzll(rest)) / 8;
            if (i >= asked.count) break;
            const std::uint32_t point = asked.point[i];
            const Answer answer = draw ? asked.answer[i] : Answer::free;
            if (answer == Answer::occluded) {
                occluded[point] = 1;
                batch.counters.skipped += batch.open[i];
                continue;
            }
            const glm::vec3& origin = batch.points[point].origin;
            if (batch.open[i] && !(draw && asked.clear[i])) {
                batch.static_rays.push(origin, 0, light.reach.from(origin), light.end);
                batch.static_point.push_back(point);
                batch.then_dynamic.push_back(answer == Answer::unknown ||
                                             (answer == Answer::not_drawn && may_meet_dynamic(batch, light, point)));
                continue;
            }
            batch.counters.skipped += batch.open[i];
            if (answer == Answer::free || (answer == Answer::not_drawn && !may_meet_dynamic(batch, light, point)))
                continue;
            batch.dynamic_rays.push(origin, 0, light.reach.from(origin), light.end);
            batch.dynamic_point.push_back(point);
        }
    }
    batch.counters.traced += batch.static_point.size();
    batch.counters.dynamic_only += batch.dynamic_point.size();
    batch.counters.skipped -= batch.dynamic_point.size();
}

// Traces the rays that static geometry may occlude, and queues those that must then be traced against dynamic objects.
void CertifiedCulling::trace_static(Batch& batch, const FrameLight& light, std::uint8_t* occluded)
{
    const std::size_t traced = batch.static_point.size();
    if (traced == 0) return;
    batch.hit.resize(traced + ray::k_packet_pad);
    rays_->occluded(batch.static_rays, 0, traced, batch.hit.data(), ray::Against::static_only);
    for (std::size_t r = 0; r < traced; ++r) {
        const std::uint32_t point = batch.static_point[r];
        occluded[point] = batch.hit[r];
        if (batch.hit[r] || !batch.then_dynamic[r]) continue;
        const glm::vec3& origin = batch.points[point].origin;
        batch.dynamic_rays.push(origin, 0, light.reach.from(origin), light.end);
        batch.dynamic_point.push_back(point);
    }
    note_seen(batch, light.index);
}

// Records the results of the rays against static geometry as evidence, in the finest parts.
void CertifiedCulling::note_seen(Batch& batch, int light)
{
    const int shift = 2 * (light % k_lights_per_group);
    // Consecutive rays mostly start on one triangle.
    RecordId record = k_no_record;
    bool coarse = false, asked = false;
    std::uint8_t* evidence = nullptr;   // of the light's group
    std::uint32_t level = 0;
    Rim rim{RimCodes{}};
    for (std::size_t r = 0; r < batch.static_point.size(); ++r) {
        const std::uint32_t point = batch.static_point[r];
        if (batch.at.slot[point] == k_no_slot) continue;
        if (batch.record[point] != record) {
            record = batch.record[point];
            coarse = asked = false;
            evidence = nullptr;
        }
        if (state_of(batch, point, light) == ShadowState::partial) {
            ++batch.counters.partial;
            // Parts at the finest level cannot be refined: skip them.
            if (!asked) {
                asked = true;
                coarse = memory_->coarse(record, frame_, [&] {
                    const std::uint32_t at = memory_->level(record);
                    return at < k_max_level && at < wanted_level(record / 2);
                });
            }
            if (!coarse) continue;
        }
        if (!evidence) {
            evidence = memory_->evidence(record);
            if (!evidence) continue;   // memory is full: traced again
            level = memory_->level(record);
            rim = memory_->rim(record);
            evidence += static_cast<std::size_t>(light / k_lights_per_group) << (2 * level);
            if (batch.touched.empty() || batch.touched.back() != record) batch.touched.push_back(record);
        }
        float u, v;
        rim.inside(batch.at.uv[point].x, batch.at.uv[point].y, u, v);
        const auto saw = static_cast<std::uint8_t>((batch.hit[r] ? k_saw_occluded : k_saw_free) << shift);
        std::atomic_ref<std::uint8_t>(evidence[micro_index_at(u, v, level)]).fetch_or(saw, std::memory_order_relaxed);
    }
}

// For a moving light, nothing is remembered and no mask is drawn, because neither would be used again. A ray against
// everything is traced from every point that the light may reach.
void CertifiedCulling::trace_all(Batch& batch, const FrameLight& light, std::uint8_t* occluded) const
{
    ray::RayQueue& queue = batch.static_rays;
    queue.clear();
    batch.static_point.clear();
    for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
        const ShadowPoint& here = batch.points[p];
        const glm::vec3 direction = light.reach.from(here.origin);
        occluded[p] = 1;
        if (!light.reach.faces(direction, here.normal) || light.reach.outside_cone(direction)) continue;
        queue.push(here.origin, 0, direction, light.end);
        batch.static_point.push_back(p);
    }
    const std::size_t traced = queue.size();
    batch.hit.resize(traced + ray::k_packet_pad);
    rays_->occluded(queue, 0, traced, batch.hit.data());
    for (std::size_t r = 0; r < traced; ++r) occluded[batch.static_point[r]] = batch.hit[r];
    batch.counters.traced += traced;
}

void CertifiedCulling::shadow(Batch& batch, int light, std::uint8_t* occluded, std::uint8_t* rays)
{
    const scene::LightReach reach(state_->scene().lights[static_cast<std::size_t>(light)],
                                  state_->light(static_cast<scene::LightId>(light)));
    const FrameLight here{light, reach, reach.directional() ? k_infinity : ray::k_shadow_ray_end};
    if (!light_on_[static_cast<std::size_t>(light)]) {
        trace_all(batch, here, occluded);
        if (rays)
            for (const std::uint32_t point : batch.static_point) rays[point] = 1;
        return;
    }
    dynamic_->select(batch.bounds, reach.place(), reach.directional(), batch.dynamic_objects);
    batch.strip_open.assign(batch.strip_bounds.size(), 0);
    for (std::size_t s = 0; s < batch.strip_open.size(); ++s)
        batch.strip_open[s] =
            std::any_of(batch.dynamic_objects.begin(), batch.dynamic_objects.end(), [&](const Box3& box) {
                return visibility::may_shadow(box, batch.strip_bounds[s], reach.place(), reach.directional());
            });
    batch.static_rays.clear();
    batch.static_point.clear();
    batch.then_dynamic.clear();
    batch.dynamic_rays.clear();
    batch.dynamic_point.clear();
    batch.asked.clear_questions(batch.points.size());
    batch.open.resize(batch.points.size() + 8);
    sort_open(batch, here, occluded);
    test_dynamic(batch, here, occluded);
    if (rays) {
        for (const std::uint32_t point : batch.static_point) rays[point] = 1;
        for (const std::uint32_t point : batch.dynamic_point) rays[point] = 2;
    }
    trace_static(batch, here, occluded);

    // Trace against dynamic objects where nothing static occludes.
    if (const std::size_t moving = batch.dynamic_point.size(); moving > 0) {
        batch.hit.resize(moving + ray::k_packet_pad);
        rays_->occluded(batch.dynamic_rays, 0, moving, batch.hit.data(), ray::Against::dynamic_only);
        for (std::size_t r = 0; r < moving; ++r) occluded[batch.dynamic_point[r]] |= batch.hit[r];
    }
}

}   // namespace gnomon::shadow_culling
