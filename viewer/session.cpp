// SPDX-License-Identifier: Apache-2.0
#include "viewer/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "gnomon/error.h"
#include "viewer/enlarge.h"
#include "viewer/projection.h"

namespace gnomon::viewer {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool contains(const std::vector<NodeId>& nodes, const NodeId& node)
{
    return std::find(nodes.begin(), nodes.end(), node) != nodes.end();
}

// Whether the renderer keeps what it remembers if its frame is interrupted: not the rasteriser, nor what depends on
// history.
bool survives_interruption(const RenderOptions& options)
{
    return options.renderer == RenderMethod::trace && options.shadow_culling != ShadowCulling::paper &&
           options.overlay != Overlay::shadow_states;
}

// Makes a request's options those of a window: no layers, no reference, and no overlay that the other options or the
// scene lack.
RenderOptions window_options(const ViewRequest& request, const Scene& scene, int threads)
{
    RenderOptions options = request.options;
    options.size = request.size;
    options.camera = request.camera;
    options.turntable_seconds = 0;
    options.threads = threads;
    options.interactive = true;
    options.layers = false;
    options.reference.reset();

    const bool traced = options.renderer == RenderMethod::trace;
    const std::size_t lights = scene.lights().size();
    const auto is_shown = [&] {
        switch (options.overlay) {
            case Overlay::none:
                return true;
            case Overlay::shadow_states:
                return traced && options.shadow_culling != ShadowCulling::off && lights > 0;
            case Overlay::clusters:
                return traced && options.indirect == Indirect::quadtree;
            case Overlay::redrawn:
                return !traced && options.shadow_textures != ShadowTextures::off && lights > 0;
        }
        return false;
    };
    if (!is_shown()) options.overlay = Overlay::none;
    // Show one light, because a panel for each would be too small.
    if (options.overlay == Overlay::shadow_states)
        options.overlay_light = std::min(options.overlay_light.value_or(0), static_cast<int>(lights) - 1);
    return options;
}

// Whether frames can have the layer "id": not those that an overlay replaces.
bool has_ids(const RenderOptions& options)
{
    return options.overlay == Overlay::none || options.overlay == Overlay::redrawn;
}

// What a frame with the layers "id", "normal" and "depth" shows; empty without them. With "shadow", also which lights
// shine on it.
std::vector<SeenSurface> surfaces_of(const Frame& frame)
{
    std::vector<SeenSurface> surfaces;
    const Layer *const ids = frame.layer("id"), *const normals = frame.layer("normal"),
                       *const depths = frame.layer("depth");
    if (!ids || !normals || !depths) return surfaces;
    const Layer* const shadows = frame.layer("shadow");
    constexpr int k_most_lights = 32;
    const int lights = shadows ? std::min(static_cast<int>(shadows->channels.size()), k_most_lights) : 0;
    surfaces.reserve(static_cast<std::size_t>(frame.size.width) * static_cast<std::size_t>(frame.size.height));
    for (int y = 0; y < frame.size.height; ++y)
        for (int x = 0; x < frame.size.width; ++x) {
            const float depth = depths->value(x, y);
            surfaces.push_back({ids->id(x, y),
                                {normals->value(x, y, 0), normals->value(x, y, 1), normals->value(x, y, 2)},
                                depth > 0 ? 1 / depth : 0});
            for (int light = 0; light < lights; ++light) {
                const float part = shadows->value(x, y, light);
                surfaces.back().lit |= (part == 1 ? 1u : 0u) << light;
                surfaces.back().unlit |= (part == 0 ? 1u : 0u) << light;
            }
        }
    return surfaces;
}

// The value of an instance in a layer of ids; 0: it is not seen.
std::uint32_t layer_value_of(const Scene& scene, const InstanceId& instance, const Layer& ids)
{
    std::uint32_t last = 0;
    for (int y = 0; y < ids.size.height; ++y)
        for (int x = 0; x < ids.size.width; ++x) {
            const std::uint32_t value = ids.id(x, y);
            if (value == 0 || value == last) continue;
            if (scene.instance_of(value) == instance) return value;
            last = value;
        }
    return 0;
}

// The origin of a picked node's space, if that is where the image shows the object, or else what was clicked at; in
// that space.
glm::vec3 pivot_of(const Picked& picked, const ViewImage& image)
{
    const glm::dmat4 world = matrix_of(picked.world);
    const glm::vec2 size(image.frame.view_size.width, image.frame.view_size.height);
    const std::optional<glm::vec2> origin = Projection(image.camera, size).place_of(glm::vec3(world[3]));
    glm::vec2 low(k_infinity), high(-k_infinity);
    for (const OutlineEdge& edge : image.outline)
        low = glm::min(low, glm::vec2(edge.from)), high = glm::max(high, glm::vec2(edge.to));
    if (origin && glm::all(glm::greaterThan(*origin * size, low)) && glm::all(glm::lessThan(*origin * size, high)))
        return glm::vec3(0);
    if (!(std::abs(glm::determinant(world)) > 0)) return glm::vec3(0);
    return glm::vec3(glm::inverse(world) * glm::dvec4(glm::dvec3(picked.position), 1));
}

// What the window says while bounced light is prepared, or a last image is blurred.
std::string preparing_text(const std::string& what, const ProgressStep& step)
{
    return step.done > 0 ? what + " " + std::to_string(std::lround(100 * step.done)) + " %" : what;
}

std::string blur_name(const RenderOptions& options)
{
    const bool moves = options.shutter > 0, lens = options.f_number > 0 || options.aperture > 0;
    return moves && lens ? "motion blur and depth of field" : moves ? "motion blur" : "depth of field";
}

// @param enlarges  the encoded image has the pixels of the screen, whatever the frame has
ViewTimes times_of(const Frame& frame, double encoding, bool enlarges)
{
    const auto sum = [&](std::initializer_list<FrameTimes::Stage> stages) {
        double total = 0;
        for (const FrameTimes::Stage stage : stages) total += frame.times.ms[stage];
        return total;
    };
    ViewTimes times;
    times.ms[ViewTimes::scene] = sum({FrameTimes::scene});
    times.ms[ViewTimes::direct] = sum({FrameTimes::rays, FrameTimes::surfaces, FrameTimes::shadows});
    times.ms[ViewTimes::indirect] = sum({FrameTimes::light_maps, FrameTimes::indirect, FrameTimes::indirect_mirrored});
    times.light_maps = frame.times.ms[FrameTimes::light_maps];
    times.fixed = times.light_maps + frame.times.ms[FrameTimes::scene] + (enlarges ? encoding : 0);
    times.ms[ViewTimes::rest] = std::max(frame.milliseconds - times.total(), 0.0) + encoding;
    return times;
}

}   // namespace

Transform UserOverride::transform() const
{
    Transform result = taken;
    if (turn != glm::quat(1, 0, 0, 0) || factor != 1) {
        const glm::dmat4 matrix = glm::translate(glm::dmat4(1), glm::dvec3(pivot)) * glm::mat4_cast(glm::dquat(turn)) *
                                  glm::scale(glm::dmat4(1), glm::dvec3(static_cast<double>(factor))) *
                                  glm::translate(glm::dmat4(1), -glm::dvec3(pivot));
        Transform change;
        for (int i = 0; i < 16; ++i) change.m[static_cast<std::size_t>(i)] = matrix[i / 4][i % 4];
        result = change * taken;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int element = 12 + axis;   // of the translation
        result.m[static_cast<std::size_t>(element)] += static_cast<double>(offset[axis]);
    }
    return result;
}

const char* ViewTimes::name(int stage)
{
    static constexpr const char* k_names[k_stages] = {"scene", "direct light", "indirect light", "rest"};
    return k_names[stage];
}

double ViewTimes::total() const
{
    double sum = 0;
    for (const double stage : ms) sum += stage;
    return sum;
}

ViewSession::ViewSession(int threads, std::uint64_t rays_a_frame, std::function<void()> changed)
    : threads_(threads),
      rays_a_frame_(rays_a_frame),
      changed_(std::move(changed)),
      renderer_({.threads = threads, .interactive = true})
{
    load_thread_ = std::jthread([this](const std::stop_token& stop) { load_loop(stop); });
    render_thread_ = std::jthread([this](const std::stop_token& stop) { render_loop(stop); });
}

ViewSession::~ViewSession()
{
    leaving_ = true;   // interrupts the frame in progress
}

LoadState ViewSession::load_state() const
{
    const std::lock_guard lock(mutex_);
    return state_;
}

std::shared_ptr<const Scene> ViewSession::scene() const
{
    const std::lock_guard lock(mutex_);
    return scene_;
}

std::uint64_t ViewSession::ask(ViewRequest request)
{
    const std::lock_guard lock(mutex_);
    // Keep the pick of a request that is replaced.
    if (request_ && request_->pick && !request.pick && request_->scene == request.scene) request.pick = request_->pick;
    // Every pick is answered, and a frame that is to be saved is finished.
    if (request.pick || request.whole || !survives_interruption(request.options)) request.interruptible = false;
    if (request_ && request_->urgent) request.urgent = true;   // it has that change, too
    request.number = ++asked_;
    if (request.urgent) urgent_ = request.number;
    interruptible_ = request.interruptible;
    request_ = std::move(request);
    refining_ = false;
    to_render_.notify_one();
    return asked_;
}

bool ViewSession::busy() const
{
    const std::lock_guard lock(mutex_);
    return (rendering_ || request_) && !refining_;
}

bool ViewSession::interruptible() const
{
    const std::lock_guard lock(mutex_);
    return interruptible_;
}

bool ViewSession::refining() const
{
    const std::lock_guard lock(mutex_);
    return refining_;
}

std::shared_ptr<const ViewImage> ViewSession::image(std::uint64_t newer_than) const
{
    const std::lock_guard lock(mutex_);
    return image_ && image_->number > newer_than ? image_ : nullptr;
}

void ViewSession::tell() const
{
    if (changed_) changed_();
}

void ViewSession::fail(std::uint64_t request, const std::string& message)
{
    const std::lock_guard lock(mutex_);
    state_.frame_error = message;
    state_.failed = request;
    state_.trouble = std::current_exception();
    tell();
}

void ViewSession::render_loop(const std::stop_token& stop)
{
    for (;;) {
        ViewRequest request;
        std::shared_ptr<const Scene> scene;
        bool refines = false;   // its first image is there
        {
            std::unique_lock lock(mutex_);
            rendering_ = false;
            refining_ = refining_ && request_;
            if (!to_render_.wait(lock, stop, [&] { return request_ && scene_; })) return;
            request = std::move(*request_);
            request_.reset();
            scene = scene_;
            rendering_ = true;
            refines = refining_;
        }
        const std::uint64_t number = request.number;
        if (request.scene != scene) {
            request.orbit.reset();
            request.camera = "auto";
            request.overrides.clear();
            request.pick.reset();
        }
        try {
            if (publish(render(scene, request, refines), request, refines)) continue;
            // Leave the processor to the window while it shows an image in motion and asks for the next one.
            if (request.rays && asked_soon(stop)) continue;
            if (finishes(request)) continue;
            // Prove results for later frames until the next request comes.
            renderer_.improve([&] {
                const std::lock_guard lock(mutex_);
                return !request_ && !leaving_;
            });
        } catch (const InterruptedError&) {   // for a newer request, or to leave
        } catch (const std::exception& e) {
            fail(number, e.what());
        }
    }
}

// Waits a moment for a request.
// @return  whether one came
bool ViewSession::asked_soon(const std::stop_token& stop)
{
    constexpr std::chrono::milliseconds k_moment{40};
    std::unique_lock lock(mutex_);
    return to_render_.wait_for(lock, stop, k_moment, [&] { return request_.has_value(); }) || stop.stop_requested();
}

// Makes an image the newest one, and requests its frame again for the light that is missing. An image that a newer
// request should have interrupted is dropped.
// @return whether there is a request
bool ViewSession::publish(std::shared_ptr<ViewImage> image, ViewRequest& request, bool refines)
{
    const std::lock_guard lock(mutex_);
    if ((refines || request.interruptible) && asked_ != request.number) return true;
    image->number = image_ ? image_->number + 1 : 1;
    const bool lacking = !image->frame.complete && image->scene == scene_;
    image_ = std::move(image);
    rendering_ = false;
    state_.frame_error.clear();
    state_.failed = 0;
    tell();
    if (request_) return true;
    refining_ = lacking;
    if (!lacking) return false;
    request.pick.reset();   // answered
    request_ = std::move(request);
    return true;
}

// Requests a complete image again with the options it gets at rest, unless there is a newer request.
// @return whether there is a request
bool ViewSession::finishes(ViewRequest& request)
{
    const std::lock_guard lock(mutex_);
    if (request_) return true;
    if (!request.at_rest || request.scene != scene_) return false;
    request.options = *std::exchange(request.at_rest, std::nullopt);
    request.finishing = true;
    request.pick.reset();   // answered
    refining_ = true;
    request_ = std::move(request);
    return true;
}

// Says what takes long, and how far it is, where that is news.
void ViewSession::note_preparing(const std::string& stage)
{
    const std::lock_guard lock(mutex_);
    if (state_.preparing == stage) return;
    state_.preparing = stage;
    tell();
}

std::shared_ptr<ViewImage> ViewSession::render(const std::shared_ptr<const Scene>& scene, const ViewRequest& request,
                                               bool refines)
{
    // Begin anew with another scene, even if it shares parts with the one before.
    if (rendered_ != scene) {
        renderer_.forget();
        held_.clear();
        rendered_ = scene;
    }
    std::optional<Picked> picked = picked_before(scene);
    RenderOptions options = window_options(request, *scene, threads_);
    const bool enlarges = request.enlarge > 1 && !request.whole && options.overlay == Overlay::none &&
                          options.renderer == RenderMethod::trace;
    options.layers = enlarges;   // for normals
    options.ids = has_ids(options) && (enlarges || request.pick || (picked && picked->instance));
    // Bounced light of a new scene takes seconds to prepare: leave it out at first.
    const Prepared wanted{scene, options.indirect, options.bounces};
    const bool bounces = options.renderer == RenderMethod::trace && options.indirect != Indirect::off;
    const bool prepares = bounces && prepared_ != wanted && options.shadow_culling != ShadowCulling::paper;
    const bool early = prepares && request.early && !refines;
    if (early) options.indirect = Indirect::off, options.shadow_culling = ShadowCulling::off;
    const bool in_motion = request.rays && !request.whole && !refines;
    if (request.coarse && !refines) options.max_depth = std::min(options.max_depth, k_coarse_depth);
    renderer_.set_options(options);
    FrameInput input;
    input.time = request.time;
    input.camera = request.orbit;
    input.turn = request.turn;
    // Where nothing moves, cast more and more rays: each image is traced anew, and can be interrupted.
    constexpr int k_most_doublings = 8;
    refined_ = refines ? std::min(refined_ + 1, k_most_doublings) : 0;
    input.indirect_ray_limit = request.whole || request.finishing ? 0 : rays_a_frame_ << refined_;
    input.preview = !request.whole && !refines && (request.preview || early);
    if (in_motion) input.indirect_ray_limit = std::clamp<std::uint64_t>(*request.rays, 1, rays_a_frame_);
    hand_over_overrides(*scene, request, input);

    // Render the frame; a newer request interrupts it if it only refines what is shown, an urgent one in any case.
    const bool yields =
        request.interruptible || request.finishing || (refines && survives_interruption(request.options));
    const bool yields_to_urgent = !request.urgent && !request.whole && survives_interruption(request.options);
    auto image = std::make_shared<ViewImage>();
    Frame& frame = image->frame;
    const auto goes_on = [&](const ProgressStep& step) {
        if (prepares && !early && request.early)
            note_preparing(preparing_text("bounced light: " + std::string(step.stage), step));
        if (request.finishing && (step.stage == "blurring" || step.stage == "drawing"))
            note_preparing(preparing_text(blur_name(request.options), step));
        return !leaving_ && !(yields && asked_ != request.number) && !(yields_to_urgent && urgent_ > request.number);
    };
    try {
        frame = renderer_.render(*scene, input, goes_on);
    } catch (...) {
        note_preparing("");
        throw;
    }
    note_preparing("");
    if (early)
        frame.complete = false, image->early = true;
    else if (bounces)
        prepared_ = wanted;
    std::erase_if(held_, [&](const NodeId& node) { return contains(input.released_nodes, node); });

    // Encode it for the screen.
    const Clock::time_point start = Clock::now();
    image->image.width = frame.size.width, image->image.height = frame.size.height, image->image.channels = 3;
    image->image.data = frame.to_srgb8();
    if (enlarges) {
        EnlargedImage large = enlarged(image->image, surfaces_of(frame), request.enlarge);
        image->image = std::move(large.image), image->nearness = std::move(large.nearness);
    }
    image->times = times_of(frame, milliseconds_since(start), enlarges);

    // Describe it.
    image->scene = scene;
    image->request = request.number;
    image->camera = renderer_.camera();
    image->orbit = request.orbit;
    image->time = request.time;
    image->overrides = request.overrides;
    if (!enlarges && !request.whole && options.overlay == Overlay::none) image->nearness = nearness_before(*image);
    const Box bounds = renderer_.bounds();
    if (!bounds.empty())
        image->bounds = {{bounds.low.x, bounds.low.y, bounds.low.z}, {bounds.high.x, bounds.high.y, bounds.high.z}};
    image->remembered_bytes = renderer_.remembered_bytes();
    if (request.pick) picked = pick(*scene, frame, *request.pick);
    if (picked && picked->instance) {
        picked->transform = renderer_.transform(picked->node);
        picked->world = renderer_.world_transform(picked->node);
        if (const Layer* const ids = frame.layer("id"))
            image->outline = outline_of(*ids, layer_value_of(*scene, picked->instance, *ids));
        if (request.pick) picked->pivot = pivot_of(*picked, *image);
    }
    image->picked = std::move(picked);
    // A saved frame is as without a picked object. The renderer uses the memory of other frames' layers again.
    std::erase_if(frame.layers, [&](const Layer& layer) { return !request.whole || layer.name == "id"; });
    return image;
}

// What was picked last, if that was in this scene.
std::optional<Picked> ViewSession::picked_before(const std::shared_ptr<const Scene>& scene) const
{
    const auto last = image(0);
    return last && last->scene == scene ? last->picked : std::nullopt;
}

// What is known of an image's depths from the newest one, if that shows the same: the images of a view that comes to
// rest follow one another, and those in motion have depths.
std::vector<float> ViewSession::nearness_before(const ViewImage& image) const
{
    const auto last = this->image(0);
    if (!last || last->nearness.empty() || last->scene != image.scene || !(last->camera == image.camera) ||
        last->time != image.time || last->overrides != image.overrides)
        return {};
    const int width = image.image.width, height = image.image.height;
    if (last->image.width == width && last->image.height == height) return last->nearness;
    std::vector<float> nearness;
    nearness.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        const auto row = static_cast<std::size_t>((2 * y + 1) * last->image.height / (2 * height)) *
                         static_cast<std::size_t>(last->image.width);
        for (int x = 0; x < width; ++x)
            nearness.push_back(
                last->nearness[row + static_cast<std::size_t>((2 * x + 1) * last->image.width / (2 * width))]);
    }
    return nearness;
}

void ViewSession::hand_over_overrides(const Scene& scene, const ViewRequest& request, FrameInput& input)
{
    // Hold the overridden nodes. A node that the scene does not have fails the frame here, before it is noted.
    for (const UserOverride& o : request.overrides) {
        if (!contains(held_, o.node)) {
            scene.name(o.node);
            held_.push_back(o.node);
        }
        input.transforms.push_back({o.node, o.transform(), {}});
    }
    // Release the nodes whose override ended. They stay noted until a frame has done so.
    for (const NodeId& node : held_)
        if (std::none_of(request.overrides.begin(), request.overrides.end(),
                         [&](const UserOverride& o) { return o.node == node; }))
            input.released_nodes.push_back(node);
}

Picked ViewSession::pick(const Scene& scene, const Frame& frame, const glm::vec2& place)
{
    const auto pixel = [](float fraction, int side) {
        return std::clamp(static_cast<int>(fraction * static_cast<float>(side)), 0, side - 1);
    };
    const Pick seen = renderer_.pick(pixel(place.x, frame.view_size.width), pixel(place.y, frame.view_size.height));
    Picked picked;
    if (!seen.hit) return picked;
    picked.instance = seen.instance;
    // Of objects that move together, take the node that moves them.
    picked.node = scene.moving_node(seen.instance);
    picked.name = scene.name(seen.instance);
    const Mobility mobility = scene.mobility(seen.instance);
    picked.mobility = mobility == Mobility::may_deform ? "deforms"
                      : mobility == Mobility::may_move ? "moves"
                                                       : "stands still";
    picked.position = {seen.position.x, seen.position.y, seen.position.z};
    return picked;
}

}   // namespace gnomon::viewer
