// SPDX-License-Identifier: Apache-2.0
#include "trace/traced_frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include "base/check.h"
#include "base/interruption.h"
#include "base/stopwatch.h"
#include "image/pixel_filter.h"
#include "image/tone_map.h"
#include "shading/lobe_rays.h"
#include "trace/environment_lighting.h"
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
    if (alpha) resize(out.alpha, size, 1);
    if (estimate)
        for (ImageF* image : {&out.variance, &out.irradiance, &out.irradiance_variance}) resize(*image, size, 3);
    if (!layers) return;
    for (ImageF* image : {&out.direct, &out.indirect, &out.albedo, &out.normal}) resize(*image, size, 3);
    resize(out.depth, size, 1);
    resize(out.shadow, size, static_cast<int>(lights));
}

Tile tile_at(std::size_t index, int columns, int side, Size size)
{
    Tile tile;
    tile.side = side;
    tile.x = static_cast<int>(index) % columns * side;
    tile.y = static_cast<int>(index) / columns * side;
    tile.width = std::min(side, size.width - tile.x);
    tile.height = std::min(side, size.height - tile.y);
    return tile;
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

// Takes further samples where those at the pixels' centres differ, and filters all of them.
// @param tile_of    by number
// @param tracer_of  by worker
void take_further_samples(const shading::CentreSamples& centres, const LobeImage* lobes, const TracedOptions& options,
                          std::size_t tiles, const std::function<Tile(std::size_t)>& tile_of,
                          const std::function<TileTracer&(int)>& tracer_of, Tasks& tasks, shading::FrameBuffers& out)
{
    const float exposure =
        std::exp2(options.exposure ? *options.exposure : static_cast<float>(image::auto_exposure(out.color.data)));
    image::SampleSums sums(centres.size(), options.tile, channels_of(out, options), k_white / exposure);
    Refinement refinement{centres, out, averaged_layers(std::as_const(out), options), lobes, options.refine, {}, sums};
    refinement.options.exposure = exposure;
    refinement.weights[0] = image::sample_weights(options.filter, glm::vec2(0.5f));
    for (int i = 0; i < scene::k_refined_samples; ++i)
        refinement.weights[static_cast<std::size_t>(i) + 1] =
            image::sample_weights(options.filter, scene::refined_offset(i));

    // Refine the selected pixels, and what they lead to, round by round.
    RefinedPixels pixels(centres.size());
    pixels.select(refinement, tasks);
    for (int round = 0; round < RefinedPixels::k_rounds; ++round) {
        report_progress("refining", static_cast<double>(round) / RefinedPixels::k_rounds);
        tasks.for_each(tiles, [&](std::size_t index, int worker) {
            tracer_of(worker).refine(tile_of(index), refinement, pixels);
        });
        if (!pixels.select_next(tasks)) break;
    }

    // Add the other pixels' samples.
    tasks.for_each(tiles, [&](std::size_t index, int worker) {
        tracer_of(worker).add_single(tile_of(index), refinement, pixels);
    });
    resolve(sums, tiles, tasks, out, options);
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
                          const Techniques& techniques, TraceLog* log, const Progress& progress)
{
    // LONG: the stages of a frame, one after the other, over the same few objects.
    GNOMON_CHECK(!log || (tasks.threads() == 1 && !techniques.shadows));
    GNOMON_CHECK(options.tile > 0 && (options.tile & (options.tile - 1)) == 0);
    EveryShadowRay every_ray(log);
    ShadowTester& shadows = techniques.shadows ? *techniques.shadows : every_ray;
    IndirectLight* const indirect = techniques.indirect;
    SampledVisibility sampled;
    SizedVisibility& sized_visibility = techniques.sized_visibility ? *techniques.sized_visibility : sampled;
    const SizedTechnique sized{techniques.sized, techniques.sized ? &sized_visibility : nullptr};
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());

    // Bring the techniques up to this frame. The shadow test follows whole, so that it outlives an interruption.
    out.times = {};
    Stopwatch watch(out.times);
    const FrameContext frame{state, rays, view, tasks};
    const Size size = view.size;
    const int columns = (size.width + options.tile - 1) / options.tile;
    const int rows = (size.height + options.tile - 1) / options.tile;
    const auto tiles = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    EnvironmentTechnique* environment = techniques.environment;
    {
        const InterruptionScope whole(nullptr);
        shadows.begin_frame(frame);
        if (sized.lights) sized_visibility.begin_frame(frame, *sized.lights);
        if (environment) environment->begin_frame(frame, tiles);
    }
    if (environment && environment->empty() && environment->light().suns().empty()) environment = nullptr;
    if (indirect) indirect->begin_frame(frame);
    watch.end(FrameTimes::light_maps);
    fit(out, size, options.layers, indirect && indirect->is_estimate(), options.backdrop_apart,
        state.scene().lights.size());

    std::optional<LobeImage> lobes;
    if (!options.random_lobes && has_lobes(state.scene())) lobes.emplace(size);
    LobeImage* const lobe_image = lobes ? &*lobes : nullptr;

    // Trace the tiles.
    std::optional<shading::CentreSamples> centres;
    if (options.adaptive) centres.emplace(size);
    std::optional<image::SampleSums> sums;
    const bool filters = !options.adaptive && options.filter != PixelFilter::box;
    if (filters) sums.emplace(size, options.tile, channels_of(out, options), k_infinity);
    std::vector<std::unique_ptr<TileTracer>> tracers(static_cast<std::size_t>(tasks.threads()));
    const auto make_tracer = [&] {
        return std::make_unique<TileTracer>(frame, options, shadows, sized, environment, indirect, lobe_image,
                                            centres ? &*centres : nullptr, log);
    };
    std::atomic<std::size_t> done = 0;
    report_progress("tracing", 0);
    tasks.for_each(tiles, [&](std::size_t index, int worker) {
        auto& tracer = tracers[static_cast<std::size_t>(worker)];
        if (!tracer) tracer = make_tracer();
        tracer->trace(tile_at(index, columns, options.tile, size), out, filters ? &*sums : nullptr);
        report_progress("tracing", static_cast<double>(++done) / static_cast<double>(tiles));
    });

    if (filters) resolve(*sums, tiles, tasks, out, options);
    if (lobes) lobes->add_to(out.color, 1.0f / static_cast<float>(options.samples), tasks);

    if (options.adaptive) {
        const auto tile_of = [&](std::size_t index) { return tile_at(index, columns, options.tile, size); };
        const auto tracer_of = [&](int worker) -> TileTracer& {
            auto& tracer = tracers[static_cast<std::size_t>(worker)];
            if (!tracer) tracer = make_tracer();
            return *tracer;
        };
        take_further_samples(*centres, lobe_image, options, tiles, tile_of, tracer_of, tasks, out);
    }

    // Sum what the threads counted, and let the techniques learn from what their workers found.
    FrameCounters counters;
    environment_light::VisibilityCounters environment_counters;
    std::uint64_t few_rays = 0;
    std::vector<std::unique_ptr<ShadowTester::Worker>> shadow_workers;
    std::vector<std::unique_ptr<SizedVisibility::Worker>> sized_workers;
    std::vector<std::unique_ptr<IndirectLight::Worker>> indirect_workers;
    for (const auto& tracer : tracers) {
        if (!tracer) continue;
        counters.primary_rays += tracer->counters().primary_rays;
        counters.reflection_rays += tracer->counters().reflection_rays;
        counters.refraction_rays += tracer->counters().refraction_rays;
        counters.samples.pixels += tracer->counters().samples.pixels;
        counters.samples.taken += tracer->counters().samples.taken;
        counters.samples.shaded += tracer->counters().samples.shaded;
        for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
            out.times.ms[stage] += tracer->times().ms[stage] / tasks.threads();
        environment_counters.add(tracer->environment_counters());
        few_rays += tracer->few_rays();
        shadow_workers.push_back(tracer->take_shadows());
        if (sized.lights) sized_workers.push_back(tracer->take_sized());
        if (indirect) indirect_workers.push_back(tracer->take_indirect());
    }
    watch.restart();   // the tiles measured their own time
    counters.shadow = shadows.end_frame(shadow_workers, tasks);
    if (sized.lights) {
        const FrameCounters::Shadow more = sized_visibility.end_frame(sized_workers, tasks);
        counters.shadow.rays += more.rays + few_rays;
        counters.shadow.rays_skipped += more.rays_skipped;
        counters.shadow.rays_dynamic_only += more.rays_dynamic_only;
        if (more.rays_wrong) counters.shadow.rays_wrong = counters.shadow.rays_wrong.value_or(0) + *more.rays_wrong;
    }
    if (environment) {
        environment->set_counters(environment_counters);
        counters.shadow.rays += environment_counters.rays + environment_counters.dynamic_rays;
        counters.shadow.rays_dynamic_only += environment_counters.dynamic_rays;
    }
    watch.end(FrameTimes::proofs);
    if (indirect) counters.indirect = indirect->end_frame(indirect_workers);
    watch.end(FrameTimes::indirect);
    return counters;
}

}   // namespace gnomon::trace
