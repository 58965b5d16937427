// SPDX-License-Identifier: Apache-2.0
#include "gnomon/renderer.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "api/check_options.h"
#include "base/check.h"
#include "base/stopwatch.h"
#include "frame/cluster_overlay.h"
#include "frame/rasterizer.h"
#include "frame/state_overlay.h"
#include "image/tone_map.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "ray/kdtree/kdtree.h"
#include "reference/reference.h"
#include "scene/view.h"
#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "trace/indirect_grid.h"
#include "trace/traced_frame.h"

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

constexpr Size k_default_size{1280, 720};
// An image of the method's inside, already in screen colours.
void give_overlay(const Image8& image, Frame& result)
{
    result.size = {image.width, image.height};
    result.tonemap = ToneMap::none;
    Layer layer{"", {"R", "G", "B"}, std::vector<float>(image.data.size())};
    const float* linear = linear_from_srgb8();
    for (std::size_t i = 0; i < image.data.size(); ++i) layer.data[i] = linear[image.data[i]];
    result.layers.push_back(std::move(layer));
}

// The lights that an overlay shows.
std::vector<int> overlay_lights(const scene::Scene& scene, const RenderOptions& options)
{
    const int count = static_cast<int>(scene.lights.size());
    if (count == 0) throw UsageError("an overlay of shadow states needs a light: the scene has none");
    std::vector<int> lights;
    if (options.overlay_light) {
        if (*options.overlay_light < 0 || *options.overlay_light >= count)
            throw UsageError(
                fmt::format("no light {}: the scene has {}, numbered from 0", *options.overlay_light, count));
        return {*options.overlay_light};
    }
    for (int l = 0; l < count; ++l) lights.push_back(l);
    return lights;
}

std::vector<std::string> overlay_titles(const scene::Scene& scene, const std::vector<int>& lights, int frame)
{
    std::vector<std::string> titles;
    for (const int l : lights) {
        const std::string& name = scene.lights[static_cast<std::size_t>(l)].name;
        const std::string number = fmt::format("light {}", l);
        titles.push_back(fmt::format("frame {}  {}{}{}", frame, number, name.empty() || name == number ? "" : ": ",
                                     name == number ? "" : name));
    }
    return titles;
}

// Root of the mean variance over all pixels and channels, in units of the image's mean.
double noise_of(const shading::FrameBuffers& buffers)
{
    double mean = 0, square = 0;
    for (const float value : buffers.color.data) mean += static_cast<double>(value);
    for (const float variance : buffers.variance.data) square += static_cast<double>(variance);
    const auto count = static_cast<double>(buffers.color.data.size());
    return mean > 0 ? std::sqrt(square / count) / (mean / count) : 0;
}

Size traced_size(const Scene& scene, const RenderOptions& options)
{
    return options.size.width > 0 ? options.size : default_size(scene, options.camera);
}

}   // namespace

// What stands still is kept here from frame to frame, as long as the scene is the same.
struct Renderer::Impl {
    explicit Impl(RenderOptions o) : options(std::move(o)), tasks(options.threads) {}

    RenderOptions options;
    Tasks tasks;
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<scene::SceneState> state;
    std::unique_ptr<ray::RayScene> rays;
    std::unique_ptr<shadow_culling::CertifiedCulling> culling;
    std::unique_ptr<shadow_culling::PaperCulling> paper;
    std::unique_ptr<irradiance_cache::IrradianceCache> visible;
    std::unique_ptr<light_quadtree::MapLight> map;
    std::unique_ptr<frame::Rasterizer> raster;
    shading::FrameBuffers buffers;
    trace::StateMap states;
    std::optional<glm::vec3> turn_centre;   // of `scene`

    void follow(const std::shared_ptr<const scene::Scene>& wanted, double time)
    {
        if (wanted != scene) {
            culling.reset();
            paper.reset();
            visible.reset();
            map.reset();
            raster.reset();
            rays.reset();
            turn_centre.reset();
            scene.reset();   // until all is made
            state = std::make_unique<scene::SceneState>(wanted, time);
            if (options.renderer == RenderMethod::raster) {
                if (options.indirect == Indirect::visible) rays = std::make_unique<ray::RayScene>(*state);
                raster = frame::make_rasterizer(*state, {.samples = options.samples,
                                                         .layers = options.layers,
                                                         .shadows = options.shadow_textures,
                                                         .shadow_filter = static_cast<float>(options.shadow_filter),
                                                         .redrawn = options.overlay == Overlay::redrawn,
                                                         .indirect = options.indirect,
                                                         .map = trace::map_light_options(options),
                                                         .visible = trace::visible_light_options(options),
                                                         .indirect_on = options.indirect_on,
                                                         .rays = rays.get(),
                                                         .tasks = &tasks});
                scene = wanted;
                return;
            }
            rays = std::make_unique<ray::RayScene>(*state);
            if (options.accelerator == Accelerator::kdtree) rays->trace_on_kdtree(*state);
            scene = wanted;
            follow_paper();
            if (options.indirect == Indirect::visible && !options.reference)
                visible = std::make_unique<irradiance_cache::IrradianceCache>(
                    *state, *rays, trace::visible_light_options(options), tasks);
            if ((options.indirect == Indirect::rsm || options.indirect == Indirect::quadtree) && !options.reference)
                map =
                    std::make_unique<light_quadtree::MapLight>(*state, *rays, trace::map_light_options(options), tasks);
            return;
        }
        state->advance(time);
        if (rays) rays->update(*state);
        if (raster) {
            raster->update(*state);
            return;
        }
        // Shadows are remembered from the second frame on: a single image has nothing to gain. Nor has a reference.
        if (!culling && !options.reference && options.shadow_culling == ShadowCulling::certified &&
            !scene->lights.empty())
            culling =
                std::make_unique<shadow_culling::CertifiedCulling>(*state, *rays, shadow_culling::CertifiedOptions{});
        follow_paper();
    }
    // The published method learns from the first frame on.
    void follow_paper()
    {
        if (!paper && options.shadow_culling == ShadowCulling::paper)
            paper = std::make_unique<shadow_culling::PaperCulling>(*state, *rays);
    }
};

Renderer::Renderer(RenderOptions options)
{
    check_options(options);
    impl_ = std::make_unique<Impl>(std::move(options));
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Renderer::Impl& Renderer::inside() const
{
    if (!impl_) throw UsageError("a renderer that was moved from renders nothing");
    return *impl_;
}

const RenderOptions& Renderer::options() const
{
    return inside().options;
}

std::string Renderer::device() const
{
    return inside().raster ? inside().raster->device() : std::string();
}

Frame Renderer::render(const Scene& scene, int frame, const Progress& progress)
{
    Impl& in = inside();
    const RenderOptions& options = in.options;
    if (frame < 1 || frame > scene.frame_count())
        throw UsageError(fmt::format("no frame {}: the clip has frames 1 to {}", frame, scene.frame_count()));

    const scene::CameraId camera = scene::find_camera(*scene.inside(), options.camera);
    image_size(scene, options);   // refuses what cannot be shown
    const auto start = Clock::now();
    FrameTimes own;   // beside the tracer's
    gnomon::Stopwatch watch(own);
    const double time = scene.time_of(frame);
    // What failed halfway, for want of memory, is not gone on from: the next frame begins with nothing.
    struct Attempt {
        Impl& in;
        bool whole = false;
        ~Attempt()
        {
            if (!whole) in.scene.reset();
        }
    } attempt{in};
    in.follow(scene.inside(), time);
    watch.end(FrameTimes::scene);

    const Size size = traced_size(scene, options);
    scene::View view = scene::make_view(*in.state, camera, size);
    if (options.turntable_seconds > 0) {
        const double turn = (frame - 1) / scene.fps() / options.turntable_seconds;
        // Around one place for the whole clip, whatever moves.
        if (!in.turn_centre) in.turn_centre = scene.inside()->bounds(scene.inside()->timeline.start).centre();
        view = scene::turned(view, *in.turn_centre, 2 * k_pi * turn);
    }

    if (options.overlay == Overlay::clusters) {
        in.map->begin_frame(*in.state, *in.rays, in.tasks);
        attempt.whole = true;
        Frame result;
        give_overlay(frame::paint_clusters(*scene.inside(), *in.rays, view, *in.map, in.tasks), result);
        result.counters.indirect.clusters = in.map->counters().lights;
        result.counters.indirect.rays = in.map->map().work().cast;
        result.time = time;
        result.frame = frame;
        result.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        return result;
    }

    trace::TracedOptions traced;
    traced.max_depth = options.max_depth;
    traced.samples = options.samples;
    const bool states = options.overlay == Overlay::shadow_states;
    traced.layers = options.layers && !states;
    trace::Remembered remembered(in.culling.get());
    remembered.paper = in.paper.get();
    remembered.visible = states ? nullptr : in.visible.get();
    std::optional<reference::ReferenceLight> reference;
    if (options.reference && !states) {
        const auto& [spp, bounces, seed] = *options.reference;
        // A plain colour behind everything is seen, and lights nothing.
        const bool surroundings = in.scene->background.kind != scene::Background::Kind::color;
        reference.emplace(*in.state, *in.rays, reference::ReferenceOptions{spp, bounces, seed, surroundings});
        traced.reference = &*reference;
    }
    remembered.map = states || options.reference ? nullptr : in.map.get();
    if (states) {
        in.states.lights = overlay_lights(*scene.inside(), options);
        remembered.states = &in.states;
    }
    Frame result;
    try {
        result.counters = in.raster ? in.raster->render(*in.state, view, in.buffers, progress)
                                    : trace::trace_frame(*in.state, *in.rays, view, traced, in.tasks, in.buffers,
                                                         remembered, nullptr, progress);
    } catch (const InterruptedError&) {
        in.paper.reset();   // half a frame would be remembered
        // Half a frame was recorded, and points were claimed that nobody evaluated.
        attempt.whole = !in.raster && !in.visible;
        throw;
    }
    attempt.whole = true;
    if (options.accelerator == Accelerator::kdtree && in.rays && !in.raster) {
        const auto work = [&](ray::RayClass purpose) {
            const ray::KdCounts counts = in.rays->kdtree_work(purpose);
            return FrameCounters::KdTree::Work{counts.nodes, counts.tests};
        };
        result.counters.kdtree = {work(ray::RayClass::primary), work(ray::RayClass::reflection),
                                  work(ray::RayClass::refraction), work(ray::RayClass::shadow),
                                  work(ray::RayClass::indirect)};
    }
    watch.restart();
    if (reference) result.noise = noise_of(in.buffers);
    result.time = time;
    result.frame = frame;
    if (states) {
        const bool paper = options.shadow_culling == ShadowCulling::paper;
        const Image8 image =
            frame::paint_states(in.states, overlay_titles(*scene.inside(), in.states.lights, frame), paper);
        give_overlay(image, result);
        result.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        return result;
    }

    result.tonemap = options.tonemap;
    result.exposure = options.exposure ? *options.exposure : image::auto_exposure(in.buffers.color.data);
    if (options.overlay == Overlay::redrawn) {
        in.raster->paint_redrawn(result.exposure, in.buffers.color);
        result.tonemap = ToneMap::none;
        result.exposure = 0;
    }

    // Hand the buffers over as layers.
    const auto give = [&](const char* name, std::vector<std::string> channels, const ImageF& image) {
        result.layers.push_back({name, std::move(channels), image.data});
    };
    give("", {"R", "G", "B"}, in.buffers.color);
    if (options.layers) {
        give("depth", {"Z"}, in.buffers.depth);
        give("normal", {"X", "Y", "Z"}, in.buffers.normal);
        give("albedo", {"R", "G", "B"}, in.buffers.albedo);
        give("direct", {"R", "G", "B"}, in.buffers.direct);
        if (in.visible || in.map || reference || (in.raster && options.indirect != Indirect::off))
            give("indirect", {"R", "G", "B"}, in.buffers.indirect);
        if (reference) {
            give("variance", {"R", "G", "B"}, in.buffers.variance);
            give("irradiance", {"R", "G", "B"}, in.buffers.irradiance);
            give("irradiance_variance", {"R", "G", "B"}, in.buffers.irradiance_variance);
        }
        std::vector<std::string> lights;
        for (std::size_t l = 0; l < scene.inside()->lights.size(); ++l) lights.push_back(fmt::format("L{}", l));
        if (!lights.empty()) give("shadow", std::move(lights), in.buffers.shadow);
    }
    result.size = size;
    watch.end(FrameTimes::image);
    if (!in.raster) {
        result.times = in.buffers.times;
        result.times.ms[FrameTimes::scene] = own.ms[FrameTimes::scene];
        result.times.ms[FrameTimes::image] = own.ms[FrameTimes::image];
    }
    result.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return result;
}

Size default_size(const Scene& scene, const std::string& camera)
{
    const Size own = scene.inside()->cameras[scene::find_camera(*scene.inside(), camera)].resolution;
    return own.width > 0 ? own : k_default_size;
}

Size image_size(const Scene& scene, const RenderOptions& options)
{
    const Size size = traced_size(scene, options);
    if (options.overlay == Overlay::redrawn && scene.inside()->lights.empty())
        throw UsageError("an overlay of what was redrawn needs a light: the scene has none");
    if (options.overlay != Overlay::shadow_states) return size;
    const std::size_t panels = overlay_lights(*scene.inside(), options).size();
    if (static_cast<std::int64_t>(size.width) * size.height * static_cast<std::int64_t>(panels) > ranges::k_max_pixels)
        throw UsageError(
            fmt::format("an overlay of {} lights has more than {} million pixels: choose one with --overlay-light",
                        panels, ranges::k_max_pixels / 1'000'000));
    return frame::overlay_size(size, panels, options.shadow_culling == ShadowCulling::paper);
}

}   // namespace gnomon
