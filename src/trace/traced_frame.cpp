// SPDX-License-Identifier: Apache-2.0
#include "trace/traced_frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>

#include "base/check.h"
#include "base/interruption.h"
#include "base/stopwatch.h"
#include "image/pixel_filter.h"
#include "image/tone_map.h"
#include "shading/lobe_rays.h"
#include "trace/blur.h"
#include "trace/environment_lighting.h"
#include "trace/frame_scratch.h"
#include "trace/indirect_light.h"
#include "trace/lobe_filter.h"
#include "trace/refinement.h"
#include "trace/shadow_testers.h"
#include "trace/sized_visibility.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

// Luminance of exposed light from which on it counts less: the display's white.
constexpr float k_white = 1;

void resize(ImageF& image, Size size, int channels)
{
    if (image.width != size.width || image.height != size.height || image.channels != channels)
        image = ImageF(size.width, size.height, channels);
}

void fit(shading::FrameBuffers& out, Size size, bool layers, bool estimate, bool alpha, std::size_t lights)
{
    resize(out.color, size, 3);
    if (alpha)
        resize(out.alpha, size, 1);
    else
        out.alpha = {};   // of a frame before
    if (estimate)
        for (ImageF* image : {&out.variance, &out.irradiance, &out.irradiance_variance}) resize(*image, size, 3);
    if (!layers) return;
    for (ImageF* image : {&out.direct, &out.indirect, &out.albedo, &out.normal}) resize(*image, size, 3);
    resize(out.depth, size, 1);
    resize(out.shadow, size, static_cast<int>(lights));
}

// Whether some surface may have a lobe that is reflected by rays (shading/lobe_rays.h).
bool has_lobes(const scene::Scene& scene)
{
    return std::ranges::any_of(scene.materials, [](const scene::Material& m) {
        const float f0 = (m.ior - 1) / (m.ior + 1);
        return m.model == scene::ShadingModel::metallic_roughness &&
               (m.metallic > 0 || f0 * f0 > shading::k_lobe_reflectance_from);
    });
}

int channels_of(const shading::FrameBuffers& buffers, const TracedOptions& options)
{
    int channels = 0;
    for (const ImageF* layer : averaged_layers(buffers, options)) channels += layer->channels;
    return channels;
}

// Whether samples take bounced light from each other.
bool shares_places(const TracedOptions& options, const Techniques& techniques, const Blur* blur)
{
    return options.refine.bounced_reach > 0 && techniques.indirect && !techniques.indirect->is_estimate() &&
           (!blur || blur->shares());
}

// Writes the filtered samples to the layers.
void resolve(const image::SampleSums& sums, std::size_t tiles, Tasks& tasks, shading::FrameBuffers& out,
             const TracedOptions& options)
{
    const std::vector<ImageF*> layers = averaged_layers(out, options);
    tasks.for_each(tiles, [&](std::size_t tile, int) {
        sums.resolve(tile, [&](int x, int y, const float* values) {
            for (ImageF* layer : layers) {
                std::copy_n(values, layer->channels, layer->pixel(x, y));
                values += layer->channels;
            }
        });
    });
}

// The techniques of a frame, brought up to it, and the tracers of its threads.
class Pass {
 public:
    Pass(const FrameContext& frame, const TracedOptions& options, const Techniques& techniques, TraceLog* log,
         FrameTimes& times);

    std::size_t tiles() const { return tiles_; }
    Tile tile(std::size_t index) const { return tile_at(index, columns_, options_.tile, frame_.view.size); }
    /// Does something with all tiles, and adds the places that samples meet in them to those that are known.
    template <class Body>
    void for_each_tile(const Body& body)
    {
        std::vector<std::vector<BouncedPlace>> found(places ? tiles_ : 0);
        frame_.tasks.for_each(tiles_, [&](std::size_t index, int worker) {
            body(index, tracer(worker));
            if (places) found[index] = tracer(worker).take_places();
        });
        for (const std::vector<BouncedPlace>& of_tile : found) places->add(of_tile);
    }
    /// The tracer of a thread.
    TileTracer& tracer(int worker)
    {
        auto& tracer = tracers_[static_cast<std::size_t>(worker)];
        if (!tracer)
            tracer = std::make_unique<TileTracer>(frame_, options_, shadows_, sized_, environment_, indirect_, lobes,
                                                  centres, places, log_);
        return *tracer;
    }
    /// Whether the light of first hits is that of lights whose changes kept tiles follow.
    bool lights_alone() const
    {
        return (!environment_ || environment_->empty()) && !sized_.lights && !frame_.rays.thins_light();
    }
    /// Angular, radians.
    float sun_radius() const
    {
        return environment_ ? static_cast<float>(0.5 * environment_->light().options().sun_diameter) : 0;
    }
    /// Sums what the threads counted, and lets the techniques learn from what their workers found.
    FrameCounters end();

    LobeImage* lobes = nullptr;                  // of the tracers
    shading::CentreSamples* centres = nullptr;   // likewise
    BouncedPlaces* places = nullptr;             // likewise

 private:
    const FrameContext& frame_;
    const TracedOptions& options_;
    TraceLog* log_;
    FrameTimes& times_;
    EveryShadowRay every_ray_;
    ShadowTester& shadows_;
    IndirectLight* indirect_;
    SampledVisibility sampled_;
    SizedTechnique sized_;
    EnvironmentTechnique* environment_;
    int columns_;
    std::size_t tiles_;
    std::vector<std::unique_ptr<TileTracer>> tracers_;
};

Pass::Pass(const FrameContext& frame, const TracedOptions& options, const Techniques& techniques, TraceLog* log,
           FrameTimes& times)
    : frame_(frame),
      options_(options),
      log_(log),
      times_(times),
      every_ray_(log),
      shadows_(techniques.shadows ? *techniques.shadows : every_ray_),
      indirect_(techniques.indirect),
      environment_(techniques.environment),
      columns_((frame.view.size.width + options.tile - 1) / options.tile),
      tracers_(static_cast<std::size_t>(frame.tasks.threads()))
{
    SizedVisibility& sized_visibility = techniques.sized_visibility ? *techniques.sized_visibility : sampled_;
    sized_ = {techniques.sized, techniques.sized ? &sized_visibility : nullptr};
    const int rows = (frame.view.size.height + options.tile - 1) / options.tile;
    tiles_ = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows);

    // Bring the techniques up to this frame. The shadow test follows whole, so that it outlives an interruption.
    Stopwatch watch(times);
    {
        const InterruptionScope whole(nullptr);
        shadows_.begin_frame(frame);
        if (sized_.lights) sized_.visibility->begin_frame(frame, *sized_.lights);
        if (environment_) environment_->begin_frame(frame, tiles_);
    }
    if (environment_ && environment_->empty() && environment_->light().suns().empty()) environment_ = nullptr;
    if (indirect_) indirect_->begin_frame(frame);
    watch.end(FrameTimes::light_maps);
}

FrameCounters Pass::end()
{
    FrameCounters counters;
    environment_light::VisibilityCounters environment_counters;
    std::uint64_t few_rays = 0;
    std::vector<std::unique_ptr<ShadowTester::Worker>> shadow_workers;
    std::vector<std::unique_ptr<SizedVisibility::Worker>> sized_workers;
    std::vector<std::unique_ptr<IndirectLight::Worker>> indirect_workers;
    for (const auto& tracer : tracers_) {
        if (!tracer) continue;
        counters.primary_rays += tracer->counters().primary_rays;
        counters.reflection_rays += tracer->counters().reflection_rays;
        counters.refraction_rays += tracer->counters().refraction_rays;
        counters.samples.pixels += tracer->counters().samples.pixels;
        counters.samples.taken += tracer->counters().samples.taken;
        counters.samples.shaded += tracer->counters().samples.shaded;
        for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
            times_.ms[stage] += tracer->times().ms[stage] / frame_.tasks.threads();
        environment_counters.add(tracer->environment_counters());
        few_rays += tracer->few_rays();
        shadow_workers.push_back(tracer->take_shadows());
        if (sized_.lights) sized_workers.push_back(tracer->take_sized());
        if (indirect_) indirect_workers.push_back(tracer->take_indirect());
    }
    Stopwatch watch(times_);   // the tiles measured their own time
    counters.shadow = shadows_.end_frame(shadow_workers, frame_.tasks);
    if (sized_.lights) {
        const FrameCounters::Shadow more = sized_.visibility->end_frame(sized_workers, frame_.tasks);
        counters.shadow.rays += more.rays + few_rays;
        counters.shadow.rays_skipped += more.rays_skipped;
        counters.shadow.rays_dynamic_only += more.rays_dynamic_only;
        if (more.rays_wrong) counters.shadow.rays_wrong = counters.shadow.rays_wrong.value_or(0) + *more.rays_wrong;
    }
    if (environment_) {
        environment_->set_counters(environment_counters);
        counters.shadow.rays += environment_counters.rays + environment_counters.dynamic_rays;
        counters.shadow.rays_dynamic_only += environment_counters.dynamic_rays;
    }
    watch.end(FrameTimes::proofs);
    if (indirect_) counters.indirect = indirect_->end_frame(indirect_workers);
    watch.end(FrameTimes::indirect);
    return counters;
}

float exposure_of(const shading::FrameBuffers& out, const TracedOptions& options)
{
    return std::exp2(options.exposure ? *options.exposure : static_cast<float>(image::auto_exposure(out.color.data)));
}

// The frame at one sample a pixel, which comes before one of more samples that are filtered.
TracedOptions single_of(const TracedOptions& options)
{
    TracedOptions single = options;
    single.samples = 1, single.filter = PixelFilter::box;
    return single;
}

// The luminance from which on light of a filtered frame counts less. Without an exposure, that of an image of one
// sample a pixel sets it, as for adaptive samples.
float white_of(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
               const TracedOptions& options, Tasks& tasks, const Techniques& techniques, FrameTimes& times)
{
    if (!options.filters_shown) return k_infinity;
    if (options.exposure) return k_white / std::exp2(*options.exposure);
    TracedOptions single = single_of(options);
    single.layers = false;
    shading::FrameBuffers buffers;
    trace_frame(state, rays, view, single, tasks, buffers, techniques);
    for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage) times.ms[stage] += buffers.times.ms[stage];
    return k_white / exposure_of(buffers, options);
}

// Takes further samples where those at the pixels' centres differ, and filters all of them.
// @param blur  optional: its touched pixels are left out, and it keeps the samples until they are there
void take_further_samples(FrameScratch& scratch, const LobeImage* lobes, const TracedOptions& options, Pass& pass,
                          Tasks& tasks, shading::FrameBuffers& out, Blur* blur)
{
    Stopwatch watch(out.times);   // the tiles' samples measure their own time
    const float exposure = exposure_of(out, options);
    const shading::CentreSamples& centres = scratch.centres;
    image::SampleSums& sums = scratch.sums;
    sums.begin(centres.size(), options.tile, channels_of(out, options), k_white / exposure);
    tasks.for_each(pass.tiles(), [&](std::size_t tile, int) { sums.clear(tile); });
    Refinement refinement{centres, out, averaged_layers(std::as_const(out), options), lobes, options.refine, {},
                          {},      sums};
    refinement.options.exposure = exposure;
    refinement.weights[0] = image::sample_weights(options.filter, glm::vec2(0.5f));
    refinement.lone = image::lone_sample_weights(options.filter);
    for (int i = 0; i < scene::k_refined_samples; ++i)
        refinement.weights[static_cast<std::size_t>(i) + 1] =
            image::sample_weights(options.filter, scene::refined_offset(i));

    // Refine the selected pixels, and what they lead to, round by round.
    RefinedPixels pixels(centres.size());
    const bool blurs = blur && blur->any();
    for (int y = 0; blurs && y < centres.size().height; ++y)
        for (int x = 0; x < centres.size().width; ++x)
            if (blur->touched(x, y)) pixels.leave_out(x, y);
    pixels.select(refinement, tasks);
    watch.end(FrameTimes::image);
    for (int round = 0; round < RefinedPixels::k_rounds; ++round) {
        report_progress("refining", static_cast<double>(round) / RefinedPixels::k_rounds);
        pass.for_each_tile([&](std::size_t index, TileTracer& tracer) {
            const Tile tile = pass.tile(index);
            if (pixels.any_selected(tile)) tracer.refine(tile, refinement, pixels);
        });
        watch.restart();
        const bool goes_on = pixels.select_next(tasks);
        watch.end(FrameTimes::image);
        if (!goes_on) break;
    }

    // Add the other pixels' samples.
    tasks.for_each(pass.tiles(), [&](std::size_t index, int worker) {
        pass.tracer(worker).add_single(pass.tile(index), refinement, pixels);
    });
    if (blurs)
        blur->keep(std::move(sums), refinement.weights[0], 1, options.tile);
    else
        resolve(sums, pass.tiles(), tasks, out, options);
    watch.end(FrameTimes::image);
}

}   // namespace

std::vector<ImageF*> averaged_layers(shading::FrameBuffers& buffers, const TracedOptions& options)
{
    std::vector<ImageF*> layers{&buffers.color};
    if (options.backdrop_apart) layers.push_back(&buffers.alpha);
    if (options.layers)
        layers.insert(layers.end(), {&buffers.direct, &buffers.indirect, &buffers.albedo, &buffers.shadow});
    return layers;
}

std::vector<const ImageF*> averaged_layers(const shading::FrameBuffers& buffers, const TracedOptions& options)
{
    const std::vector<ImageF*> layers = averaged_layers(const_cast<shading::FrameBuffers&>(buffers), options);
    return {layers.begin(), layers.end()};
}

FrameCounters trace_frame(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                          const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out,
                          const Techniques& techniques, TraceLog* log, const Progress& progress, Blur* blur)
{
    GNOMON_CHECK(!log || (tasks.threads() == 1 && !techniques.shadows));
    GNOMON_CHECK(options.tile > 0 && (options.tile & (options.tile - 1)) == 0);
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    out.times = {};
    const bool filters = !options.adaptive && options.filter != PixelFilter::box;
    float white = k_infinity;
    if (filters && blur) {
        // Find the touched pixels first, so that the others are filtered without their samples.
        trace_frame(state, rays, view, single_of(options), tasks, out, techniques, nullptr, {}, blur);
        if (options.filters_shown) white = k_white / exposure_of(out, options);
    } else if (filters) {
        white = white_of(state, rays, view, options, tasks, techniques, out.times);
    }
    const FrameContext frame{state, rays, view, tasks};
    Pass pass(frame, options, techniques, log, out.times);
    const Size size = view.size;
    fit(out, size, options.layers, techniques.indirect && techniques.indirect->is_estimate(), options.backdrop_apart,
        state.scene().lights.size());

    std::optional<LobeImage> lobes;
    if (!options.random_lobes && has_lobes(state.scene())) lobes.emplace(size, options.tile);
    FrameScratch own;
    FrameScratch& scratch = techniques.scratch ? *techniques.scratch : own;
    pass.lobes = lobes ? &*lobes : nullptr;
    if (options.adaptive || (blur && !filters)) {
        scratch.centres.begin(size);
        pass.centres = &scratch.centres;
        scratch.places.begin(blur ? blur->motion().objects : std::vector<scene::ObjectId>{});
        if (shares_places(options, techniques, blur)) pass.places = &scratch.places;
    }

    // Follow the tiles that keep their first hits.
    KeptTiles* kept = nullptr;
    if (options.keeps && options.samples == 1 && !filters && !blur && !options.layers && !options.backdrop_apart &&
        !options.random_lobes && !log && pass.lights_alone()) {
        kept = &scratch.kept;
        kept->begin_frame(frame, pass.tiles(), options.tile, options.continues, pass.sun_radius());
    } else {
        scratch.kept.forget();
    }

    // Trace the tiles.
    std::optional<image::SampleSums> sums;
    if (filters) sums.emplace(size, options.tile, channels_of(out, options), white);
    std::atomic<std::size_t> done = 0;
    report_progress("tracing", 0);
    pass.for_each_tile([&](std::size_t index, TileTracer& tracer) {
        if (kept && kept->keeps())
            tracer.trace(pass.tile(index), out, index, *kept);
        else
            tracer.trace(pass.tile(index), out, filters ? &*sums : nullptr, filters ? blur : nullptr);
        report_progress("tracing", static_cast<double>(++done) / static_cast<double>(pass.tiles()));
    });

    if (lobes && filters)
        lobes->add_to(*sums, tasks);
    else if (lobes)
        lobes->add_to(out.color, 1.0f / static_cast<float>(options.samples), tasks);
    if (filters && blur && blur->any())
        blur->keep(std::move(*sums), image::sample_weights(options.filter, glm::vec2(0.5f)), options.samples,
                   options.tile);
    else if (filters)
        resolve(*sums, pass.tiles(), tasks, out, options);
    if (filters) return pass.end();

    if (blur) blur->select(scratch.centres, state, view, techniques.sized, tasks);
    if (options.adaptive) take_further_samples(scratch, pass.lobes, options, pass, tasks, out, blur);
    if (blur && blur->any() && options.adaptive) blur->keep_light(averaged_layers(std::as_const(out), options));
    if (blur && blur->any()) blur->begin(size, channels_of(out, options), exposure_of(out, options), std::move(lobes));
    return pass.end();
}

FrameCounters trace_blurred(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                            const TracedOptions& options, Tasks& tasks, FrameTimes& times, const Techniques& techniques,
                            Blur& blur, std::optional<int> time)
{
    const FrameContext frame{state, rays, view, tasks};
    std::optional<Pass> following;
    {
        // Indirect light follows whole as well: with many times, an interruption would often find it half-way.
        const InterruptionScope whole(nullptr);
        following.emplace(frame, options, techniques, nullptr, times);
    }
    Pass& pass = *following;
    // Those of the shutter's middle, from trace_frame().
    if (techniques.scratch) pass.centres = &techniques.scratch->centres;
    if (techniques.scratch && shares_places(options, techniques, &blur)) pass.places = &techniques.scratch->places;
    std::atomic<std::size_t> done = 0;
    if (time)
        pass.for_each_tile([&](std::size_t index, TileTracer& tracer) {
            if (blur.any_active(pass.tile(index))) tracer.blur(pass.tile(index), blur, *time);
            const double part = static_cast<double>(++done) / static_cast<double>(pass.tiles());
            report_progress("blurring", blur.progress(*time + part));
        });
    return pass.end();
}

void finish_blur(const Blur& blur, const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out)
{
    blur.finish(averaged_layers(out, options), tasks);
}

}   // namespace gnomon::trace
