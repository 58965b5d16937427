// SPDX-License-Identifier: Apache-2.0
// LONG: the one place that makes, keeps and discards techniques; each needs to know of all others.
#include "frame/frame_engine.h"

#include <algorithm>
#include <chrono>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "base/interruption.h"
#include "base/stopwatch.h"
#include "frame/cluster_overlay.h"
#include "frame/reference_indirect.h"
#include "frame/state_overlay.h"
#include "image/changed_rectangles.h"
#include "image/pixel_filter.h"
#include "ray/kdtree/kdtree.h"
#include "scene/continuation.h"
#include "shading/surface.h"
#include "trace/centre_layers.h"
#include "trace/checked_shadows.h"
#include "trace/checked_sized.h"
#include "trace/indirect_lights.h"
#include "trace/shadow_testers.h"
#include "trace/traced_frame.h"

namespace gnomon::frame {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Discards everything when a call fails halfway, for example for want of memory.
class DiscardOnFailure {
 public:
    explicit DiscardOnFailure(FrameEngine& engine) : engine_(engine) {}
    ~DiscardOnFailure()
    {
        if (!succeeded_) engine_.forget();
    }
    DiscardOnFailure(const DiscardOnFailure&) = delete;
    DiscardOnFailure& operator=(const DiscardOnFailure&) = delete;
    void succeed() { succeeded_ = true; }

 private:
    FrameEngine& engine_;
    bool succeeded_ = false;
};

irradiance_cache::CacheOptions cache_options(const RenderOptions& options)
{
    auto result = irradiance_cache::options_for_bounces(options.bounces, options.renderer == RenderMethod::trace);
    result.memory = static_cast<std::size_t>(options.indirect_memory) << 20;
    if (options.memory > 0) result.ample_memory = 0;   // leave it to what cannot do without
    return result;
}

light_quadtree::MapLightOptions map_options(const RenderOptions& options)
{
    light_quadtree::MapLightOptions result;
    result.method =
        options.indirect == Indirect::rsm ? light_quadtree::MapMethod::rsm : light_quadtree::MapMethod::quadtree;
    result.levels.limit = options.indirect_level;
    result.map.validity = {static_cast<float>(options.depth_threshold), static_cast<float>(options.normal_threshold),
                           static_cast<float>(options.validity_margin)};
    result.map.separate_trees = options.separate_trees;
    result.shadows = options.cluster_shadows;
    result.rsm.samples = options.rsm_samples;
    if (options.indirect_at_every_pixel) result.grid = 0;
    return result;
}

// The options that a technique is made with: while they stay, so does the technique.
auto cache_key(const RenderOptions& o)
{
    return std::tuple(o.indirect_memory, o.bounces, o.memory > 0);
}

auto map_key(const RenderOptions& o)
{
    return std::tuple(o.indirect, o.rsm_samples, o.indirect_level, o.depth_threshold, o.normal_threshold,
                      o.validity_margin, o.separate_trees, o.cluster_shadows, o.indirect_at_every_pixel);
}

auto raster_key(const RenderOptions& o)
{
    return std::tuple(o.samples, o.layers, o.shadow_textures, o.shadow_filter, o.sun_size, o.as_printed, o.overlay,
                      o.indirect_on, o.background == BackgroundKind::environment, cache_key(o), map_key(o));
}

// Bytes of the buffers of a frame.
std::size_t buffer_bytes(Size size, const RenderOptions& options, bool estimate, std::size_t lights)
{
    // Adaptive samples: what centres met, and sums of colour, alpha and weights with the borders of tiles.
    const std::size_t adaptive =
        options.samples == k_adaptive_samples ? sizeof(shading::CentreSample) / sizeof(float) + 7 : 0;
    const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    // Colour; three estimates; four layers of 3, depth and shadows; ids and motion.
    const std::size_t floats = 3 + adaptive + (estimate ? 9 : 0) + (options.layers ? 13 + lights : 0) +
                               (options.ids ? 2 : 0) + (options.motion ? 2 : 0);
    return pixels * floats * sizeof(float);
}

}   // namespace

FrameEngine::FrameEngine(const EngineSettings& settings) : settings_(settings), tasks_(settings.threads) {}

FrameEngine::~FrameEngine() = default;

void FrameEngine::use_threads(int threads)
{
    raster_.reset();   // it has memory for each thread
    tasks_ = Tasks(threads);
}

void FrameEngine::discard_caches()
{
    discard_light();
    discard_followers();
}

void FrameEngine::discard_light()
{
    proven_.reset();
    environment_.reset();
}

void FrameEngine::discard_followers()
{
    certified_.reset();
    nah_.reset();
    cache_.reset();
    map_.reset();
    raster_.reset();
}

void FrameEngine::forget()
{
    discard_caches();
    rays_.reset();
    sized_.forget();
    state_.reset();
    state_before_.reset();
    scene_.reset();
    buffers_.reset();
    memory_ = {};
    buffers_ = memory_.take();
    scratch_.forget();
    turn_centre_.reset();
    shown_bounds_.forget();
    first_frame_ = true;
    advanced_ = false;
    has_frame_ = false;
    made_.reset();
    traced_.reset();
    plan_ = {};
}

FrameEngine::Plan FrameEngine::plan_for(const RenderOptions& o) const
{
    const bool has_lights = !scene_->lights.empty();
    const auto has_emitters = [&] { return !sized_panels(*scene_).titles.empty(); };
    Plan plan;
    plan.raster = o.renderer == RenderMethod::raster;
    if (plan.raster) {
        plan.raster_indirect = o.indirect != Indirect::off;
        if (o.overlay == Overlay::redrawn && o.shadow_textures != ShadowTextures::off && (has_lights || has_emitters()))
            plan.shown = Shown::redrawn;
        return plan;
    }
    if (o.overlay == Overlay::shadow_states && o.shadow_culling != ShadowCulling::off && (has_lights || has_emitters()))
        plan.shown = Shown::shadow_states;
    if (o.overlay == Overlay::clusters && o.indirect == Indirect::quadtree && !o.reference)
        plan.shown = Shown::clusters;

    if (plan.shown != Shown::clusters) {
        plan.nah = o.shadow_culling == ShadowCulling::paper;
        plan.certified = o.shadow_culling == ShadowCulling::certified && has_lights && !o.reference &&
                         (settings_.culls_first_frame || !first_frame_);
    }
    if (plan.shown == Shown::shadow_states) return plan;
    plan.reference = o.reference.has_value();
    plan.cache = o.indirect == Indirect::visible && !o.reference;
    plan.map = (o.indirect == Indirect::rsm || o.indirect == Indirect::quadtree) && !o.reference;
    return plan;
}

AdvanceTimes FrameEngine::advance(const std::shared_ptr<const scene::Scene>& scene, double time,
                                  const RenderOptions& options, const HostValues* host)
{
    // Stop before anything moves, if at all: caches that miss a movement are discarded.
    interruption_point();
    DiscardOnFailure guard(*this);
    limit_ = MemoryLimit(static_cast<std::size_t>(options.memory) << 20);
    AdvanceTimes times;
    Clock::time_point start = Clock::now();

    // Move the scene.
    const bool needs_rays = options.renderer == RenderMethod::trace || options.indirect == Indirect::visible ||
                            options.ids || options.motion || settings_.always_has_rays ||
                            raster_needs_rays(*scene, options);
    const bool rays_are_traced = options.renderer == RenderMethod::trace || settings_.always_has_rays;
    const Accelerator accelerator = rays_are_traced ? options.accelerator : Accelerator::embree;
    const bool same_rays = accelerator == accelerator_ && options.arithmetic == arithmetic_;
    const bool continues = host && state_ && scene != scene_ && same_rays && continue_with(scene);
    const bool is_new = !continues && (scene != scene_ || !same_rays);
    times.anew = is_new;
    if (is_new) {
        forget();
        scene_ = scene;
        accelerator_ = accelerator;
        arithmetic_ = options.arithmetic;
        state_ = std::make_unique<scene::SceneState>(scene, time);
    }
    follows_frame_ = has_frame_;
    has_frame_ = false;
    if (!options.motion) state_before_.reset();
    bool rays_follow = false;   // they saw the state before an advance
    if (host) continues ? host->replace_all(*state_) : is_new ? host->apply_all(*state_) : host->apply_changes(*state_);
    if (host || !is_new) {
        state_->advance(time);
        rays_follow = rays_ != nullptr;
    }
    if (needs_rays && !rays_) make_rays();
    times.scene = milliseconds_since(start);
    start = Clock::now();

    // Let the rest follow. A cache that did not see the last advance cannot.
    if (rays_follow) {
        // Follow whole, unless large trees are built: an interruption would discard everything.
        const bool rebuilds = !state_->changes().promoted.empty() || adds_much();
        const InterruptionScope scope(rebuilds ? Interruption::current() : nullptr);
        rays_->limit_memory(limit_);
        rays_->update(*state_);
    }
    // What follows in frames alone has missed nothing where nothing changed.
    if (advanced_) discard_followers();
    if (advanced_ && !advanced_still_) discard_light();
    advanced_ = true;
    advanced_still_ = state_->changes().is_still();
    options_ = options;
    plan_ = plan_for(options);
    try {
        follow_emission();
        fit_caches(options);
        check_memory("the caches");
    } catch (const InterruptedError&) {
        // A cache may have missed one of the shutter's times.
        if (posed_) discard_caches();
        guard.succeed();   // scene and rays are as they should be; the next call replaces the caches
        throw;
    }
    first_frame_ = false;
    times.caches = milliseconds_since(start);
    guard.succeed();
    return times;
}

// Takes over a scene that differs in dynamic objects alone, without those caches that cannot follow.
// @return  false if more differs: then everything begins anew
bool FrameEngine::continue_with(const std::shared_ptr<const scene::Scene>& scene)
{
    if (accelerator_ != Accelerator::embree) return false;
    const std::optional<scene::Continuation> next = scene::continuation(*state_->base(), *scene);
    if (!next) return false;
    state_->continue_with(*next);
    if (state_before_) state_before_->continue_with(*next), before_lags_ = true;
    scene_ = scene;
    turn_centre_.reset();
    shown_bounds_.forget();
    nah_.reset();
    map_.reset();
    raster_.reset();
    if (next->other_environment) cache_.reset();   // its surfaces were lit by the image
    return true;
}

// Whether the objects that were added have so many triangles that their trees take longer than a frame may be
// cancelled in.
bool FrameEngine::adds_much() const
{
    constexpr std::size_t k_much = 1u << 18;
    std::size_t triangles = 0;
    for (const scene::ObjectId o : state_->changes().added)
        triangles += state_->scene().meshes[state_->scene().objects[o].mesh].triangles.size();
    return triangles >= k_much;
}

// Lets the lights with size follow. A rasterised frame has none: they are then made anew for the next traced one.
void FrameEngine::follow_emission()
{
    if (plan_.raster)
        sized_.forget();
    else
        sized_.update(*state_);
}

void FrameEngine::make_rays()
{
    rays_ = std::make_unique<ray::RayScene>(*state_, limit_, arithmetic_, &tasks_);
    if (accelerator_ == Accelerator::kdtree) rays_->trace_on_kdtree(*state_);
}

void FrameEngine::fit_caches(const RenderOptions& options)
{
    // Discard what the plan lacks, or what other options made. An irradiance cache outlives the overlay of shadow
    // states.
    if (!plan_.raster) raster_.reset();
    if (plan_.raster) scratch_.kept.forget();
    if (!plan_.certified) certified_.reset();
    if (plan_.raster || sized_.empty()) proven_.reset();
    environment_.fit(options, uses_environment());
    if (!plan_.nah || (nah_ && nah_->options().writes_at_once != options.as_printed)) nah_.reset();
    const bool cache_waits = plan_.shown == Shown::shadow_states && options.indirect == Indirect::visible;
    if (!(plan_.cache || cache_waits) || cache_key(options) != cache_key(cache_options_)) cache_.reset();
    if (!plan_.map || map_key(options) != map_key(map_options_)) map_.reset();

    // Make what is missing.
    if (plan_.raster) fit_rasterizer(options);
    if (plan_.nah && !nah_) {
        using shadow_culling::PaperOptions;
        nah_ = std::make_unique<shadow_culling::PaperCulling>(
            *state_, *rays_, options.as_printed ? PaperOptions::as_printed() : PaperOptions{});
    }
    if (plan_.map && !map_) {
        map_ = std::make_unique<light_quadtree::MapLight>(*state_, *rays_, map_options(options), tasks_);
        map_options_ = options;
    }
    if (plan_.certified && !certified_) {
        // Its memory may be small: that changes the cost of frames alone.
        shadow_culling::CertifiedOptions certified;
        const std::size_t held = held_bytes();
        if (limit_.bytes() > held) certified.memory = std::min(certified.memory, (limit_.bytes() - held) / 2);
        certified_ = std::make_unique<shadow_culling::CertifiedCulling>(*state_, *rays_, certified);
    }
    if (plan_.cache && !cache_) {
        cache_ = std::make_unique<irradiance_cache::IrradianceCache>(*state_, *rays_, cache_options(options), tasks_);
        cache_options_ = options;
    }
}

void FrameEngine::fit_rasterizer(const RenderOptions& options)
{
    if (raster_ && raster_key(options) == raster_key(raster_options_) && raster_rays_ == rays_.get()) {
        raster_->update(*state_);
        return;
    }
    raster_.reset();   // first, because a device may have memory for one of them alone
    raster_ = make_rasterizer(
        *state_, {.samples = std::max(options.samples, 1),
                  .layers = options.layers,
                  .shadows = options.shadow_textures,
                  .as_printed = options.as_printed,
                  .shadow_filter = static_cast<float>(options.shadow_filter),
                  .backdrop_apart = options.background != BackgroundKind::environment && plan_.shown == Shown::light,
                  .redrawn = plan_.shown == Shown::redrawn,
                  .redrawn_stays = settings_.redrawn_stays,
                  .indirect = options.indirect,
                  .map = map_options(options),
                  .visible = cache_options(options),
                  .indirect_on = options.indirect_on,
                  .image_apart = raster_has_image_apart(*scene_, options),
                  .suns_apart = raster_has_suns_apart(*scene_, options),
                  .rays = rays_.get(),
                  .tasks = &tasks_});
    raster_options_ = options;
    raster_rays_ = rays_.get();
}

scene::View FrameEngine::make_view(scene::CameraId camera, Size size, std::optional<double> turn)
{
    return view_in(*state_, camera, size, turn);
}

scene::View FrameEngine::view_in(const scene::SceneState& state, scene::CameraId camera, Size size,
                                 std::optional<double> turn)
{
    const scene::View view = scene::make_view(state, camera, size);
    if (!turn) return view;
    // Turn around one centre for the whole clip, whatever moves.
    if (!turn_centre_) turn_centre_ = scene_->bounds(scene_->timeline.start).centre();
    return scene::turned(view, *turn_centre_, *turn);
}

const scene::SceneState& FrameEngine::move_previous(double time, const HostValues* host)
{
    GNOMON_CHECK(advanced_ && options_.motion);
    // Keep the state only if it follows whole.
    std::unique_ptr<scene::SceneState> state = std::move(state_before_);
    const bool is_new = !state;
    if (is_new) state = std::make_unique<scene::SceneState>(state_->base(), time);
    if (host) before_lags_ && !is_new ? host->replace_before(*state) : host->apply_before(*state, is_new);
    before_lags_ = false;
    if (host || !is_new) state->advance(time);
    state_before_ = std::move(state);
    return *state_before_;
}

FrameCounters FrameEngine::render(const scene::View& view, const RenderRequest& request, const Progress& progress)
{
    GNOMON_CHECK(advanced_);
    advanced_ = false;
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    const bool is_image_there = is_made(view, request);
    if (is_image_there) interruption_point();   // nothing moved, so that nothing needs to be discarded
    DiscardOnFailure guard(*this);
    if (is_image_there) {
        list_changes();
        times_ = {};
        has_frame_ = true;
        guard.succeed();
        FrameCounters counters;
        counters.kept_image = true;
        return counters;
    }
    view_ = view;
    made_.reset();
    const std::optional<Made> last_traced = std::exchange(traced_, std::nullopt);
    continues_ = last_traced && is_same(*last_traced, view);
    // Keep the last image if it is compared with. Nobody else's image is overwritten.
    const std::shared_ptr<const shading::FrameBuffers> last =
        options_.report_changes && follows_frame_ && has_image_ ? buffers_ : nullptr;
    buffers_.reset();
    buffers_ = memory_.take();
    if (limit_.bytes() > 0) {
        const std::size_t others = held_bytes() - bytes_of(*buffers_) - scratch_.bytes();
        limit_.check(others + buffer_bytes(view.size, options_, plan_.reference, scene_->lights.size()),
                     "the layers of the image");
    }
    try {
        list_changes();
        const bool blurs = plan_.raster && request.shutter && can_blur();
        FrameCounters counters = blurs          ? blur_raster(view, *request.shutter)
                                 : plan_.raster ? render_raster(view)
                                                : render_traced(view, request);
        trace_centres(request);
        make_report(last.get());
        check_memory("the caches");
        has_frame_ = true;
        times_ = buffers_->times;
        if (!plan_.raster && has_image_ && !posed_ && !environment_.rough()) {
            traced_ = Made{scene_, options_, view};
            if (complete()) made_ = traced_;
        }
        guard.succeed();
        return counters;
    } catch (const InterruptedError&) {
        // Nah's culling has learned from half a frame, the rasteriser may have recorded half of one, and a light map
        // may have followed half of the changes. The overlay checks a culling that may not have followed any.
        if (cache_ && !cache_->abandon_frame()) cache_.reset();
        nah_.reset();
        map_.reset();
        if (!records_whole_) raster_.reset();
        if (plan_.shown == Shown::shadow_states) discard_caches();
        guard.succeed();
        throw;
    }
}

// Whether the image of a traced frame is the one that lies in buffers_. What learns from each frame has to see all of
// them.
bool FrameEngine::is_made(const scene::View& view, const RenderRequest& request) const
{
    if (!made_ || !options_.keep_image || !follows_frame_ || plan_.raster || plan_.shown != Shown::light || nah_)
        return false;
    if (options_.motion || request.shutter || request.log || request.tasks) return false;
    return is_same(*made_, view) && state_->changes().is_still();
}

// Whether a frame is of the same scene, options and view as an earlier one, and the state advanced once since.
bool FrameEngine::is_same(const Made& earlier, const scene::View& view) const
{
    return follows_frame_ && earlier.scene == scene_ && earlier.view == view && earlier.options == options_;
}

// @param whole  one of many images that are averaged
FrameCounters FrameEngine::render_raster(const scene::View& view, bool whole)
{
    if (uses_environment()) raster_->use_environment(*environment_.of_frame(*state_, options_, true, false));
    RasterAdaptive adaptive{.filter = image::chosen_filter(options_.filter, true), .exposure = {}};
    if (options_.exposure) adaptive.exposure = static_cast<float>(*options_.exposure);
    const bool refines =
        !whole && options_.samples == k_adaptive_samples && plan_.shown == Shown::light && !options_.as_printed;
    return raster_->render(*state_, view, *buffers_, {}, refines ? &adaptive : nullptr);
}

// Whether frames of the plan may light by an environment technique.
bool FrameEngine::uses_environment() const
{
    if (plan_.raster) return raster_has_image_apart(*scene_, options_) || raster_has_suns_apart(*scene_, options_);
    return plan_.shown == Shown::light;
}

// Fills the layers of ids and motion.
void FrameEngine::trace_centres(const RenderRequest& request)
{
    const bool has_layers = plan_.shown == Shown::light || plan_.shown == Shown::redrawn;
    if (!has_layers || !(options_.ids || options_.motion)) return;
    Stopwatch watch(buffers_->times);
    std::optional<trace::FrameBefore> before;
    if (options_.motion && request.previous_view)
        before = trace::FrameBefore{state_before_.get(), *request.previous_view};
    const trace::CentreLayers layers(*state_, *rays_, view_, before ? &*before : nullptr);
    layers.trace(options_.ids, options_.motion, request.tasks ? *request.tasks : tasks_, *buffers_);
    watch.end(FrameTimes::rays);
}

// Lists what this frame changed, as long as the state knows.
void FrameEngine::list_changes()
{
    report_ = {};
    posed_ = records_whole_ = false;
    report_.everything = !follows_frame_;
    if (follows_frame_) {
        const scene::FrameChanges& changes = state_->changes();
        std::set_difference(changes.changed.begin(), changes.changed.end(), changes.removed.begin(),
                            changes.removed.end(), std::back_inserter(report_.objects));
        std::set_union(changes.lights_moved.begin(), changes.lights_moved.end(), changes.lights_relit.begin(),
                       changes.lights_relit.end(), std::back_inserter(report_.lights));
        report_.materials = changes.materials_changed;
    }
}

void FrameEngine::make_report(const shading::FrameBuffers* before)
{
    has_image_ = plan_.shown == Shown::light;
    if (!options_.report_changes || !has_image_) return;
    static const ImageF none;
    report_.rectangles = image::changed_rectangles(before ? before->color : none, buffers_->color, tasks_);
}

FrameCounters FrameEngine::render_traced(const scene::View& view, const RenderRequest& request)
{
    // As printed, shadow culling reads what the pixels before have written: one thread, pixel by pixel.
    const bool in_scanline_order = nah_ && nah_->options().writes_at_once;
    std::optional<Tasks> one_thread;
    Tasks& tasks = in_scanline_order ? one_thread.emplace(1) : request.tasks ? *request.tasks : tasks_;
    if (plan_.shown == Shown::clusters) {
        map_->begin_frame(*state_, *rays_, tasks);
        FrameCounters counters;
        counters.indirect.clusters = map_->counters().lights;
        counters.indirect.rays = map_->map().work().cast;
        return counters;
    }

    // Choose the shadow test.
    std::optional<trace::CertifiedShadows> certified;
    std::optional<trace::NahShadows> nah;
    std::optional<trace::EveryShadowRay> every_ray;
    std::optional<trace::CheckedShadows> checked;
    trace::Techniques techniques{.scratch = &scratch_};
    if (certified_) techniques.shadows = &certified.emplace(*certified_, settings_.defers_certificates);
    if (nah_) techniques.shadows = &nah.emplace(*nah_);
    if (plan_.shown == Shown::shadow_states) {
        if (!techniques.shadows) techniques.shadows = &every_ray.emplace();
        states_.lights = request.overlay_lights;
        techniques.shadows = &checked.emplace(*techniques.shadows, states_);
        // An irradiance cache that the overlay does not show must not miss what moves meanwhile.
        if (cache_) cache_->update(*state_, *rays_, tasks);
    }

    // Choose the indirect light.
    std::optional<trace::CachedIndirect> cached;
    std::optional<trace::MapIndirect> mapped;
    std::optional<ReferenceIndirect> reference;
    if (plan_.cache) {
        cache_->limit_rays(request.indirect_ray_limit);
        techniques.indirect = &cached.emplace(*cache_, trace::CachedIndirectOptions{.bounces = options_.bounces});
    } else if (plan_.map) {
        techniques.indirect = &mapped.emplace(*map_);
    } else if (plan_.reference) {
        const auto& [spp, bounces, seed] = *options_.reference;
        // A background of one colour is seen, and lights nothing.
        const bool surroundings = scene_->background.kind != scene::Background::Kind::color;
        techniques.indirect = &reference.emplace(
            reference::ReferenceOptions{spp, bounces, seed, surroundings, true, true, options_.sun_size * k_pi / 180},
            std::max(options_.samples, 1));
    }

    // The reference samples emissive surfaces by itself.
    std::optional<trace::CheckedSized> checked_sized;
    const bool states = plan_.shown == Shown::shadow_states && options_.shadow_culling == ShadowCulling::certified;
    if ((plan_.shown == Shown::light || states) && !plan_.reference && !sized_.empty()) {
        // Without culling, nothing is remembered from frame to frame; the answers are the same.
        if (!proven_ || (options_.shadow_culling != ShadowCulling::certified && !request.preview))
            proven_ = std::make_unique<trace::ProvenVisibility>();
        techniques.sized = &sized_;
        techniques.sized_visibility = proven_.get();
        if (states)
            techniques.sized_visibility =
                &checked_sized.emplace(*proven_, states_, panels_of(states_, sized_, *scene_));
    } else {
        proven_.reset();
    }

    const bool lights = plan_.shown == Shown::light;
    techniques.environment = environment_.of_frame(*state_, options_, lights, plan_.reference, request.preview);
    trace::TracedOptions traced;
    traced.max_depth = options_.max_depth;
    // Overlays, references and the papers by the letter have one sample a pixel rather than adaptive ones.
    traced.adaptive = options_.samples == k_adaptive_samples && lights && !plan_.reference && !options_.as_printed;
    traced.samples = std::max(options_.samples, 1);
    traced.filter = image::chosen_filter(options_.filter, traced.adaptive);
    if (plan_.reference || plan_.shown != Shown::light) traced.filter = PixelFilter::box;
    if (options_.exposure) traced.exposure = static_cast<float>(*options_.exposure);
    traced.filters_shown = !nah_;   // which remembers what each image shows, so that none may precede the frame's
    traced.backdrop_apart = options_.background != BackgroundKind::environment && plan_.shown == Shown::light;
    traced.layers = options_.layers && plan_.shown == Shown::light;
    keep_tiles(traced);
    if (in_scanline_order) traced.tile = 1;
    if (plan_.reference) {
        traced.random_lobes = true;   // a ray for four paths of a point
        traced.lobe_rays = std::max(1, options_.reference->spp / 4);
        traced.lobe_seed = options_.reference->seed;
    }
    std::optional<trace::Blur> blur;
    if (request.shutter && can_blur()) {
        const SeenPlaces places = see_places(*rays_, view);
        trace::BlurOptions blurs{.lens = find_lens(view, options_, places), .samples = std::max(options_.samples, 0)};
        blurs.random = request.random_blur, blurs.in_full = request.blur_in_full;
        blur.emplace(find_motion(*state_, view, *request.shutter, places), blurs);
    }
    // Where all pixels are blurred, many samples at the shutter's middle would be in vain.
    if (blur && blur->motion().everything)
        traced.samples = 1, traced.filter = image::chosen_filter(options_.filter, traced.adaptive);
    if (!traced.adaptive && !blur) scratch_.forget_samples();
    FrameCounters counters = trace::trace_frame(*state_, *rays_, view, traced, tasks, *buffers_, techniques,
                                                request.log, {}, blur ? &*blur : nullptr);
    if (blur && blur->any()) blur_traced(*blur, *request.shutter, traced, techniques, tasks, counters);
    if (accelerator_ == Accelerator::kdtree) count_kdtree(counters);
    return counters;
}

void FrameEngine::keep_tiles(trace::TracedOptions& traced)
{
    // The published culling learns from each first hit, and without culling every ray is traced.
    traced.keeps = options_.keep_image && plan_.shown == Shown::light && !plan_.reference &&
                   options_.shadow_culling == ShadowCulling::certified;
    traced.continues = continues_;
    // Leave half of what is left of the memory to tiles.
    if (limit_.bytes() == 0) return;
    const std::size_t others = held_bytes() - scratch_.kept.bytes();
    scratch_.kept.limit(limit_.bytes() > others ? (limit_.bytes() - others) / 2 : 0);
}

void FrameEngine::count_kdtree(FrameCounters& counters) const
{
    const auto work = [&](ray::RayClass purpose) {
        const ray::KdCounts counts = rays_->kdtree_work(purpose);
        return FrameCounters::KdTree::Work{counts.nodes, counts.tests};
    };
    counters.kdtree = {work(ray::RayClass::primary), work(ray::RayClass::reflection), work(ray::RayClass::refraction),
                       work(ray::RayClass::shadow), work(ray::RayClass::indirect)};
}

bool FrameEngine::complete() const
{
    return !environment_.rough() && (!plan_.cache || !cache_->lacks_points());
}

Image8 FrameEngine::paint_overlay(const std::vector<std::string>& titles)
{
    if (plan_.shown == Shown::clusters) return paint_clusters(state_->scene(), *rays_, view_, *map_, tasks_);
    GNOMON_CHECK(plan_.shown == Shown::shadow_states);
    const bool sized = std::any_of(states_.lights.begin(), states_.lights.end(),
                                   [&](int l) { return static_cast<std::size_t>(l) >= scene_->lights.size(); });
    return paint_states(states_, titles, {options_.shadow_culling == ShadowCulling::paper, sized});
}

void FrameEngine::paint_redrawn(double exposure)
{
    GNOMON_CHECK(plan_.shown == Shown::redrawn);
    raster_->paint_redrawn(exposure, buffers_->color);
}

std::string FrameEngine::device() const
{
    return raster_ ? raster_->device() : std::string();
}

std::size_t FrameEngine::cached_bytes() const
{
    std::size_t bytes = sized_.bytes() + environment_.bytes();
    if (proven_) bytes += proven_->bytes();
    if (certified_) bytes += certified_->bytes();
    if (cache_) bytes += cache_->bytes();
    if (map_) bytes += map_->bytes();
    if (raster_) bytes += raster_->remembered_bytes();
    return bytes;
}

std::size_t FrameEngine::held_bytes() const
{
    return cached_bytes() + bytes_of(*buffers_) + scratch_.bytes() + (rays_ ? rays_->statistics().bytes : 0);
}

void FrameEngine::check_memory(std::string_view what) const
{
    if (limit_.bytes() > 0) limit_.check(held_bytes(), what);
}

void FrameEngine::make_certificates(const std::function<bool()>& go_on)
{
    if (certified_) certified_->judge(tasks_, go_on);
}

Box3 FrameEngine::bounds()
{
    GNOMON_CHECK(state_);
    if (ShownBounds::adds_to(state_->scene())) return shown_bounds_.of(*state_);
    return rays_ ? rays_->bounds() : scene_->bounds(state_->time());
}

PickedPoint FrameEngine::hit_at(const scene::View& view, const glm::ivec2& pixel)
{
    GNOMON_CHECK(state_);
    if (!rays_) make_rays();
    const trace::ViewHit hit = trace::CentreLayers(*state_, *rays_, view, nullptr).hit_at(pixel);
    PickedPoint picked;
    picked.object = hit.object;
    if (picked.object == scene::none) return picked;
    shading::SurfacePoint surface;
    shading::surface_at(state_->scene(), rays_->geometry(hit.object), hit.triangle, hit.u, hit.v, hit.distance,
                        hit.direction, {view.pixel_width, view.pixel_spread}, surface);
    picked.material = hit.material;
    picked.triangle = hit.triangle;
    picked.position = surface.position;
    picked.normal = surface.normal;
    picked.depth = hit.distance * glm::dot(hit.direction, view.forward);
    return picked;
}

}   // namespace gnomon::frame
