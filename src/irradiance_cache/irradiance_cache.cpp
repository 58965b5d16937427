// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/irradiance_cache.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <unordered_map>

#include "base/check.h"
#include "base/interruption.h"
#include "irradiance_cache/near_field/near_evaluator.h"
#include "irradiance_cache/near_field/near_step.h"
#include "irradiance_cache/points/collector.h"
#include "irradiance_cache/points/cpu_evaluator.h"
#include "irradiance_cache/points/device_evaluator.h"
#include "irradiance_cache/points/interpolator.h"
#include "irradiance_cache/points/placement.h"
#include "irradiance_cache/points/sparse_pixels.h"

namespace gnomon::irradiance_cache {

struct IrradianceCache::Batch::Scratch {
    explicit Scratch(PointTable& table) : claims(table) {}
    PointClaims claims;
    SparsePixels pixels;
    BatchWork work;
    PointCollector collector;
    PointPlacer placer;
    EvaluationScratch evaluation;
    NearEvaluator near_evaluation;
    Interpolator interpolator;
    NearFieldStep near_field;
    BatchRecorder recorder;
    // Of a remembered batch: the surface points that are computed anew.
    std::vector<std::uint32_t> rest;
    std::vector<glm::vec3> rest_irradiance;
    std::vector<glm::vec4> near_known;   // of its surface points
    std::vector<float> near_share;
    NearBlend near_blend;
    // If rays are limited: of the claimed points, new ones and those on moving objects; and what arrives at some
    // pixels.
    std::vector<CachePoint*> fresh, moved;
    std::vector<RoughLight::Sample> light_samples;
};

namespace {

constexpr std::chrono::milliseconds k_grace{80};   // for an update that is asked to stop

std::uint64_t next_number()
{
    static std::atomic<std::uint64_t> last = 0;
    return ++last;
}

}   // namespace

IrradianceCache::Batch::Batch(PointTable& table) : scratch_(std::make_unique<Scratch>(table)) {}
IrradianceCache::Batch::~Batch() = default;

IrradianceCache::IrradianceCache(const scene::SceneState& state, const ray::RayScene& rays, const CacheOptions& options,
                                 Tasks& tasks)
    : options_(options),
      lights_(state, rays, options.light_tree, tasks),
      sky_(state.scene().background, k_sky_directions, options.sky_parts),
      sky_of_parts_(state.scene().background, options.sky_of_parts, options.sky_parts),
      casters_(state),
      triangles_(state.scene()),
      near_field_(options_),
      rough_(rays.bounds()),
      frame_{.options = options_,
             .lights = lights_,
             .dynamic_bounds = dynamic_bounds_,
             .sky = sky_,
             .sky_of_parts = sky_of_parts_,
             .triangles = triangles_,
             .clusters = clusters_,
             .near_field = near_field_,
             .budget = budget_,
             .rough = rough_,
             .state = &state,
             .rays = &rays},
      evaluator_(std::make_unique<CpuEvaluator>(table_)),
      static_results_(next_number())
{
    find_dynamic_groups();
}

IrradianceCache::~IrradianceCache() = default;

void IrradianceCache::use_device(std::unique_ptr<PointDevice> device)
{
    GNOMON_CHECK(frame_.number == 0);
    evaluator_ = std::make_unique<DeviceEvaluator>(table_, std::move(device));
    evaluates_on_device_ = true;
}

std::unique_ptr<IrradianceCache::Batch> IrradianceCache::make_batch()
{
    return std::unique_ptr<Batch>(new Batch(table_));
}

void IrradianceCache::update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    updating_ = true;
    frame_.state = &state;
    frame_.rays = &rays;
    counters_ = {};
    budget_.begin_frame();
    if (failure_.any()) near_field_.forget_hints();   // some will never be answered
    failure_.clear();
    const bool first = frame_.number++ == 0;
    const scene::FrameChanges& changes = state.changes();
    // An update that stops half-way discards everything, which takes much longer to make again.
    std::optional<InterruptionGrace> grace;
    if (!first) grace.emplace(k_grace);
    // Follow the lights.
    if (!first) {
        casters_.update(state);
        lights_.update(state, rays, tasks);
    }
    // Follow the geometry.
    const bool promoted = !changes.promoted.empty();
    if (promoted) drop_static_results();
    if (!changes.added.empty() || !changes.removed.empty()) {
        triangles_.follow(state.scene());
        find_dynamic_groups();
    }
    const bool thins_otherwise = !changes.materials_changed.empty() && rays.thins_light();
    if (thins_otherwise) find_dynamic_groups();
    if (first || lights_.geometry_changed()) near_field_.update(lights_);
    if (lights_.geometry_changed() || promoted || thins_otherwise || !changes.added.empty() ||
        !changes.removed.empty() || !changes.separated.empty())
        static_results_ = next_number();
    if (first || thins_otherwise || !changes.changed.empty()) follow_dynamic_objects(first || thins_otherwise);
    evaluator_->begin_frame(frame_);
    if (budget_.limited() && rough_.empty()) begin_rough_light();
    updating_ = false;
}

// Begins with what the patches receive, if there are any: by and by, pixels tell more exactly.
void IrradianceCache::begin_rough_light()
{
    const PatchLight* const light = lights_.patch_light();
    if (!light) return;
    std::vector<RoughLight::Sample> samples;
    const std::span<const patches::Patch> patches = light->patches().patches();
    const std::vector<glm::vec3> arrives = light->rough_irradiance();
    for (std::size_t p = 0; p < patches.size(); ++p)
        if (arrives[p].x >= 0) samples.push_back({patches[p].position, patches[p].normal, arrives[p], patches[p].area});
    rough_.note(samples);
}

// A static object became dynamic: what points saw past it, and where they lie, is void.
void IrradianceCache::drop_static_results()
{
    find_dynamic_groups();
    table_.clear([this](const CachePoint& point) { evaluator_->release(point); });
    near_field_.drop_hints();
}

// Whether an object occludes light, or thins it.
bool IrradianceCache::takes_light(scene::ObjectId object) const
{
    if (casters_.casts(object)) return true;
    const scene::Scene& scene = frame_.state->scene();
    const std::vector<scene::MeshPart>& parts = scene.meshes[scene.objects[object].mesh].parts;
    return std::any_of(parts.begin(), parts.end(),
                       [&](const scene::MeshPart& part) { return scene::thins_light(scene.materials[part.material]); });
}

// Groups the dynamic objects that occlude or thin light by what moves together.
void IrradianceCache::find_dynamic_groups()
{
    const scene::SceneState& state = *frame_.state;
    dynamic_groups_.clear();
    std::unordered_map<std::uint32_t, std::size_t> group_of_owner;
    for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
        if (!state.is_dynamic(o) || state.scene().objects[o].removed || !takes_light(o)) continue;
        const std::uint32_t owner = lights_.owner_of(o);
        const auto [at, first] = group_of_owner.try_emplace(owner, dynamic_groups_.size());
        if (first) dynamic_groups_.emplace_back();
        dynamic_groups_[at->second].push_back(o);
    }
}

MovingSpheres::Object IrradianceCache::enclosed(scene::ObjectId object) const
{
    const Box3& box = casters_.box(object);
    const glm::mat4 m = frame_.state->object_matrix(object);
    Box3 world;
    for (int corner = 0; corner < 8; ++corner)
        world.add(transform_point(m, glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                               corner & 4 ? box.high.z : box.low.z)));
    const Sphere sphere{world.centre(), 0.5f * world.diagonal() * k_grown};
    return {sphere, MovingBox::around(box, m, sphere)};
}

// Encloses the visible dynamic objects in spheres and boxes.
void IrradianceCache::enclose_dynamic_objects()
{
    const scene::SceneState& state = *frame_.state;
    dynamic_bounds_.clear();
    sphere_of_.assign(state.scene().objects.size(), scene::none);
    for (const std::vector<scene::ObjectId>& group : dynamic_groups_) {
        std::vector<MovingSpheres::Object> objects;
        for (const scene::ObjectId o : group)
            if (state.object_visible(o) && !casters_.box(o).empty()) objects.push_back(enclosed(o));
        if (group.size() == 1 && !objects.empty())
            sphere_of_[group.front()] = static_cast<std::uint32_t>(dynamic_bounds_.nodes().size());
        dynamic_bounds_.add(std::move(objects));
    }
}

// Moves the spheres of objects that moved alone. Encloses all objects anew where the hierarchy may differ.
void IrradianceCache::follow_dynamic_objects(bool first)
{
    ++frame_.dynamic_version;
    const scene::FrameChanges& changes = frame_.state->changes();
    const bool only_moved = !first && changes.promoted.empty() && changes.separated.empty() && changes.added.empty() &&
                            changes.removed.empty() && changes.deformed.empty() && changes.appeared.empty() &&
                            changes.vanished.empty();
    const bool alone = std::all_of(changes.moved.begin(), changes.moved.end(), [&](scene::ObjectId o) {
        return !takes_light(o) || (only_moved && sphere_of_[o] != scene::none);
    });
    if (!only_moved || !alone) return enclose_dynamic_objects();
    for (const scene::ObjectId o : changes.moved)
        if (takes_light(o)) dynamic_bounds_.move(sphere_of_[o], enclosed(o));
}

// Lets all threads fail if one does.
template <class Body>
bool IrradianceCache::failing_together(Batch::Scratch& own, const Body& body)
{
    try {
        return body();
    } catch (...) {
        // Wake the threads that wait for this one: they fail as it did.
        failure_.record(std::current_exception());
        own.claims.abandon();
        if (NearHints* const hints = near_field_.hints()) hints->abandon();
        throw;
    }
}

bool IrradianceCache::shade(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance,
                            float* form_factors)
{
    Batch::Scratch& own = *batch.scratch_;
    return failing_together(own, [&] { return shade_points(own, points, irradiance, form_factors); });
}

void IrradianceCache::shade_and_remember(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance,
                                         std::unique_ptr<RememberedBatch>& remembered)
{
    Batch::Scratch& own = *batch.scratch_;
    remembered.reset();
    failing_together(own, [&] {
        if (!can_remember() || points.size() > RememberedBatch::k_most_points)
            return shade_points(own, points, irradiance, nullptr);
        own.recorder.begin();
        GNOMON_CHECK(shade_points(own, points, irradiance, nullptr, &own.recorder));
        remembered = own.recorder.finish(points, own.pixels);
        remembered->frame = frame_.number, remembered->static_results = static_results_;
        return true;
    });
}

bool IrradianceCache::shade_again(Batch& batch, RememberedBatch& remembered, glm::vec3* irradiance)
{
    // The table may have dropped cache points that the last frame did not use.
    if (!can_remember() || remembered.static_results != static_results_ || remembered.frame + 1 != frame_.number ||
        !remembered.same_are_covered(frame_))
        return false;
    Batch::Scratch& own = *batch.scratch_;
    failing_together(own, [&] { return shade_remembered(own, remembered, irradiance), true; });
    remembered.frame = frame_.number;
    return true;
}

// Begins a batch.
// @return  whether some pixel is narrow enough for a near field
bool IrradianceCache::begin_points(Batch::Scratch& own, std::span<const IndirectPoint> points) const
{
    BatchWork& work = own.work;
    bool near_field = false;
    work.dynamic.resize(points.size());
    work.form_factor.assign(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        work.dynamic[i] = frame_.state->is_dynamic(points[i].object) || !(points[i].width > 0);
        near_field = near_field || (!work.dynamic[i] && points[i].width < 2 * near_field_.fade_width());
    }
    return near_field;
}

// @param recorder  optional: takes note of what does not depend on the light
bool IrradianceCache::shade_points(Batch::Scratch& own, std::span<const IndirectPoint> points, glm::vec3* irradiance,
                                   float* form_factors, BatchRecorder* recorder)
{
    // Choose the pixels to compute; the others are interpolated between them on the screen.
    BatchWork& work = own.work;
    const bool near_field = begin_points(own, points);
    own.pixels.choose(points, work.dynamic);
    if (!compute_points(own, points, own.pixels.computed(), irradiance, recorder)) return false;

    // Interpolate on the screen.
    own.pixels.fill(irradiance);
    if (form_factors) {
        own.pixels.fill(work.form_factor.data());
        std::ranges::copy(work.form_factor, form_factors);
    }
    if (near_field && near_field_.hints()) {
        own.pixels.fill(work.near_weight.data());
        own.pixels.fill(work.near_known.data());
        own.pixels.fill(work.near_share.data());
        if (own.near_field.select(frame_, points, work, failure_, own.evaluation.counters)) {
            add_near_field(own, points, irradiance);
            for (const NearFieldStep::Selected& near : own.near_field.selected())
                if (recorder) recorder->add_near(near.point, near.weight, near.known, near.part);
        }
    }
    if (budget_.limited()) note_light(own, points, irradiance);
    return true;
}

// Computes the irradiance of the chosen surface points by interpolation between cache points.
// @return  false if cache points wait for a device
bool IrradianceCache::compute_points(Batch::Scratch& own, std::span<const IndirectPoint> points,
                                     std::span<const std::uint32_t> chosen, glm::vec3* irradiance,
                                     BatchRecorder* recorder)
{
    BatchWork& work = own.work;
    for (const std::uint32_t i : chosen) irradiance[i] = glm::vec3(0);
    own.collector.begin(frame_, points, chosen, work);

    // Interpolate lattice points, from coarse to fine levels, as far as each pixel needs.
    while (!work.lattice.empty()) {
        own.collector.collect_cells(frame_, points, own.claims, work);
        evaluate_claimed(own);
        own.interpolator.blend_level(frame_, points, work, irradiance, own.evaluation.counters, recorder);
    }
    if (recorder) recorder->add_rest(work.parts);

    // Interpolate parts of triangles where no lattice point applies; and, where those are dark, parts around the pixel.
    own.collector.select_parts(frame_, points, work);
    CacheCounters& counters = own.evaluation.counters;
    for (const PartsAre are : {PartsAre::far, PartsAre::finer, PartsAre::own, PartsAre::closest}) {
        if (work.parts.empty()) break;
        own.collector.collect_parts(frame_, own.claims, work);
        evaluate_claimed(own);
        own.interpolator.blend_parts(frame_, points, are, work, irradiance, counters);
    }
    if (work.queued) return false;
    if (near_field_.hints() && own.near_field.select_of_parts(work)) add_near_field(own, points, irradiance);
    return true;
}

// Sums the present light of the cache points that a batch remembers, in the order of shade_points().
void IrradianceCache::shade_remembered(Batch::Scratch& own, const RememberedBatch& remembered, glm::vec3* irradiance)
{
    // Evaluate the cache points.
    own.claims.begin(frame_.number);
    for (CachePoint* const point : remembered.cached) own.claims.find(*point);
    evaluate_claimed(own);

    std::fill(irradiance, irradiance + remembered.count, glm::vec3(0));
    own.near_known.assign(remembered.count, glm::vec4(0));
    own.near_share.assign(remembered.count, 0);
    remembered.add_lattice(irradiance, own.near_known.data(), own.near_share.data());
    // Compute the others anew.
    if (const std::size_t count = remembered.rest.size(); count > 0) {
        own.rest.resize(count), own.rest_irradiance.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) own.rest[i] = i;
        begin_points(own, remembered.rest_points);
        compute_points(own, remembered.rest_points, own.rest, own.rest_irradiance.data(), nullptr);
        for (std::size_t i = 0; i < count; ++i) {
            irradiance[remembered.rest[i]] = own.rest_irradiance[i];
            own.near_known[remembered.rest[i]] = own.work.near_known[i];
            own.near_share[remembered.rest[i]] = own.work.near_share[i];
        }
    }
    remembered.pixels.fill(irradiance);
    if (remembered.near.empty()) return;
    remembered.pixels.fill(own.near_known.data());
    remembered.pixels.fill(own.near_share.data());
    remembered.add_near(own.near_known.data(), own.near_share.data(), own.near_blend, irradiance);
}

// Notes what arrives at some of the computed pixels that lack nothing, for pixels that lack points.
void IrradianceCache::note_light(Batch::Scratch& own, std::span<const IndirectPoint> points,
                                 const glm::vec3* irradiance)
{
    constexpr std::size_t k_samples = 64;   // of a batch
    const std::span<const std::uint32_t> computed = own.pixels.computed();
    const std::size_t step = std::max<std::size_t>(computed.size() / k_samples, 1);
    for (std::size_t c = 0; c < computed.size(); c += step) {
        const std::uint32_t i = computed[c];
        if (own.work.dynamic[i] || own.work.deferred[i]) continue;
        own.light_samples.push_back({points[i].position, points[i].normal, irradiance[i]});
    }
}

// Adds the selected light from surfaces so near that the light tree cannot tell them apart.
void IrradianceCache::add_near_field(Batch::Scratch& own, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    own.near_field.collect(frame_, own.claims);
    evaluate_claimed(own);
    if (own.near_field.replace_hidden(frame_, points, own.evaluation.counters)) {
        own.near_field.collect(frame_, own.claims);
        evaluate_claimed(own);
    }
    own.near_field.blend(points, own.work, irradiance);
}

// Brings all claimed points up to this frame, and waits for those that other threads claimed.
void IrradianceCache::evaluate_claimed(Batch::Scratch& own)
{
    if (!own.claims.claimed().empty()) {
        CacheCounters& counters = own.evaluation.counters;
        const auto rays = [&] { return counters.rays + own.evaluation.expected_rays; };
        const std::uint64_t before = rays();
        const std::size_t granted = budget_.limited() ? defer_points(own) : 0;
        own.placer.place(frame_, own.claims.claimed());
        table_.grew(own.near_evaluation.evaluate(frame_, own.claims.claimed(), counters));
        evaluator_->evaluate(frame_, own.claims.claimed(), own.evaluation);
        own.claims.publish();
        if (budget_.limited()) budget_.settle(granted, rays() - before);
    }
    own.claims.wait(failure_);
}

// Leaves points to a later frame that this one has no rays for: new ones, and those on dynamic objects, which keep the
// light of the frame that evaluated them last.
// @return  how many of them are left of the claimed ones
std::size_t IrradianceCache::defer_points(Batch::Scratch& own)
{
    const std::uint32_t version = lights_.geometry_version();
    std::vector<CachePoint*>&fresh = own.fresh, &moved = own.moved;
    fresh.clear(), moved.clear();
    for (CachePoint* point : own.claims.claimed()) {
        const bool known = point->version != 0 && point->owner != k_no_owner;
        if (known && point->dynamic_version != frame_.dynamic_version)
            moved.push_back(point);
        else if (point->version != version)
            fresh.push_back(point);
    }
    const std::size_t wanted = fresh.size() + moved.size(), granted = budget_.grant(wanted);
    if (granted == wanted) return granted;
    // Keep new points in the order of the pixels that ask for them, and of the others those whose light is oldest.
    constexpr std::size_t k_share_of_moved = 4;
    const std::size_t others = granted - std::min(fresh.size(), granted);
    const std::size_t kept_moved = std::min(moved.size(), std::max(others, granted / k_share_of_moved));
    const std::size_t kept_fresh = std::min(fresh.size(), granted - kept_moved);
    std::ranges::nth_element(moved, moved.begin() + static_cast<std::ptrdiff_t>(kept_moved), {},
                             [](const CachePoint* point) { return point->dynamic_version; });
    std::vector<CachePoint*>& deferred = moved;
    deferred.erase(moved.begin(), moved.begin() + static_cast<std::ptrdiff_t>(kept_moved));
    deferred.insert(deferred.end(), fresh.begin() + static_cast<std::ptrdiff_t>(kept_fresh), fresh.end());
    std::ranges::sort(deferred);
    own.claims.defer_if([&](CachePoint& point) { return std::ranges::binary_search(deferred, &point); });
    return kept_fresh + kept_moved;
}

void IrradianceCache::for_each(std::size_t count, std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks,
                               const std::function<bool(std::size_t index, int worker)>& body)
{
    std::vector<std::size_t> open(count);
    for (std::size_t i = 0; i < count; ++i) open[i] = i;
    std::vector<EvaluationScratch*> scratch;
    for (const auto& batch : batches) scratch.push_back(&batch->scratch_->evaluation);
    while (!open.empty()) {
        std::vector<std::uint8_t> done(open.size());
        tasks.for_each(open.size(), [&](std::size_t k, int worker) { done[k] = body(open[k], worker) ? 1 : 0; });
        std::size_t left = 0;
        for (std::size_t k = 0; k < open.size(); ++k)
            if (!done[k]) open[left++] = open[k];
        open.resize(left);
        if (left > 0) evaluator_->evaluate_queued(frame_, scratch, tasks);
    }
}

void IrradianceCache::end_frame(std::span<const std::unique_ptr<Batch>> batches)
{
    for (const auto& batch : batches) {
        if (!batch) continue;
        Batch::Scratch& own = *batch->scratch_;
        counters_.add(own.evaluation.counters);
        own.evaluation.counters = {};
        rough_.note(own.light_samples);
        own.light_samples.clear();
        own.claims.end_frame();
    }
    if (NearHints* const hints = near_field_.hints(); hints && !failure_.any()) hints->end_frame();
    // A viewer's images in motion ask for few points: keep those of the view at rest, to which it returns.
    constexpr std::size_t k_limited_memory = 256u << 20;
    const std::size_t memory = budget_.limited() ? std::max(options_.memory, k_limited_memory) : options_.memory;
    table_.drop_unseen(frame_.number, {memory, options_.ample_memory},
                       [this](const CachePoint& point) { evaluator_->release(point); });
}

bool IrradianceCache::abandon_frame()
{
    if (updating_) return false;
    end_frame({});
    return true;
}

std::size_t IrradianceCache::bytes() const
{
    return lights_.bytes() + table_.bytes() + clusters_.bytes() + near_field_.bytes() + evaluator_->bytes() +
           rough_.bytes();
}

}   // namespace gnomon::irradiance_cache
