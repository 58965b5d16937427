// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified_culling.h"

#include <algorithm>
#include <atomic>

#include "base/check.h"
#include "shadow_culling/judge.h"

namespace gnomon::shadow_culling {

void CullingCounters::add(const CullingCounters& o)
{
    queries += o.queries;
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
    rebuild();
    movers_ = std::make_unique<MoverBounds>(state, rays);
}

CertifiedCulling::~CertifiedCulling() = default;

void CertifiedCulling::rebuild()
{
    const int lights = static_cast<int>(state_->scene().lights.size());
    triangles_ = std::make_unique<StaticTriangles>(*state_, *rays_);
    memory_ = std::make_unique<ShadowMemory>(2 * triangles_->size(), lights, options_.memory);
    light_on_.assign(static_cast<std::size_t>(lights), 1);
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
    for (const auto* list : {&changes.moved, &changes.appeared, &changes.vanished})
        for (const scene::ObjectId o : *list)
            if (!scene.objects[o].dynamic && triangles_->first_of(o) != no_triangle) {
                rebuild();
                movers_ = std::make_unique<MoverBounds>(state, rays);
                break;
            }

    // A light that moves is not remembered; one that stopped starts afresh.
    for (const scene::LightId l : changes.lights_moved) light_on_[l] = 0;
    for (const scene::LightId l : changes.lights_stopped) {
        memory_->forget_light(static_cast<int>(l));
        light_on_[l] = 1;
    }
    group_mask_.assign(static_cast<std::size_t>(memory_->groups()), 0);
    for (std::size_t l = 0; l < light_on_.size(); ++l)
        if (light_on_[l])
            group_mask_[l / k_lights_per_group] |= static_cast<std::uint8_t>(3 << (2 * (l % k_lights_per_group)));
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
    batch.points = points;
    batch.bounds = Box3{};
    batch.slot.resize(count);
    batch.record.resize(count);
    batch.states.resize(count * groups);
    RecordId last = k_no_slot;
    for (std::size_t i = 0; i < count; ++i) {
        const ShadowPoint& point = points[i];
        batch.bounds.add(point.origin);
        const TriangleId first = triangles_->first_of(point.object);
        if (first == no_triangle) {
            batch.slot[i] = k_no_slot;
            continue;
        }
        const RecordId record = 2 * (first + point.triangle) + (point.front ? 0 : 1);
        batch.record[i] = record;
        if (record != last) {
            if (memory_->base(record) == k_no_slot && !memory_->full())
                memory_->create(record, wanted_level(record / 2));
            memory_->note_seen(record, frame_);
            last = record;
        }
        batch.slot[i] = memory_->slot(record, point.u, point.v);
    }
    for (std::size_t g = 0; g < groups; ++g) {
        const std::uint8_t* const states = memory_->states(static_cast<int>(g));
        std::uint8_t* const out = batch.states.data() + g * count;
        const std::uint8_t mask = group_mask_[g];
        for (std::size_t i = 0; i < count; ++i) out[i] = batch.slot[i] == k_no_slot ? 0 : states[batch.slot[i]] & mask;
    }
}

ShadowState CertifiedCulling::state_of(const Batch& batch, std::uint32_t point, int light) const
{
    const std::size_t group = static_cast<std::size_t>(light / k_lights_per_group);
    const std::uint8_t byte = batch.states[group * batch.points.size() + point];
    return static_cast<ShadowState>((byte >> (2 * (light % k_lights_per_group))) & 3);
}

void CertifiedCulling::resolve(Batch& batch, int light, std::span<const std::uint32_t> which, std::uint8_t* blocked)
{
    const scene::Light& lamp = state_->scene().lights[static_cast<std::size_t>(light)];
    const scene::LightState& at = state_->light(static_cast<scene::LightId>(light));
    const bool directional = lamp.type == scene::LightType::directional;
    const glm::vec3 light_vector = directional ? -at.direction : at.position;
    const float end = directional ? k_infinity : options_.ray_end;
    const auto direction_from = [&](const glm::vec3& origin) {
        return directional ? light_vector : light_vector - origin;
    };

    // Sort the queries by what is known.
    movers_->select(batch.bounds, light_vector, directional, batch.movers);
    batch.static_rays.clear();
    batch.static_query.clear();
    batch.dynamic_rays.clear();
    batch.dynamic_query.clear();
    const auto queue_dynamic = [&](std::uint32_t query, const glm::vec3& origin, const glm::vec3& direction) {
        for (const Box3& box : batch.movers)
            if (segment_meets(box, origin, direction, end)) {
                batch.dynamic_rays.push(origin, 0, direction, end);
                batch.dynamic_query.push_back(query);
                return true;
            }
        return false;
    };
    batch.counters.queries += which.size();
    for (std::uint32_t q = 0; q < which.size(); ++q) {
        const ShadowState known = state_of(batch, which[q], light);
        if (known == ShadowState::full) {
            blocked[q] = 1;
            ++batch.counters.skipped;
            continue;
        }
        blocked[q] = 0;
        const glm::vec3& origin = batch.points[which[q]].origin;
        if (known == ShadowState::none) {
            if (batch.movers.empty() || !queue_dynamic(q, origin, direction_from(origin)))
                ++batch.counters.skipped;
            else
                ++batch.counters.dynamic_only;
            continue;
        }
        batch.static_rays.push(origin, 0, direction_from(origin), end);
        batch.static_query.push_back(q);
    }

    // Trace against what stands still, and note what the rays saw.
    const std::size_t traced = batch.static_query.size();
    batch.counters.traced += traced;
    if (traced > 0) {
        batch.hit.resize(traced + ray::k_packet_pad);
        rays_->blocked(batch.static_rays, 0, traced, batch.hit.data(), ray::Against::static_only);
        const bool remembered = light_on_[static_cast<std::size_t>(light)];
        const int shift = 2 * (light % k_lights_per_group);
        std::uint8_t* const evidence = memory_->evidence(light / k_lights_per_group);
        for (std::size_t r = 0; r < traced; ++r) {
            const std::uint32_t q = batch.static_query[r];
            const std::uint32_t point = which[q];
            blocked[q] = batch.hit[r];
            if (!batch.hit[r]) queue_dynamic(q, batch.static_rays.origin(r), batch.static_rays.direction(r));
            const std::uint32_t slot = batch.slot[point];
            if (slot == k_no_slot || !remembered) continue;
            const bool partial = state_of(batch, point, light) == ShadowState::partial;
            batch.counters.partial += partial;
            if (batch.touched.empty() || batch.touched.back() != batch.record[point])
                batch.touched.push_back(batch.record[point]);
            const auto saw = static_cast<std::uint8_t>((batch.hit[r] ? k_saw_blocked : k_saw_free) << shift);
            std::atomic_ref<std::uint8_t>(evidence[slot]).fetch_or(saw, std::memory_order_relaxed);
        }
    }

    // Trace against what moves, where nothing static was in the way.
    if (const std::size_t moving = batch.dynamic_query.size(); moving > 0) {
        batch.hit.resize(moving + ray::k_packet_pad);
        rays_->blocked(batch.dynamic_rays, 0, moving, batch.hit.data(), ray::Against::dynamic_only);
        for (std::size_t r = 0; r < moving; ++r) blocked[batch.dynamic_query[r]] |= batch.hit[r];
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
