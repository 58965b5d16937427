// SPDX-License-Identifier: Apache-2.0
#include "gnomon/renderer.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <mutex>

#include "api/check_options.h"
#include "base/interruption.h"
#include "base/stopwatch.h"
#include "frame/frame_engine.h"
#include "frame/state_overlay.h"
#include "image/tone_map.h"
#include "scene/view.h"

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

constexpr Size k_default_size{1280, 720};
// Makes an overlay, which is in screen colours, the only layer.
void set_overlay(const Image8& image, Frame& result)
{
    result.size = {image.width, image.height};
    result.tonemap = ToneMap::none;
    Layer layer{"", {"R", "G", "B"}, std::vector<float>(image.data.size())};
    const float* linear = linear_from_srgb8();
    for (std::size_t i = 0; i < image.data.size(); ++i) layer.data[i] = linear[image.data[i]];
    result.layers.push_back(std::move(layer));
}

// Returns the lights that an overlay shows.
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

// Returns the root of the mean variance over all pixels and channels, divided by the image's mean.
double noise_of(const shading::FrameBuffers& buffers)
{
    double mean = 0, square = 0;
    for (const float value : buffers.color.data) mean += static_cast<double>(value);
    for (const float variance : buffers.variance.data) square += static_cast<double>(variance);
    const auto count = static_cast<double>(buffers.color.data.size());
    return mean > 0 ? std::sqrt(square / count) / (mean / count) : 0;
}

// Exposes the engine's image, and copies its layers.
void set_layers(frame::FrameEngine& engine, const scene::Scene& scene, const RenderOptions& options, Frame& result)
{
    shading::FrameBuffers& buffers = engine.buffers();
    if (engine.is_reference()) result.noise = noise_of(buffers);
    result.tonemap = options.tonemap;
    result.exposure = options.exposure ? *options.exposure : image::auto_exposure(buffers.color.data);
    if (engine.shown() == frame::Shown::redrawn) {
        engine.paint_redrawn(result.exposure);
        result.tonemap = ToneMap::none;
        result.exposure = 0;
    }

    const auto add = [&](const char* name, std::vector<std::string> channels, const ImageF& image) {
        result.layers.push_back({name, std::move(channels), image.data});
    };
    add("", {"R", "G", "B"}, buffers.color);
    if (!options.layers) return;
    add("depth", {"Z"}, buffers.depth);
    add("normal", {"X", "Y", "Z"}, buffers.normal);
    add("albedo", {"R", "G", "B"}, buffers.albedo);
    add("direct", {"R", "G", "B"}, buffers.direct);
    if (engine.has_indirect()) add("indirect", {"R", "G", "B"}, buffers.indirect);
    if (engine.is_reference()) {
        add("variance", {"R", "G", "B"}, buffers.variance);
        add("irradiance", {"R", "G", "B"}, buffers.irradiance);
        add("irradiance_variance", {"R", "G", "B"}, buffers.irradiance_variance);
    }
    std::vector<std::string> lights;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) lights.push_back(fmt::format("L{}", l));
    if (!lights.empty()) add("shadow", std::move(lights), buffers.shadow);
}

Size traced_size(const Scene& scene, const RenderOptions& options)
{
    return options.size.width > 0 ? options.size : default_size(scene, options.camera);
}

}   // namespace

struct Renderer::Impl {
    explicit Impl(RenderOptions o) : options(std::move(o)), engine({.threads = options.threads}) {}

    RenderOptions options;
    frame::FrameEngine engine;
    std::mutex mutex;
    Interruption* rendering = nullptr;   // of the render in progress; under the mutex
};

namespace {

// Marks a renderer as rendering, so that cancel() finds the render, and a second one is refused.
class RenderScope {
 public:
    RenderScope(std::mutex& mutex, Interruption*& rendering, Interruption& interruption)
        : mutex_(mutex), rendering_(rendering), current_(&interruption)
    {
        const std::lock_guard lock(mutex_);
        refuse_second(rendering_);
        rendering_ = &interruption;
    }
    ~RenderScope()
    {
        const std::lock_guard lock(mutex_);
        rendering_ = nullptr;
    }
    RenderScope(const RenderScope&) = delete;
    RenderScope& operator=(const RenderScope&) = delete;

    static void refuse_second(const Interruption* rendering)
    {
        if (rendering)
            throw UsageError(
                "this renderer is rendering already: use it from one thread at a time, and not from its progress "
                "callback");
    }

 private:
    std::mutex& mutex_;
    Interruption*& rendering_;
    const InterruptionScope current_;
};

}   // namespace

Renderer::Renderer(RenderOptions options)
{
    check_options(options);
    impl_ = std::make_unique<Impl>(std::move(options));
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Renderer::Impl& Renderer::impl() const
{
    if (!impl_) throw UsageError("a renderer that was moved from renders nothing");
    return *impl_;
}

const RenderOptions& Renderer::options() const
{
    return impl().options;
}

std::string Renderer::device() const
{
    const std::lock_guard lock(impl().mutex);
    RenderScope::refuse_second(impl().rendering);
    return impl().engine.device();
}

void Renderer::cancel()
{
    const std::lock_guard lock(impl().mutex);
    if (impl().rendering) impl().rendering->request();
}

Frame Renderer::render(const Scene& scene, int frame, const Progress& progress)
{
    Interruption interruption(progress);
    const RenderScope rendering(impl().mutex, impl().rendering, interruption);
    const RenderOptions& options = impl().options;
    frame::FrameEngine& engine = impl().engine;
    if (frame < 1 || frame > scene.frame_count())
        throw UsageError(fmt::format("no frame {}: the clip has frames 1 to {}", frame, scene.frame_count()));
    const scene::CameraId camera = scene::find_camera(*scene.impl(), options.camera);
    image_size(scene, options);   // throws where an overlay cannot be shown
    const auto start = Clock::now();

    Frame result;
    FrameTimes own;   // of the stages outside the engine's render()
    gnomon::Stopwatch watch(own);
    result.frame = frame;
    result.time = scene.time_of(frame);
    engine.advance(scene.impl(), result.time, options);
    watch.end(FrameTimes::scene);

    std::optional<double> turn;
    if (options.turntable_seconds > 0) turn = 2 * k_pi * ((frame - 1) / scene.fps() / options.turntable_seconds);
    const scene::View view = engine.make_view(camera, traced_size(scene, options), turn);
    frame::RenderRequest request;
    const frame::Shown shown = engine.shown();
    if (shown == frame::Shown::shadow_states) request.overlay_lights = overlay_lights(*scene.impl(), options);
    result.counters = engine.render(view, request);

    watch.restart();
    if (shown == frame::Shown::shadow_states || shown == frame::Shown::clusters) {
        set_overlay(engine.paint_overlay(overlay_titles(*scene.impl(), request.overlay_lights, frame)), result);
    } else {
        set_layers(engine, *scene.impl(), options, result);
        result.size = view.size;
        watch.end(FrameTimes::image);
        if (options.renderer == RenderMethod::trace) {
            result.times = engine.buffers().times;
            result.times.ms[FrameTimes::scene] = own.ms[FrameTimes::scene];
            result.times.ms[FrameTimes::image] = own.ms[FrameTimes::image];
        }
    }
    result.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return result;
}

Size default_size(const Scene& scene, const std::string& camera)
{
    const Size own = scene.impl()->cameras[scene::find_camera(*scene.impl(), camera)].resolution;
    return own.width > 0 ? own : k_default_size;
}

Size image_size(const Scene& scene, const RenderOptions& options)
{
    const Size size = traced_size(scene, options);
    if (options.overlay == Overlay::redrawn && scene.impl()->lights.empty())
        throw UsageError("an overlay of what was redrawn needs a light: the scene has none");
    if (options.overlay != Overlay::shadow_states) return size;
    const std::size_t panels = overlay_lights(*scene.impl(), options).size();
    if (static_cast<std::int64_t>(size.width) * size.height * static_cast<std::int64_t>(panels) > ranges::k_max_pixels)
        throw UsageError(
            fmt::format("an overlay of {} lights has more than {} million pixels: choose one with --overlay-light",
                        panels, ranges::k_max_pixels / 1'000'000));
    return frame::overlay_size(size, panels, options.shadow_culling == ShadowCulling::paper);
}

}   // namespace gnomon
