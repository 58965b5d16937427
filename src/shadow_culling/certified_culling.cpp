// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified_culling.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "base/check.h"
#include "shadow_culling/judge.h"

namespace gnomon::shadow_culling {

void CullingCounters::add(const CullingCounters& o)
{
    skipped += o.skipped;
    dynamic_only += o.dynamic_only;
    traced += o.traced;
    partial += o.partial;
    certificates += o.certificates;
    certified += o.certified;
}

CertifiedCulling::CertifiedCulling(const scene::SceneState& state, const ray::RayScene& rays,
                                   const CertifiedOptions& options)
    : state_(&state), rays_(&rays), options_(options)
{
    lifted_.assign(state.scene().objects.size(), 0);
    rebuild();
}

CertifiedCulling::~CertifiedCulling() = default;

void CertifiedCulling::rebuild()
{
    const int lights = static_cast<int>(state_->scene().lights.size());
    triangles_ = std::make_unique<StaticTriangles>(*state_, *rays_, lifted_);
    memory_ = std::make_unique<ShadowMemory>(2 * triangles_->size(), lights, options_.memory);
    light_on_.assign(static_cast<std::size_t>(lights), 1);
    movers_ = std::make_unique<MoverBounds>(*state_, *rays_, lifted_);
}

std::unique_ptr<CertifiedCulling::Batch> CertifiedCulling::make_batch() const
{
    return std::make_unique<Batch>();
}

void CertifiedCulling::begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view)
{
    state_ = &state;
    rays_ = &rays;
    view_ = view;
    ++frame_;
    counters_ = {};
    const scene::FrameChanges& changes = state.changes();
    movers_->update(state, rays);

    // A static object moved by hand: what stands still is no longer what it was.
    const scene::Scene& scene = state.scene();
    bool fewer_stand_still = false;
    for (const auto* list : {&changes.moved, &changes.appeared, &changes.vanished})
        for (const scene::ObjectId o : *list) {
            if (scene.objects[o].dynamic || lifted_[o]) continue;
            lifted_[o] = 1;
            fewer_stand_still = true;
        }
    if (fewer_stand_still) rebuild();

    // A light that moves is not remembered; one that stopped starts afresh.
    for (const scene::LightId l : changes.lights_moved) light_on_[l] = 0;
    for (const scene::LightId l : changes.lights_stopped) {
        memory_->forget_light(static_cast<int>(l));
        light_on_[l] = 1;
    }
    any_light_on_ = std::find(light_on_.begin(), light_on_.end(), 1) != light_on_.end();
    group_mask_.assign(static_cast<std::size_t>(memory_->groups()), 0);
    for (std::size_t l = 0; l < light_on_.size(); ++l)
        if (light_on_[l])
            group_mask_[l / k_lights_per_group] |= static_cast<std::uint8_t>(3 << (2 * (l % k_lights_per_group)));
}

RimCodes CertifiedCulling::rim_of_record(RecordId record) const
{
    const double width = options_.rim_margins * options_.certificates.margin;
    return rim_of((*triangles_)[record / 2].p, static_cast<float>(width) * triangles_->largest_coordinate());
}

// The level whose parts cover about `pixels_per_part` pixels where the triangle comes nearest to the eye. A function of
// triangle and view alone, so that counts do not depend on threads.
std::uint32_t CertifiedCulling::wanted_level(TriangleId id) const
{
    const StaticTriangle& t = (*triangles_)[id];
    const glm::vec3 n = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
    const float double_area = glm::length(n);
    if (!(double_area > 0)) return 0;

    float nearest = k_infinity, cosine = 0;
    const glm::vec3 centre = (t.p[0] + t.p[1] + t.p[2]) / 3.0f;
    for (const glm::vec3& p : {t.p[0], t.p[1], t.p[2], centre, 0.5f * (t.p[0] + t.p[1]), 0.5f * (t.p[1] + t.p[2]),
                               0.5f * (t.p[2] + t.p[0])}) {
        const glm::vec3 to_eye = view_.eye - p;
        const float distance = glm::length(to_eye);
        nearest = std::min(nearest, distance);
        if (distance > 0) cosine = std::max(cosine, std::abs(glm::dot(n, to_eye)) / (double_area * distance));
    }
    const double pixel = std::max<double>(view_.pixel_width + view_.pixel_spread * nearest, 1e-12);
    const double pixels = 0.5 * double_area * std::max(cosine, 0.05f) / (pixel * pixel);
    const double parts = pixels / options_.pixels_per_part;
    if (!(parts > 1)) return 0;
    return std::min(k_max_level, static_cast<std::uint32_t>(std::ceil(0.5 * std::log2(parts))));
}

void CertifiedCulling::classify(Batch& batch, std::span<const ShadowPoint> points)
{
    const std::size_t count = points.size();
    const auto groups = static_cast<std::size_t>(memory_->groups());
    LookUp& at = batch.at;
    at.resize(count);
    batch.points = points;
    batch.stride = at.slot.size();
    batch.record.resize(count);
    batch.states.resize(batch.stride * groups);

    // Nothing is remembered while every light moves.
    if (!any_light_on_) {
        std::fill(at.slot.begin(), at.slot.end(), k_no_slot);
        std::fill(batch.states.begin(), batch.states.end(), 0);
        batch.bounds = Box3{};
        for (const ShadowPoint& point : points) batch.bounds.add(point.origin);
        return;
    }

    // Find every point's record; neighbours mostly share one.
    Box3 bounds;
    RecordId last = k_no_slot;
    scene::ObjectId last_object = scene::none;
    TriangleId first = no_triangle;
    std::uint32_t begin = k_no_slot;   // of the record's finest level
    float divisions = 1;
    Rim rim{RimCodes{}};
    for (std::size_t i = 0; i < count; ++i) {
        const ShadowPoint& point = points[i];
        bounds.add(point.origin);
        if (point.object != last_object) {
            last_object = point.object;
            first = triangles_->first_of(point.object);
            last = begin = k_no_slot;
        }
        if (first != no_triangle) {
            const RecordId record = 2 * (first + point.triangle) + (point.front ? 0 : 1);
            batch.record[i] = record;
            if (record != last) {
                last = record;
                if (memory_->base(record) == k_no_slot && !memory_->full())
                    memory_->create(record, wanted_level(record / 2), rim_of_record(record));
                memory_->note_seen(record, frame_);
                begin = memory_->base(record);
                const std::uint32_t level = memory_->level(record);
                if (begin != k_no_slot) begin += pyramid_offset(level);
                divisions = static_cast<float>(1u << level);
                rim = memory_->rim(record);
            }
        }
        at.slot[i] = begin;
        at.u[i] = point.u, at.v[i] = point.v;
        at.rim_u[i] = rim.u, at.rim_v[i] = rim.v, at.per_inner[i] = rim.per_inner;
        at.divisions[i] = divisions;
    }
    batch.bounds = bounds;

    find_parts(at);
    for (std::size_t g = 0; g < groups; ++g)
        fetch_states(at, memory_->states(static_cast<int>(g)), group_mask_[g], batch.states.data() + g * batch.stride);
}

ShadowState CertifiedCulling::state_of(const Batch& batch, std::uint32_t point, int light) const
{
    const auto group = static_cast<std::size_t>(light / k_lights_per_group);
    return static_cast<ShadowState>((batch.states[group * batch.stride + point] >> (2 * (light % k_lights_per_group))) &
                                    3);
}

// A light as this frame's queries see it.
struct CertifiedCulling::Lamp {
    int index;
    bool directional;
    glm::vec3 to;   // its place, or the direction towards it
    float end;      // of its shadow rays

    glm::vec3 axis{0};         // of a spot, the way it shines
    float outer_cosine = -2;   // of its cone; below -1: no spot

    glm::vec3 from(const glm::vec3& origin) const { return directional ? to : to - origin; }
    // Certainly dark, whatever stands between. A little room: the shading decides at the very edge.
    bool outside_cone(const glm::vec3& to_light) const
    {
        constexpr float k_edge = 1e-4f;
        if (outer_cosine < -1) return false;
        return -glm::dot(to_light, axis) < (outer_cosine - k_edge) * glm::length(to_light);
    }
};

void CertifiedCulling::queue_dynamic(Batch& batch, const Lamp& lamp, std::uint32_t point) const
{
    const glm::vec3& origin = batch.points[point].origin;
    const glm::vec3 direction = lamp.from(origin);
    for (const Box3& box : batch.movers) {
        if (!segment_meets(box, origin, direction, lamp.end)) continue;
        batch.dynamic_rays.push(origin, 0, direction, lamp.end);
        batch.dynamic_point.push_back(point);
        return;
    }
}

// Answers what is known, eight points at a time, and queues the rest.
void CertifiedCulling::sort_open(Batch& batch, const Lamp& lamp, std::uint8_t* blocked) const
{
    constexpr std::uint64_t k_ones = 0x0101010101010101ull;
    const std::size_t count = batch.points.size();
    const int shift = 2 * (lamp.index % k_lights_per_group);
    const std::uint8_t* const states =
        batch.states.data() + static_cast<std::size_t>(lamp.index / k_lights_per_group) * batch.stride;
    const bool nothing_moves = batch.movers.empty();
    for (std::size_t first = 0; first < count; first += 8) {
        // States are 00 unknown, 01 none, 10 full, 11 partial.
        std::uint64_t eight;
        std::memcpy(&eight, states + first, 8);
        const std::uint64_t low = (eight >> shift) & k_ones, high = (eight >> (shift + 1)) & k_ones;
        const std::uint64_t full = high & ~low;
        std::memcpy(blocked + first, &full, 8);
        batch.counters.skipped +=
            static_cast<std::uint64_t>(__builtin_popcountll(low ^ high));   // none and full face it
        std::uint64_t rest = nothing_moves ? ~(low ^ high) & k_ones : k_ones & ~full;
        for (; rest != 0; rest &= rest - 1) {
            const std::size_t p = first + static_cast<std::size_t>(__builtin_ctzll(rest)) / 8;
            if (p >= count) break;
            const auto point = static_cast<std::uint32_t>(p);
            if (((low ^ high) >> (8 * (p - first))) & 1) {   // none: it faces the light, and only movers can matter
                queue_dynamic(batch, lamp, point);
                continue;
            }
            const ShadowPoint& here = batch.points[p];
            const glm::vec3 direction = lamp.from(here.origin);
            if (!(glm::dot(direction, here.normal) > 0) || lamp.outside_cone(direction)) {
                blocked[p] = 1;
                continue;
            }
            batch.static_rays.push(here.origin, 0, direction, lamp.end);
            batch.static_point.push_back(point);
        }
    }
}

void CertifiedCulling::shadow(Batch& batch, int light, std::uint8_t* blocked, std::uint8_t* rays)
{
    const scene::LightState& at = state_->light(static_cast<scene::LightId>(light));
    const scene::Light& described = state_->scene().lights[static_cast<std::size_t>(light)];
    const bool directional = described.type == scene::LightType::directional;
    Lamp lamp{light, directional, directional ? -at.direction : at.position,
              directional ? k_infinity : options_.ray_end};
    if (described.type == scene::LightType::spot) {
        lamp.axis = at.direction;
        lamp.outer_cosine = std::cos(described.outer_angle);
    }
    movers_->select(batch.bounds, lamp.to, directional, batch.movers);
    batch.static_rays.clear();
    batch.static_point.clear();
    batch.dynamic_rays.clear();
    batch.dynamic_point.clear();
    sort_open(batch, lamp, blocked);
    batch.counters.dynamic_only += batch.dynamic_point.size();
    batch.counters.skipped -= batch.dynamic_point.size();
    if (rays) {
        for (const std::uint32_t point : batch.static_point) rays[point] = 1;
        for (const std::uint32_t point : batch.dynamic_point) rays[point] = 2;
    }

    // Trace against what stands still, and note what the rays saw.
    const std::size_t traced = batch.static_point.size();
    batch.counters.traced += traced;
    if (traced > 0) {
        batch.hit.resize(traced + ray::k_packet_pad);
        rays_->blocked(batch.static_rays, 0, traced, batch.hit.data(), ray::Against::static_only);
        const bool remembered = light_on_[static_cast<std::size_t>(light)];
        const int shift = 2 * (light % k_lights_per_group);
        std::uint8_t* const evidence = memory_->evidence(light / k_lights_per_group);
        RecordId judged = k_no_slot;
        bool coarse = false;
        for (std::size_t r = 0; r < traced; ++r) {
            const std::uint32_t point = batch.static_point[r];
            blocked[point] = batch.hit[r];
            if (!batch.hit[r] && !batch.movers.empty()) queue_dynamic(batch, lamp, point);
            const std::uint32_t slot = batch.at.slot[point];
            if (slot == k_no_slot || !remembered) continue;
            if (state_of(batch, point, light) == ShadowState::partial) {
                ++batch.counters.partial;
                // Nothing to learn where parts are as fine as they get.
                if (batch.record[point] != judged) {
                    judged = batch.record[point];
                    coarse = memory_->coarse(judged, frame_, [&] {
                        const std::uint32_t level = memory_->level(judged);
                        return level < k_max_level && level < wanted_level(judged / 2);
                    });
                }
                if (!coarse) continue;
            }
            if (batch.touched.empty() || batch.touched.back() != batch.record[point])
                batch.touched.push_back(batch.record[point]);
            const auto saw = static_cast<std::uint8_t>((batch.hit[r] ? k_saw_blocked : k_saw_free) << shift);
            std::atomic_ref<std::uint8_t>(evidence[slot]).fetch_or(saw, std::memory_order_relaxed);
        }
    }

    // Trace against what moves, where nothing static was in the way.
    if (const std::size_t moving = batch.dynamic_point.size(); moving > 0) {
        batch.hit.resize(moving + ray::k_packet_pad);
        rays_->blocked(batch.dynamic_rays, 0, moving, batch.hit.data(), ray::Against::dynamic_only);
        for (std::size_t r = 0; r < moving; ++r) blocked[batch.dynamic_point[r]] |= batch.hit[r];
    }
}

void CertifiedCulling::end_frame(std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks)
{
    // Gather the records with news.
    std::vector<RecordId> records;
    for (const auto& batch : batches) {
        if (!batch) continue;
        records.insert(records.end(), batch->touched.begin(), batch->touched.end());
        batch->touched.clear();
        counters_.add(batch->counters);
        batch->counters = {};
    }
    std::sort(records.begin(), records.end());
    records.erase(std::unique(records.begin(), records.end()), records.end());

    // Judge them, each by itself: a record's pyramid belongs to one task.
    constexpr std::size_t k_chunk = 64;
    std::vector<std::unique_ptr<Judge>> judges(static_cast<std::size_t>(tasks.threads()));
    tasks.for_each((records.size() + k_chunk - 1) / k_chunk, [&](std::size_t chunk, int worker) {
        auto& judge = judges[static_cast<std::size_t>(worker)];
        if (!judge) judge = std::make_unique<Judge>(*state_, *triangles_, *memory_, light_on_, options_);
        const std::size_t end = std::min(records.size(), (chunk + 1) * k_chunk);
        for (std::size_t r = chunk * k_chunk; r < end; ++r) judge->judge(records[r]);
    });
    for (const auto& judge : judges)
        if (judge) counters_.add(judge->counters());

    // Deepen what is partial and covers many pixels, for the next frame.
    for (const RecordId record : records) {
        const std::uint32_t wanted = wanted_level(record / 2);
        if (wanted > memory_->level(record)) memory_->deepen(record, wanted);
    }
    if (memory_->full()) memory_->drop_unseen(frame_);
}

std::size_t CertifiedCulling::bytes() const
{
    return memory_->bytes();
}

}   // namespace gnomon::shadow_culling
