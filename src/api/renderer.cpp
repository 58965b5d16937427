// SPDX-License-Identifier: Apache-2.0
#include "gnomon/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "api/check_options.h"
#include "api/convert.h"
#include "api/frame_layers.h"
#include "api/host_state.h"
#include "api/outputs.h"
#include "api/scene_access.h"
#include "base/interruption.h"
#include "base/stopwatch.h"
#include "frame/frame_engine.h"
#include "frame/state_overlay.h"
#include "scene/near_origin.h"
#include "scene/pose_between.h"
#include "scene/view.h"

namespace gnomon {

namespace {
using Clock = std::chrono::steady_clock;
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
    // Of the last frame, for what is asked about it and for the layer of motion of the next.
    bool has_frame = false;
    double last_time = 0;
    std::optional<double> last_exposure;
    std::optional<Camera> camera;
    /// A camera in the world, as a frame was rendered with it.
    struct PlacedCamera {
        scene::Camera camera;
        glm::dmat4 to_world{1};
        bool of_host = false;
    };
    std::optional<PlacedCamera> last_camera;

    mutable std::mutex mutex;
    Interruption* rendering = nullptr;   // of the render in progress; under the mutex
    /// @throws UsageError  this renderer is rendering
    void refuse_while_rendering() const;

    struct Wanted;
    Frame render(const Scene& scene, const FrameInput& input, const Progress& progress);
    Wanted check(const Scene& scene, const FrameInput& input) const;
    std::optional<double> turn_of(const Scene& scene, const FrameInput& input, int frame) const;
    static scene::View host_view(const Wanted& wanted, double fraction);
    scene::View make_view(const Wanted& wanted, const FrameInput& input, PlacedCamera& placed);
    std::optional<frame::Shutter> shutter_of(const Scene& scene, const Wanted& wanted, const FrameInput& input);
    std::optional<scene::View> view_before(const Scene& scene, const Wanted& wanted, const FrameInput& input,
                                           bool is_first);
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

void Renderer::Impl::refuse_while_rendering() const
{
    const std::lock_guard lock(mutex);
    RenderScope::refuse_second(rendering);
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

// The same for calls that cannot be made while it renders.
Renderer::Impl& Renderer::idle() const
{
    impl().refuse_while_rendering();
    return *impl_;
}

const RenderOptions& Renderer::options() const
{
    return impl().options;
}

void Renderer::set_options(RenderOptions options)
{
    Impl& in = idle();
    check_options(options);
    if (options.interactive != in.options.interactive)
        throw UsageError("a renderer is interactive from the start or not at all");
    if (options.threads != in.options.threads) in.engine.use_threads(options.threads);
    in.options = std::move(options);
}

std::string Renderer::device() const
{
    return idle().engine.device();
}

std::size_t Renderer::remembered_bytes() const
{
    return idle().engine.cached_bytes();
}

void Renderer::forget()
{
    idle().engine.forget();
    idle().host = {};
    idle().has_frame = false;
    idle().camera.reset();
    idle().last_camera.reset();
}

void Renderer::improve(const std::function<bool()>& go_on)
{
    idle().engine.make_certificates(go_on ? go_on : [] { return true; });
}

Transform Renderer::transform(const NodeId& id) const
{
    const Impl& in = idle();
    const scene::SceneState& state = in.last_state();
    const scene::NodeId node = api::require(in.last_scene().stamps.nodes, id, "the node");
    const bool is_root = state.scene().nodes[node].parent == scene::none;
    return api::transform_of(
        scene::translated(state.local(node), is_root ? in.last_scene().stamps.origin : glm::dvec3(0)));
}

Transform Renderer::world_transform(const NodeId& id) const
{
    const Impl& in = idle();
    const scene::SceneState& state = in.last_state();
    const scene::NodeId node = api::require(in.last_scene().stamps.nodes, id, "the node");
    return api::transform_of(scene::translated(state.world(node), in.last_scene().stamps.origin));
}

bool Renderer::visible(const NodeId& id) const
{
    const Impl& in = idle();
    const scene::SceneState& state = in.last_state();
    return state.visible(api::require(in.last_scene().stamps.nodes, id, "the node"));
}

Camera Renderer::camera() const
{
    if (!idle().camera) throw UsageError("the renderer has no scene yet: render a frame first");
    return *idle().camera;
}

Box Renderer::bounds() const
{
    const glm::dvec3 origin = idle().last_scene().stamps.origin;
    const Box3 box = idle().engine.bounds();
    const auto placed = [&](const glm::vec3& corner) { return api::vec(glm::vec3(glm::dvec3(corner) + origin)); };
    return box.empty() ? Box{} : Box{placed(box.low), placed(box.high)};
}

Pick Renderer::pick(int x, int y)
{
    frame::FrameEngine& engine = idle().engine;
    if (!engine.has_frame()) throw UsageError("nothing can be picked: no frame was rendered, or the last one failed");
    const Size size = engine.view().size;
    if (x < 0 || y < 0 || x >= size.width || y >= size.height)
        throw UsageError(fmt::format("no pixel {} {}: the image has {} x {} pixels", x, y, size.width, size.height));
    const frame::PickedPoint point = engine.hit_at(engine.view(), {x, y});
    Pick pick;
    pick.hit = point.object != scene::none;
    if (!pick.hit) return pick;
    const api::SceneStamps& stamps = idle().last_scene().stamps;
    pick.instance = InstanceId(stamps.nodes.id<NodeId>(engine.state()->scene().objects[point.object].node));
    pick.material = stamps.materials.id<MaterialId>(point.material);
    pick.triangle = point.triangle;
    pick.position = api::vec(glm::vec3(glm::dvec3(point.position) + stamps.origin));
    pick.normal = {point.normal.x, point.normal.y, point.normal.z};
    pick.depth = point.depth;
    return pick;
}

FrameReport Renderer::report() const
{
    const frame::FrameEngine& engine = idle().engine;
    if (!engine.has_frame()) throw UsageError("nothing to report: no frame was rendered, or the last one failed");
    const frame::EngineReport& last = engine.report();
    FrameReport report;
    report.everything = last.everything;
    const api::SceneStamps& stamps = idle().last_scene().stamps;
    std::vector<scene::NodeId> nodes;
    for (const scene::ObjectId object : last.objects) nodes.push_back(engine.state()->scene().objects[object].node);
    std::sort(nodes.begin(), nodes.end());
    for (const scene::NodeId node : nodes) report.instances.emplace_back(stamps.nodes.id<NodeId>(node));
    for (const scene::LightId light : last.lights) report.lights.push_back(stamps.lights.id<LightId>(light));
    for (const scene::MaterialId material : last.materials)
        report.materials.push_back(stamps.materials.id<MaterialId>(material));
    report.rectangles = last.rectangles;
    return report;
}

void Renderer::cancel()
{
    const std::lock_guard lock(impl().mutex);
    if (impl().rendering) impl().rendering->request();
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

// What a frame is rendered of, checked.
struct Renderer::Impl::Wanted {
    double time = 0;
    Size size;
    std::optional<scene::Camera> camera, camera_closing;   // of the host
    glm::dmat4 camera_to_world{1}, closing_to_world{1};
    scene::CameraId scene_camera = scene::none;   // otherwise
    std::optional<double> turn;
};

// Checks everything before anything changes.
Renderer::Impl::Wanted Renderer::Impl::check(const Scene& scene, const FrameInput& input) const
{
    if (!input.time && (input.frame < 1 || input.frame > scene.frame_count()))
        throw UsageError(fmt::format("no frame {}: the clip has frames 1 to {}", input.frame, scene.frame_count()));
    if (input.time && !std::isfinite(*input.time)) throw UsageError("the time is not finite");
    if (!std::isfinite(input.turn)) throw UsageError("the turn is not finite");
    const scene::Scene& inside = *api::scene_of(scene);
    const glm::dvec3& origin = api::SceneAccess::impl(scene).stamps.origin;
    Wanted wanted;
    wanted.time = input.time ? *input.time : scene.time_of(input.frame);
    if (input.camera_closing) {
        wanted.camera_closing = api::to_scene(*input.camera_closing);
        wanted.closing_to_world =
            scene::translated(api::matrix_of(input.camera_closing->transform, "the camera"), -origin);
        if (!input.camera) throw UsageError("a closing camera needs one of the shutter's opening");
    }
    Size of_camera;
    if (input.camera) {
        wanted.camera = api::to_scene(*input.camera);
        wanted.camera_to_world = scene::translated(api::matrix_of(input.camera->transform, "the camera"), -origin);
        of_camera = input.camera->resolution;
    } else {
        wanted.scene_camera = scene::find_camera(inside, options.camera);
        of_camera = inside.cameras[wanted.scene_camera].resolution;
        wanted.turn = turn_of(scene, input, input.frame);
    }
    wanted.size = api::rendered_size(options.size, of_camera);
    api::check_overlay(inside, options, wanted.size);
    check_outputs(input.outputs, wanted.size);
    return wanted;
}

// The radians by which the scene's camera has circled it at a frame.
std::optional<double> Renderer::Impl::turn_of(const Scene& scene, const FrameInput& input, int frame) const
{
    std::optional<double> turn;
    if (input.turn != 0) turn = input.turn;
    if (options.turntable_seconds > 0 && !input.time)
        turn = input.turn + 2 * k_pi * ((frame - 1) / scene.fps() / options.turntable_seconds);
    return turn;
}

// The view of a host's camera at a fraction of the shutter's opening.
scene::View Renderer::Impl::host_view(const Wanted& wanted, double fraction)
{
    if (!wanted.camera_closing) return scene::make_view(*wanted.camera, wanted.camera_to_world, wanted.size);
    return scene::view_between(*wanted.camera, wanted.camera_to_world, *wanted.camera_closing, wanted.closing_to_world,
                               wanted.size, fraction);
}

scene::View Renderer::Impl::make_view(const Wanted& wanted, const FrameInput& input, PlacedCamera& placed)
{
    if (wanted.camera) {
        camera = input.camera;
        placed = {*wanted.camera, wanted.camera_to_world, true};
        if (!wanted.camera_closing || options.shutter == 0) return host_view(wanted, 0);
        placed.to_world =
            scene::pose_between(wanted.camera_to_world, wanted.closing_to_world, frame::Shutter::k_middle);
        return host_view(wanted, frame::Shutter::k_middle);
    }
    const scene::View view = engine.make_view(wanted.scene_camera, wanted.size, wanted.turn);
    const scene::Camera& described = engine.state()->scene().cameras[wanted.scene_camera];
    placed = {described, wanted.turn ? scene::matrix_of(view)
                                     : scene::placed(described, engine.state()->world(described.node), wanted.size)};
    placed.camera.fit.reset();   // it stands where this image needs it
    camera = api::from_scene(described, scene::translated(placed.to_world, last_scene().stamps.origin));
    return view;
}

// The frame before, for the layer of motion: by tracks, the one before in the clip; by a host, the one that was
// rendered last. Nothing moved before the first.
std::optional<scene::View> Renderer::Impl::view_before(const Scene& scene, const Wanted& wanted,
                                                       const FrameInput& input, bool is_first)
{
    if (!options.motion) return {};
    if (is_first) host.values().end_frame();   // the values handed over are those of the frame before, too
    double time = wanted.time;
    if (!input.time && input.frame > 1) time = scene.time_of(input.frame - 1);
    if (input.time && !is_first) time = last_time;
    const scene::SceneState& before = engine.move_previous(time, &host.values());
    // A host's camera comes from where the last one was, and so does the scene's after a host's.
    if (!is_first && last_camera && (wanted.camera || (last_camera->of_host && input.time)))
        return scene::make_view(last_camera->camera, last_camera->to_world, wanted.size);
    if (wanted.camera) return scene::make_view(*wanted.camera, wanted.camera_to_world, wanted.size);
    std::optional<double> turn = wanted.turn;
    if (!input.time && input.frame > 1) turn = turn_of(scene, input, input.frame - 1);
    return engine.view_in(before, wanted.scene_camera, wanted.size, turn);
}

// When the shutter is open, around the frame's time, and where the camera is meanwhile.
std::optional<frame::Shutter> Renderer::Impl::shutter_of(const Scene& scene, const Wanted& wanted,
                                                         const FrameInput& input)
{
    if (options.shutter == 0 && options.f_number == 0 && options.aperture == 0) return {};
    frame::Shutter shutter;
    const double half = 0.5 * options.shutter / 360 / scene.fps();
    shutter.open = wanted.time - half, shutter.close = wanted.time + half, shutter.middle = wanted.time;
    if (!input.time) shutter.first = scene.time_of(1), shutter.last = scene.time_of(scene.frame_count());
    shutter.host = &host.values();
    const bool turns = options.turntable_seconds > 0 && !input.time;
    shutter.view_at = [this, &wanted, turns, shutter](const scene::SceneState& state, double fraction) {
        if (wanted.camera) return host_view(wanted, fraction);
        std::optional<double> turn = wanted.turn;
        const double time = shutter.at(fraction);
        if (turns) turn = *turn + 2 * k_pi * (time - wanted.time) / options.turntable_seconds;
        return engine.view_in(state, wanted.scene_camera, wanted.size, turn);
    };
    return shutter;
}

Frame Renderer::Impl::render(const Scene& scene, const FrameInput& input, const Progress& progress)
{
    Interruption interruption(progress);
    const RenderScope in_progress(mutex, rendering, interruption);
    const Wanted wanted = check(scene, input);
    const scene::Scene& inside = *api::scene_of(scene);
    const auto start = Clock::now();

    Frame result;
    FrameTimes own;   // of the stages outside the engine's render()
    gnomon::Stopwatch watch(own);
    result.frame = input.time ? 0 : input.frame;
    result.time = wanted.time;
    const bool is_first = !has_frame || !host.follows(scene);
    host.apply(scene, input);
    host.values().show_at(options.shutter > 0 ? frame::Shutter::k_middle : 0);
    const bool began_anew = engine.advance(host.values().scene(), wanted.time, options, &host.values()).anew;
    watch.end(FrameTimes::scene);

    PlacedCamera placed;
    const scene::View view = make_view(wanted, input, placed);
    frame::RenderRequest request;
    request.previous_view = view_before(scene, wanted, input, is_first);
    request.shutter = shutter_of(scene, wanted, input);
    const frame::Shown shown = engine.shown();
    if (shown == frame::Shown::shadow_states) request.overlay_lights = api::overlay_lights(inside, options);
    request.indirect_ray_limit = input.indirect_ray_limit;
    request.preview = input.preview;
    has_frame = false;
    result.counters = engine.render(view, request);
    result.counters.update = {engine.state()->changes().touched_nodes, engine.touched_instances(), began_anew};
    result.complete = engine.complete();
    result.view_size = view.size;
    result.fps = scene.fps();
    api::describe(view, last_scene().stamps.origin, options, result);

    watch.restart();
    if (shown == frame::Shown::shadow_states || shown == frame::Shown::clusters) {
        api::set_overlay(engine.paint_overlay(api::overlay_titles(inside, request.overlay_lights, result.frame)),
                         result);
        if (shown == frame::Shown::shadow_states) {
            const frame::PanelPlace place = frame::panel_place(view.size, request.overlay_lights.size(), 0);
            result.view_left = place.left, result.view_top = place.top;
        }
    } else {
        api::set_layers(engine, inside, view, options, result.counters.kept_image ? last_exposure : options.exposure,
                        result);
        last_exposure = result.exposure;
        result.size = view.size;
        watch.end(FrameTimes::image);
        if (options.renderer == RenderMethod::trace) {
            result.times = engine.times();
            result.times.ms[FrameTimes::scene] = own.ms[FrameTimes::scene];
            result.times.ms[FrameTimes::image] += own.ms[FrameTimes::image];
        }
    }
    host.values().end_frame();
    has_frame = true;
    last_time = wanted.time;
    last_camera = std::move(placed);
    write_outputs(result, input.outputs, engine.tasks());
    result.milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return result;
}

}   // namespace gnomon
