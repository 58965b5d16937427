// SPDX-License-Identifier: Apache-2.0
#include "viewer/session.h"

#include <fmt/format.h>

#include <chrono>

#include "api/scene_access.h"
#include "frame/frame_engine.h"
#include "frame/state_overlay.h"
#include "gnomon/error.h"
#include "image/tone_map.h"

namespace gnomon::viewer {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::filesystem::file_time_type time_of_file(const std::string& what)
{
    std::error_code error;
    const auto time = std::filesystem::last_write_time(what, error);
    return error ? std::filesystem::file_time_type{} : time;
}

// The viewer shows images within about 50 ms: certificates are made between frames, and objects can be picked.
constexpr frame::EngineSettings settings(int threads)
{
    return {.threads = threads,
            .culls_first_frame = true,
            .defers_certificates = true,
            .always_has_rays = true,
            .redrawn_stays = true};
}

// Encodes the image of a frame for the screen, and finds where the view lies in it.
void encode(frame::FrameEngine& engine, const RenderOptions& options, int overlay_light, ViewImage& out)
{
    const frame::Shown shown = engine.shown();
    if (shown == frame::Shown::clusters || shown == frame::Shown::shadow_states) {
        out.image = engine.paint_overlay({fmt::format("light {}", overlay_light)});
        if (shown == frame::Shown::clusters) return;
        const frame::PanelPlace place = frame::panel_place(out.eye.size, 1, 0);
        out.corner = {place.left, place.top};
        return;
    }
    const ImageF& color = engine.buffers().color;
    out.image = Image8(color.width, color.height, 3);
    const double exposure = options.exposure ? *options.exposure : image::auto_exposure(color.data);
    if (shown == frame::Shown::redrawn) {
        engine.paint_redrawn(exposure);
        image::encode_srgb8(color.data, 0, ToneMap::none, out.image.data);
    } else {
        image::encode_srgb8(color.data, exposure, options.tonemap, out.image.data);
    }
}

Picked describe(const scene::Scene& scene, const frame::PickedPoint& point)
{
    Picked picked;
    picked.object = point.object;
    if (picked.object == scene::none) return picked;
    const scene::Object& object = scene.objects[picked.object];
    // Of objects that move together, take the node that moves them.
    picked.node = object.group == scene::none ? object.node : scene.groups[object.group].anchor;
    picked.name = scene.nodes[object.node].name;
    picked.mobility = object.deforming ? "deforms" : object.dynamic ? "moves" : "stands still";
    picked.position = point.position;
    return picked;
}

}   // namespace

const char* ViewTimes::name(int stage)
{
    static constexpr const char* k_names[k_stages] = {"scene", "trees", "light", "picture"};
    return k_names[stage];
}

double ViewTimes::total() const
{
    double sum = 0;
    for (const double stage : ms) sum += stage;
    return sum;
}

ViewSession::ViewSession(int threads, std::uint64_t rays_a_frame)
    : threads_(threads), rays_a_frame_(rays_a_frame), engine_(std::make_unique<frame::FrameEngine>(settings(threads)))
{
    loader_ = std::jthread([this](const std::stop_token& stop) { load_loop(stop); });
    renderer_ = std::jthread([this](const std::stop_token& stop) { render_loop(stop); });
}

ViewSession::~ViewSession()
{
    leaving_ = true;   // interrupts a frame at its next tile
}

void ViewSession::load(const SceneRecipe& recipe)
{
    const std::lock_guard lock(mutex_);
    wanted_ = recipe;
    state_.loading = true;
    state_.file = recipe.what;
    state_.stage = "loading";
    state_.done = 0;
    state_.error.clear();
    state_.trouble = nullptr;
    to_load_.notify_one();
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
    request.number = ++asked_;
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

void ViewSession::fail(std::uint64_t request, const std::string& message)
{
    const std::lock_guard lock(mutex_);
    state_.frame_error = message;
    state_.failed = request;
    state_.trouble = std::current_exception();
}

void ViewSession::load_loop(const std::stop_token& stop)
{
    for (;;) {
        SceneRecipe recipe;
        {
            std::unique_lock lock(mutex_);
            if (!to_load_.wait(lock, stop, [&] { return wanted_.has_value(); })) return;
            recipe = *wanted_;
            wanted_.reset();
        }
        const auto overtaken = [&] {
            const std::lock_guard lock(mutex_);
            return stop.stop_requested() || wanted_;
        };
        const Progress progress = [&](const ProgressStep& step) {
            const std::lock_guard lock(mutex_);
            state_.stage = step.stage;
            state_.done = step.done;
            return !stop.stop_requested() && !wanted_;
        };
        std::string error;
        std::exception_ptr trouble;
        try {
            const auto time = time_of_file(recipe.what);
            if (!loaded_ || loaded_file_ != recipe.what || loaded_time_ != time) {
                loaded_ = gnomon::load(recipe.what, {.progress = progress, .threads = threads_});
                loaded_file_ = recipe.what;
                loaded_time_ = time;
            }
            Scene made = *loaded_;
            if (recipe.fps > 0) made = made.at_rate(recipe.fps);
            if (!recipe.light_specs.empty()) made = made.with_light_specs(recipe.light_specs);
            if (recipe.lights) made = made.with_lights(*recipe.lights);
            if (!recipe.environment.empty()) made = made.with_environment(recipe.environment);
            const std::lock_guard lock(mutex_);
            scene_ = std::make_shared<const Scene>(std::move(made));
            ++state_.loads;
        } catch (const InterruptedError&) {
            if (overtaken()) continue;
        } catch (const std::exception& e) {
            error = e.what();
            trouble = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        if (wanted_) continue;
        state_.loading = false;
        state_.error = error;
        state_.trouble = trouble;
    }
}

void ViewSession::render_loop(const std::stop_token& stop)
{
    for (;;) {
        ViewRequest request;
        std::shared_ptr<const Scene> scene;
        {
            std::unique_lock lock(mutex_);
            rendering_ = false;
            refining_ = refining_ && request_;
            if (!to_render_.wait(lock, stop, [&] { return request_ && scene_; })) return;
            request = std::move(*request_);
            request_.reset();
            scene = scene_;
            rendering_ = true;
        }
        const std::uint64_t number = request.number;
        if (request.scene != scene) {
            request.eye.reset();
            request.camera = "auto";
            request.hands.clear();
            request.pick.reset();
        }
        try {
            auto image = render(scene, request);
            {
                const std::lock_guard lock(mutex_);
                image->number = image_ ? image_->number + 1 : 1;
                if (!image->picked && image_ && image_->scene == scene) image->picked = image_->picked;
                const bool lacking = !image->complete;
                image_ = std::move(image);
                rendering_ = false;
                state_.frame_error.clear();
                state_.failed = 0;
                if (!request_) refining_ = lacking && scene == scene_;
                // Render the same frame again for the light that is missing, unless another is requested.
                if (refining_) {
                    request.pick.reset();   // answered
                    request_ = std::move(request);
                    continue;
                }
            }
            // Make certificates until the next request comes.
            engine_->make_certificates([&] {
                const std::lock_guard lock(mutex_);
                return !request_ && !leaving_;
            });
        } catch (const std::exception& e) {
            engine_->forget();   // the caches may have taken half a frame
            fail(number, e.what());
        }
    }
}

std::shared_ptr<ViewImage> ViewSession::render(const std::shared_ptr<const Scene>& scene, const ViewRequest& request)
{
    const scene::Scene& inside = *api::scene_of(*scene);
    RenderOptions options = request.options;
    options.layers = false;   // not shown
    options.reference.reset();
    auto image = std::make_shared<ViewImage>();
    image->scene = scene;
    image->request = request.number;
    image->time = request.time;

    // Advance the scene.
    std::vector<frame::UserOverride> overrides;
    for (const HandMoved& hand : request.hands) overrides.push_back({hand.node, hand.offset});
    const frame::AdvanceTimes advanced = engine_->advance(api::scene_of(*scene), request.time, options, overrides);
    image->times.ms[0] = advanced.scene;
    image->times.ms[1] = advanced.caches;

    // Render the view.
    Clock::time_point start = Clock::now();
    std::optional<double> turn;
    if (request.turn != 0) turn = request.turn;
    image->eye =
        request.eye ? *request.eye : engine_->make_view(scene::find_camera(inside, request.camera), request.size, turn);
    const int last_light = static_cast<int>(inside.lights.size()) - 1;
    const int overlay_light = std::min(options.overlay_light.value_or(0), last_light);
    const frame::RenderRequest what{.overlay_lights = {overlay_light},
                                    .indirect_ray_limit = request.whole ? 0 : rays_a_frame_};
    image->counters = engine_->render(image->eye, what, [this](const ProgressStep&) { return !leaving_; });
    image->times.ms[2] = milliseconds_since(start);

    start = Clock::now();
    encode(*engine_, options, overlay_light, *image);
    image->times.ms[3] = milliseconds_since(start);

    image->complete = engine_->complete();
    image->bounds = engine_->rays().bounds();
    image->remembered_bytes = engine_->cached_bytes();
    if (request.pick) {
        const Size size = image->eye.size;
        const glm::ivec2 pixel = glm::clamp(glm::ivec2(glm::floor(*request.pick)), glm::ivec2(0),
                                            glm::ivec2(size.width - 1, size.height - 1));
        image->picked = describe(inside, engine_->hit_at(image->eye, pixel));
    }
    return image;
}

}   // namespace gnomon::viewer
