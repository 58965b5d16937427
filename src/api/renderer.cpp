// SPDX-License-Identifier: Apache-2.0
#include "gnomon/renderer.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "api/check_options.h"
#include "api/convert.h"
#include "api/host_state.h"
#include "api/scene_access.h"
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
        titles.push_back(fmt::format("{}{}{}{}", frame > 0 ? fmt::format("frame {}  ", frame) : "", number,
                                     name.empty() || name == number ? "" : ": ", name == number ? "" : name));
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

// Throws where an overlay cannot be shown.
void check_overlay(const Scene& scene, const RenderOptions& options)
{
    if (options.overlay == Overlay::redrawn && api::scene_of(scene)->lights.empty())
        throw UsageError("an overlay of what was redrawn needs a light: the scene has none");
    if (options.overlay != Overlay::shadow_states) return;
    const Size size = traced_size(scene, options);
    const std::size_t panels = overlay_lights(*api::scene_of(scene), options).size();
    if (static_cast<std::int64_t>(size.width) * size.height * static_cast<std::int64_t>(panels) > ranges::k_max_pixels)
        throw UsageError(
            fmt::format("an overlay of {} lights has more than {} million pixels: choose one with --overlay-light",
                        panels, ranges::k_max_pixels / 1'000'000));
}

}   // namespace

struct Renderer::Impl {
    explicit Impl(RenderOptions o)
        : options(std::move(o)),
          engine({.threads = options.threads,
                  .culls_first_frame = options.interactive,
                  .defers_certificates = options.interactive,
                  .always_has_rays = options.interactive,
                  .redrawn_stays = options.interactive})
    {
    }

    RenderOptions options;
    frame::FrameEngine engine;
    api::HostState host;
    std::optional<Camera> camera;   // of the last frame

    Frame render(const Scene& scene, const FrameInput& input, const Progress& progress);
    scene::View make_view(const Scene& scene, const FrameInput& input);
    const Scene::Impl& last_scene() const;
    const scene::SceneState& last_state() const;
};

// The scene of the last frame.
const Scene::Impl& Renderer::Impl::last_scene() const
{
    if (!host.scene() || !engine.state()) throw UsageError("the renderer has no scene yet: render a frame first");
    return api::SceneAccess::impl(*host.scene());
}

const scene::SceneState& Renderer::Impl::last_state() const
{
    last_scene();
    return *engine.state();
}

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

void Renderer::set_options(RenderOptions options)
{
    Impl& in = impl();
    check_options(options);
    if (options.interactive != in.options.interactive)
        throw UsageError("a renderer is interactive from the start or not at all");
    if (options.threads != in.options.threads) in.engine.use_threads(options.threads);
    in.options = std::move(options);
}

std::string Renderer::device() const
{
    return impl().engine.device();
}

std::size_t Renderer::remembered_bytes() const
{
    return impl().engine.cached_bytes();
}

void Renderer::forget()
{
    impl().engine.forget();
    impl().host = {};
    impl().camera.reset();
}

void Renderer::improve(const std::function<bool()>& go_on)
{
    impl().engine.make_certificates(go_on ? go_on : [] { return true; });
}

Transform Renderer::transform(const NodeId& id) const
{
    const Impl& in = impl();
    const scene::SceneState& state = in.last_state();
    return api::transform_of(state.local(api::require(in.last_scene().stamps.nodes, id, "the node")));
}

Transform Renderer::world_transform(const NodeId& id) const
{
    const Impl& in = impl();
    const scene::SceneState& state = in.last_state();
    return api::transform_of(state.world(api::require(in.last_scene().stamps.nodes, id, "the node")));
}

bool Renderer::visible(const NodeId& id) const
{
    const Impl& in = impl();
    const scene::SceneState& state = in.last_state();
    return state.visible(api::require(in.last_scene().stamps.nodes, id, "the node"));
}

Camera Renderer::camera() const
{
    impl().last_state();
    return *impl().camera;
}

Box Renderer::bounds() const
{
    impl().last_state();
    const Box3 box = impl().engine.bounds();
    return box.empty() ? Box{} : Box{api::vec(box.low), api::vec(box.high)};
}

Frame Renderer::render(const Scene& scene, int frame, const Progress& progress)
{
    FrameInput input;
    input.frame = frame;
    return impl().render(scene, input, progress);
}

Frame Renderer::render(const Scene& scene, const FrameInput& input, const Progress& progress)
{
    return impl().render(scene, input, progress);
}

// The host's camera, else the scene's.
scene::View Renderer::Impl::make_view(const Scene& scene, const FrameInput& input)
{
    if (input.camera) {
        camera = input.camera;
        Size size = options.size.width > 0 ? options.size : input.camera->resolution;
        if (size.width <= 0) size = k_default_size;
        return scene::make_view(api::to_scene(*camera), api::matrix_of(camera->transform, "the camera"), size);
    }
    const scene::Scene& inside = *api::scene_of(scene);
    const scene::CameraId id = scene::find_camera(inside, options.camera);
    std::optional<double> turn;
    if (input.turn != 0) turn = input.turn;
    if (options.turntable_seconds > 0 && !input.time)
        turn = input.turn + 2 * k_pi * ((input.frame - 1) / scene.fps() / options.turntable_seconds);
    scene::View view = engine.make_view(id, traced_size(scene, options), turn);
    glm::dmat4 world = engine.state()->world(inside.cameras[id].node);
    if (turn) world = scene::matrix_of(view);
    camera = api::from_scene(inside.cameras[id], world);
    return view;
}

Frame Renderer::Impl::render(const Scene& scene, const FrameInput& input, const Progress& progress)
{
    // Check everything before anything changes.
    if (!input.time && (input.frame < 1 || input.frame > scene.frame_count()))
        throw UsageError(fmt::format("no frame {}: the clip has frames 1 to {}", input.frame, scene.frame_count()));
    if (input.time && !std::isfinite(*input.time)) throw UsageError("the time is not finite");
    if (!std::isfinite(input.turn)) throw UsageError("the turn is not finite");
    for (const std::optional<Camera>* given : {&input.camera, &input.camera_closing})
        if (*given) api::to_scene(**given), api::matrix_of((*given)->transform, "the camera");
    const scene::Scene& inside = *api::scene_of(scene);
    if (!input.camera) scene::find_camera(inside, options.camera);
    check_overlay(scene, options);
    const auto start = Clock::now();

    Frame result;
    FrameTimes own;   // of the stages outside the engine's render()
    gnomon::Stopwatch watch(own);
    result.frame = input.time ? 0 : input.frame;
    result.time = input.time ? *input.time : scene.time_of(input.frame);
    host.apply(scene, input);
    const bool began_anew = !engine.state() || engine.scene() != host.values().scene();
    engine.advance(host.values().scene(), result.time, options, {}, &host.values());
    host.values().forget_changes();
    watch.end(FrameTimes::scene);

    const scene::View view = make_view(scene, input);
    frame::RenderRequest request;
    const frame::Shown shown = engine.shown();
    if (shown == frame::Shown::shadow_states) request.overlay_lights = overlay_lights(inside, options);
    request.indirect_ray_limit = input.indirect_ray_limit;
    result.counters = engine.render(view, request, progress);
    result.counters.update = {engine.state()->changes().touched_nodes, engine.touched_instances(), began_anew};
    result.complete = engine.complete();
    result.view_size = view.size;

    watch.restart();
    if (shown == frame::Shown::shadow_states || shown == frame::Shown::clusters) {
        set_overlay(engine.paint_overlay(overlay_titles(inside, request.overlay_lights, result.frame)), result);
        if (shown == frame::Shown::shadow_states) {
            const frame::PanelPlace place = frame::panel_place(view.size, request.overlay_lights.size(), 0);
            result.view_left = place.left, result.view_top = place.top;
        }
    } else {
        set_layers(engine, inside, options, result);
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
    const scene::Scene& inside = *api::scene_of(scene);
    const Size own = inside.cameras[scene::find_camera(inside, camera)].resolution;
    return own.width > 0 ? own : k_default_size;
}

Size image_size(const Scene& scene, const RenderOptions& options)
{
    check_overlay(scene, options);
    const Size size = traced_size(scene, options);
    if (options.overlay != Overlay::shadow_states) return size;
    const std::size_t panels = overlay_lights(*api::scene_of(scene), options).size();
    return frame::overlay_size(size, panels, options.shadow_culling == ShadowCulling::paper);
}

}   // namespace gnomon
