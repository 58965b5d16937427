// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified/certified_culling.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "base/check.h"
#include "base/interruption.h"
#include "shadow_culling/certified/judge.h"

namespace gnomon::shadow_culling {

namespace {

constexpr std::uint64_t k_no_limit = ~std::uint64_t{0};
constexpr std::uint64_t k_always_certificates = 64;   // per frame, however small

}   // namespace

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
    const int lights = static_cast<int>(state.scene().lights.size());
    triangles_ = std::make_unique<StaticTriangles>(state, rays, options.certificates.left_out);
    memory_ = std::make_unique<ShadowMemory>(2 * triangles_->size(), lights, options.memory);
    light_on_.assign(static_cast<std::size_t>(lights), 1);
    dynamic_ = std::make_unique<visibility::DynamicBounds>(state, rays);
    mask_ = std::make_unique<DynamicMask>(state, rays, *triangles_, options.mask);
}

CertifiedCulling::~CertifiedCulling() = default;

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
    if (!changes.added.empty()) triangles_->follow(state.scene());
    dynamic_->update(state, rays);
    mask_->begin_frame(state, rays, view);

    // Nothing is remembered for a moving light; the memory of one that stopped starts empty.
    const LeftOut left_out = options_.certificates.left_out;
    for (const scene::LightId l : changes.lights_moved) light_on_[l] = left_out.has(Check::light_moves);
    for (const scene::LightId l : changes.lights_stopped) {
        if (!left_out.has(Check::light_stops)) memory_->forget_light(static_cast<int>(l));
        light_on_[l] = 1;
    }
    forget_promoted();
    any_light_on_ = std::find(light_on_.begin(), light_on_.end(), 1) != light_on_.end();
    group_mask_.assign(static_cast<std::size_t>(memory_->groups()), 0);
    for (std::size_t l = 0; l < light_on_.size(); ++l)
        if (light_on_[l])
            group_mask_[l / k_lights_per_group] |= static_cast<std::uint8_t>(3 << (2 * (l % k_lights_per_group)));
}

// Removes promoted objects from the static triangles and from the shadow memory.
void CertifiedCulling::forget_promoted()
{
    const std::vector<scene::ObjectId>& promoted = state_->changes().promoted;
    if (promoted.empty()) return;
    const std::vector<RememberedLight> lights = remembered_lights();
    for (const scene::ObjectId o : promoted) {
        if (triangles_->first_of(o) == no_triangle) continue;   // its transform was singular
        const Forgotten forgotten = forget_object(o, lights, options_.certificates, *triangles_, *memory_);
        counters_.forgotten_records += forgotten.records;
        counters_.forgotten_visited += forgotten.visited;
    }
}

std::vector<RememberedLight> CertifiedCulling::remembered_lights() const
{
    std::vector<RememberedLight> lights;
    for (std::size_t l = 0; l < light_on_.size(); ++l) {
        if (!light_on_[l]) continue;
        const scene::LightState& at = state_->light(static_cast<scene::LightId>(l));
        const bool directional = state_->scene().lights[l].type == scene::LightType::directional;
        lights.push_back({static_cast<int>(l), directional, directional ? -at.direction : at.position});
    }
    return lights;
}

RimCodes CertifiedCulling::rim_of_record(RecordId record) const
{
    const double width = options_.rim_margins * options_.certificates.shaft.margin;
    return rim_of((*triangles_)[record / 2].p, static_cast<float>(width) * triangles_->largest_coordinate());
}

// The level whose parts cover about `pixels_per_part` pixels where the triangle is nearest to the eye. Depends only on
// triangle and view, so that counts do not depend on threads.
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
    // The area of a triangle in the billions of units is infinite.
    return static_cast<std::uint32_t>(std::min<double>(std::ceil(0.5 * std::log2(parts)), k_max_level));
}

// Computes the bounds of the strip that begins at a point, and prefetches the next strip, because the points of an
// image are not in the cache.
void CertifiedCulling::Batch::find_bounds(std::size_t first)
{
    constexpr std::size_t k_line = 64;
    const std::size_t end = std::min(first + k_strip, points.size());
    const auto* const following = reinterpret_cast<const char*>(points.data() + end);
    const std::size_t bytes = (std::min(end + k_strip, points.size()) - end) * sizeof(ShadowPoint);
    for (std::size_t byte = 0; byte < bytes; byte += k_line) __builtin_prefetch(following + byte);
    strip_bounds.push_back(bounds_of(points.subspan(first, end - first)));
    bounds.add(strip_bounds.back());
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
    batch.bounds = Box3{};
    batch.strip_bounds.clear();

    // While every light moves, no states are used.
    if (!any_light_on_) {
        std::fill(at.slot.begin(), at.slot.end(), k_no_slot);
        std::fill(batch.states.begin(), batch.states.end(), 0);
        std::fill(batch.record.begin(), batch.record.end(), k_no_record);
        return;
    }

    // Find the record of every point; neighbours mostly share one.
    scene::ObjectId last_object = scene::none;
    TriangleId first = no_triangle;
    RecordId* const records = batch.record.data();
    glm::vec2* const uv = at.uv.data();
    std::size_t end = 0;   // of the strip
    for (std::size_t i = 0; i < count;) {
        if (i == end) {
            batch.find_bounds(i);
            end = std::min(i + Batch::k_strip, count);
        }
        const ShadowPoint& point = points[i];
        if (point.object != last_object) {
            last_object = point.object;
            first = triangles_->first_of(point.object);
        }
        const RecordId record =
            first == no_triangle ? k_no_record : 2 * (first + point.triangle) + (point.front ? 0 : 1);
        const std::size_t begin = i;
        if (record == k_no_record) {
            do ++i;
            while (i < end && points[i].object == point.object);
        } else {
            do {
                uv[i] = {points[i].u, points[i].v};
                ++i;
            } while (i < end && points[i].object == point.object && points[i].triangle == point.triangle &&
                     points[i].front == point.front);
        }
        std::fill(records + begin, records + i, record);
        at.runs.push_back({static_cast<std::uint32_t>(begin), k_no_slot, 0, 0, 0, 0});
        if (record == k_no_record) continue;
        ShadowMemory::Place place = memory_->place(record);
        if (place.begin == k_no_slot) {
            if (!memory_->full()) memory_->create(record, wanted_level(record / 2), rim_of_record(record));
            place = memory_->place(record);
            if (place.begin == k_no_slot) continue;
        }
        memory_->note_seen(record, frame_);
        const Rim rim = memory_->rim(record);
        at.runs.back() = {static_cast<std::uint32_t>(begin),     place.begin, rim.u, rim.v, rim.per_inner,
                          static_cast<float>(1u << place.level), place.pieces};
    }

    find_parts(at, groups > 0 ? memory_->states(0) : nullptr);
    for (std::size_t g = 0; g < groups; ++g)
        fetch_states(at, memory_->states(static_cast<int>(g)), group_mask_[g], batch.states.data() + g * batch.stride);
}

ShadowState CertifiedCulling::state_of(const Batch& batch, std::uint32_t point, int light) const
{
    const auto group = static_cast<std::size_t>(light / k_lights_per_group);
    return static_cast<ShadowState>((batch.states[group * batch.stride + point] >> (2 * (light % k_lights_per_group))) &
                                    3);
}

void CertifiedCulling::note_news(std::span<const std::unique_ptr<Batch>> batches)
{
    for (const auto& batch : batches) {
        if (!batch) continue;
        news_.insert(news_.end(), batch->touched.begin(), batch->touched.end());
        batch->touched.clear();
        counters_.add(batch->counters);
        batch->counters = {};
    }
    sort_news();
}

// Sorts the list and removes what is in it twice, with interruption points: an interruption leaves it in another order.
void CertifiedCulling::sort_news()
{
    constexpr std::size_t k_run = 1u << 14;
    const std::size_t count = news_.size();
    const auto at = [&](std::size_t i) { return news_.begin() + static_cast<std::ptrdiff_t>(std::min(i, count)); };
    for (std::size_t begin = 0; begin < count; begin += k_run) {
        interruption_point();
        std::sort(at(begin), at(begin + k_run));
    }
    for (std::size_t run = k_run; run < count; run *= 2)
        for (std::size_t begin = 0; begin + run < count; begin += 2 * run) {
            interruption_point();
            std::inplace_merge(at(begin), at(begin + run), at(begin + 2 * run));
        }
    news_.erase(std::unique(news_.begin(), news_.end()), news_.end());
}

// The number of certificates that a frame can afford: the cost of tracing every ray plus a fraction of it, minus the
// cost of the frame. In units of one ray, a look-up costs an eighth, a remaining ray a quarter more than one (packets
// are less full), and a certificate 20 to 80. The first frame, which has no results yet, may try any number.
std::uint64_t CertifiedCulling::affordable() const
{
    constexpr double k_share = 0.3, k_look_up = 0.125, k_ray = 1.25, k_certificate = 80;
    constexpr double k_least = 0.15;   // as a fraction of the rays
    if (!judged_once_) return k_no_limit;
    const auto traced = static_cast<double>(counters_.traced + counters_.dynamic_only);
    const double all = traced + static_cast<double>(counters_.skipped);
    const double left = (1 + k_share) * all - k_look_up * all - k_ray * traced;
    return static_cast<std::uint64_t>(std::max(left, k_least * all) / k_certificate) + k_always_certificates;
}

bool CertifiedCulling::judge(Tasks& tasks, const std::function<bool()>& go_on)
{
    // Judge each record in one task, which owns its pyramid. Every chunk gets an equal number of certificates, so that
    // the result does not depend on the number of threads. The first chunk changes from frame to frame, so that no
    // record is always last.
    constexpr std::size_t k_chunk = 64;
    const std::size_t count = news_.size(), chunks = (count + k_chunk - 1) / k_chunk;
    const std::size_t shift = count > 0 ? frame_ * 37 % count : 0;
    const std::uint64_t share = go_on || chunks == 0 ? k_no_limit : std::max<std::uint64_t>(1, affordable() / chunks);
    std::vector<char> judged(count, 0);
    std::vector<std::unique_ptr<Judge>> judges(static_cast<std::size_t>(tasks.threads()));
    // Where the work is interrupted, the rest waits as well: what was judged is kept.
    Interruption* const interruption = Interruption::current();
    const InterruptionScope whole(nullptr);
    std::atomic<bool> stopped = false;
    const auto stops = [&] {
        if (!stopped && ((go_on && !go_on()) || (interruption && interruption->requested()))) stopped = true;
        return stopped.load();
    };
    tasks.for_each(chunks, [&](std::size_t chunk, int worker) {
        if (stops()) return;
        auto& judge = judges[static_cast<std::size_t>(worker)];
        if (!judge) judge = std::make_unique<Judge>(*state_, *triangles_, *memory_, light_on_, options_);
        judge->allow(share);
        judge->stop_with(interruption);
        const std::size_t end = std::min(count, (chunk + 1) * k_chunk);
        for (std::size_t i = chunk * k_chunk; i < end && judge->allowed() && !stops(); ++i) {
            const std::size_t r = (i + shift) % count;
            if (memory_->has(news_[r])) judge->judge(news_[r]);   // it may have been dropped meanwhile
            judged[r] = 1;
        }
    });
    for (const auto& judge : judges)
        if (judge) counters_.add(judge->counters());

    // For the next frame, deepen records that are PARTIAL and cover many pixels. Keep those that were not judged.
    std::vector<RecordId> left;
    for (std::size_t r = 0; r < news_.size(); ++r) {
        const RecordId record = news_[r];
        if (!judged[r]) {
            left.push_back(record);
            continue;
        }
        if (!memory_->has(record)) continue;
        const std::uint32_t wanted = wanted_level(record / 2);
        if (wanted > memory_->level(record)) memory_->deepen(record, wanted);
    }
    judged_once_ = judged_once_ || count > 0;
    news_ = std::move(left);
    if (memory_->full()) memory_->drop_unseen(frame_);
    if (interruption && interruption->requested()) interruption->raise();
    return news_.empty();
}

std::size_t CertifiedCulling::bytes() const
{
    return memory_->bytes();
}

std::size_t CertifiedCulling::most_evidence_bytes() const
{
    return memory_->most_evidence_bytes();
}

std::size_t CertifiedCulling::mask_bytes() const
{
    return mask_->bytes();
}

}   // namespace gnomon::shadow_culling
