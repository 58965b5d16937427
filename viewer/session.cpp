// SPDX-License-Identifier: Apache-2.0
#include "viewer/session.h"

#include <fmt/format.h>

#include <chrono>
#include <tuple>

#include "frame/cluster_overlay.h"
#include "frame/rasterizer.h"
#include "frame/state_overlay.h"
#include "gnomon/error.h"
#include "image/tone_map.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "ray/ray_scene.h"
#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "trace/indirect_grid.h"
#include "trace/traced_frame.h"

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

bool shows_clusters(const RenderOptions& options)
{
    return options.overlay == Overlay::clusters && options.indirect == Indirect::quadtree;
}

// What bounced light is made with.
auto of_bounce(const RenderOptions& o)
{
    return std::tuple(o.indirect, o.rsm_samples, o.indirect_level, o.depth_threshold, o.normal_threshold,
                      o.indirect_at_every_pixel, o.indirect_memory, o.indirect_on);
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

struct ViewSession::Kept {
    explicit Kept(int threads) : tasks(threads) {}

    Tasks tasks;
    std::shared_ptr<const Scene> owner;   // of what follows
    std::unique_ptr<scene::SceneState> state;
    std::unique_ptr<ray::RayScene> rays;
    Accelerator accelerator = Accelerator::embree;
    std::unique_ptr<shadow_culling::CertifiedCulling> certified;
    std::unique_ptr<shadow_culling::PaperCulling> paper;
    std::unique_ptr<irradiance_cache::IrradianceCache> visible;
    std::unique_ptr<light_quadtree::MapLight> map;
    RenderOptions map_options;   // that it, or the rasteriser, was made with
    int visible_memory = 0;      // likewise `visible`
    std::unique_ptr<frame::Rasterizer> raster;
    ShadowTextures raster_shadows{};   // it was made for this, and what follows
    int raster_filter = 0, raster_samples = 0;
    bool raster_redrawn = false;
    std::vector<HandMoved> hands;
    std::unordered_map<scene::NodeId, glm::dmat4> held;   // by node that a hand holds: its own transform when taken
    shading::FrameBuffers buffers;
    trace::StateMap states;
    std::optional<glm::vec3> turn_centre;   // of `owner`

    void forget()
    {
        turn_centre.reset();
        certified.reset();
        paper.reset();
        visible.reset();
        map.reset();
        raster.reset();
        rays.reset();
        state.reset();
        hands.clear();
        held.clear();
        owner.reset();
    }

    // Whatever fits the options is kept, all else is dropped or made.
    void follow_options(const RenderOptions& options)
    {
        if (options.renderer == RenderMethod::raster) {
            // What is not asked in every frame misses what changes.
            certified.reset();
            paper.reset();
            visible.reset();
            map.reset();
            follow_raster(options);
            return;
        }
        raster.reset();
        if (options.shadow_culling != ShadowCulling::certified) certified.reset();
        if (options.shadow_culling != ShadowCulling::paper) paper.reset();
        if (options.indirect != Indirect::visible || options.indirect_memory != visible_memory) visible.reset();
        if (of_bounce(options) != of_bounce(map_options) || options.overlay == Overlay::shadow_states) map.reset();
        const bool wants_map = options.indirect == Indirect::rsm || options.indirect == Indirect::quadtree;
        if (wants_map && !map && options.overlay != Overlay::shadow_states) {
            map = std::make_unique<light_quadtree::MapLight>(*state, *rays, trace::map_light_options(options), tasks);
            map_options = options;
        }
        // A memory of shadows follows every frame or none.
        if (shows_clusters(options)) {
            certified.reset();
            paper.reset();
            return;
        }
        if (options.shadow_culling == ShadowCulling::certified && !certified && !state->scene().lights.empty())
            certified =
                std::make_unique<shadow_culling::CertifiedCulling>(*state, *rays, shadow_culling::CertifiedOptions{});
        if (options.shadow_culling == ShadowCulling::paper && !paper)
            paper = std::make_unique<shadow_culling::PaperCulling>(*state, *rays);
        if (options.indirect == Indirect::visible && !visible) {
            visible = std::make_unique<irradiance_cache::IrradianceCache>(*state, *rays,
                                                                          trace::visible_light_options(options), tasks);
            visible_memory = options.indirect_memory;
        }
    }

    void follow_raster(const RenderOptions& options)
    {
        const bool redrawn = options.overlay == Overlay::redrawn && options.shadow_textures != ShadowTextures::off &&
                             !state->scene().lights.empty();
        if (raster && raster_shadows == options.shadow_textures && raster_filter == options.shadow_filter &&
            raster_samples == options.samples && raster_redrawn == redrawn &&
            of_bounce(options) == of_bounce(map_options)) {
            raster->update(*state);
            return;
        }
        raster.reset();   // a device may hold one of them, and not two
        raster = frame::make_rasterizer(*state, {.samples = options.samples,
                                                 .shadows = options.shadow_textures,
                                                 .shadow_filter = static_cast<float>(options.shadow_filter),
                                                 .redrawn = redrawn,
                                                 .redrawn_stays = true,
                                                 .indirect = options.indirect,
                                                 .map = trace::map_light_options(options),
                                                 .visible = trace::visible_light_options(options),
                                                 .indirect_on = options.indirect_on,
                                                 .rays = rays.get(),
                                                 .tasks = &tasks});
        raster_shadows = options.shadow_textures;
        raster_filter = options.shadow_filter;
        raster_samples = options.samples;
        raster_redrawn = redrawn;
        map_options = options;
    }

    void follow_hands(std::vector<HandMoved> wanted)
    {
        std::erase_if(wanted, [&](const HandMoved& hand) { return hand.node >= state->scene().nodes.size(); });
        if (wanted == hands) return;
        for (const HandMoved& hand : hands) state->override_transform(hand.node, nullptr);
        for (const HandMoved& hand : wanted) {
            if (!held.contains(hand.node)) held[hand.node] = local_of(hand.node);
            glm::dmat4 local = held[hand.node];
            local[3] += glm::dvec4(hand.offset, 0);
            state->override_transform(hand.node, &local);
        }
        std::erase_if(held, [&](const auto& entry) {
            return std::none_of(wanted.begin(), wanted.end(),
                                [&](const HandMoved& h) { return h.node == entry.first; });
        });
        hands = std::move(wanted);
    }

    // Of its track. Not from where it is: its parent may be squeezed to nothing.
    glm::dmat4 local_of(scene::NodeId n) const
    {
        const scene::Node& node = state->scene().nodes[n];
        return node.transform ? node.transform->evaluate(state->time()) : node.local;
    }
};

ViewSession::ViewSession(int threads, std::uint64_t rays_a_frame)
    : threads_(threads), rays_a_frame_(rays_a_frame), kept_(std::make_unique<Kept>(threads))
{
    loader_ = std::jthread([this](const std::stop_token& stop) { load_loop(stop); });
    renderer_ = std::jthread([this](const std::stop_token& stop) { render_loop(stop); });
}

ViewSession::~ViewSession()
{
    leaving_ = true;   // a frame under way ends at its next tile
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
    // A question is not lost when its frame is overtaken.
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
                // Bounced light that the frame had no time for: the same frame again, unless another is wanted.
                if (refining_) {
                    request.pick.reset();   // answered
                    request_ = std::move(request);
                    continue;
                }
            }
            // No frame waits for certificates: they are made while nobody wants one.
            if (kept_->certified)
                kept_->certified->judge(kept_->tasks, [&] {
                    const std::lock_guard lock(mutex_);
                    return !request_ && !leaving_;
                });
        } catch (const std::exception& e) {
            kept_->forget();   // half a frame would be remembered
            fail(number, e.what());
        }
    }
}

std::shared_ptr<ViewImage> ViewSession::render(const std::shared_ptr<const Scene>& scene, const ViewRequest& request)
{
    Kept& kept = *kept_;
    const RenderOptions& options = request.options;
    auto image = std::make_shared<ViewImage>();
    image->scene = scene;
    image->request = request.number;
    Clock::time_point start = Clock::now();
    const auto end_stage = [&](int stage) {
        image->times.ms[stage] = milliseconds_since(start);
        start = Clock::now();
    };

    if (scene != kept.owner || options.accelerator != kept.accelerator) {
        kept.forget();
        kept.state = std::make_unique<scene::SceneState>(scene->inside(), request.time);
        kept.rays = std::make_unique<ray::RayScene>(*kept.state);
        if (options.accelerator == Accelerator::kdtree) kept.rays->trace_on_kdtree(*kept.state);
        kept.owner = scene;
        kept.accelerator = options.accelerator;
    }
    kept.follow_hands(request.hands);
    kept.state->advance(request.time);
    end_stage(0);
    kept.rays->update(*kept.state);
    kept.follow_options(options);
    if (kept.visible) kept.visible->limit_rays(request.whole ? 0 : rays_a_frame_);
    end_stage(1);

    image->eye =
        request.eye ? *request.eye
                    : scene::make_view(*kept.state, scene::find_camera(*scene->inside(), request.camera), request.size);
    if (!request.eye && request.turn != 0) {
        if (!kept.turn_centre) kept.turn_centre = scene->inside()->bounds(scene->inside()->timeline.start).centre();
        image->eye = scene::turned(image->eye, *kept.turn_centre, request.turn);
    }

    const bool states = !kept.raster && options.overlay == Overlay::shadow_states && !scene->inside()->lights.empty() &&
                        options.shadow_culling != ShadowCulling::off;
    trace::TracedOptions traced;
    traced.max_depth = options.max_depth;
    traced.samples = options.samples;
    trace::Remembered remembered(kept.certified.get());
    remembered.judge_later = true;
    remembered.paper = kept.paper.get();
    remembered.visible = states ? nullptr : kept.visible.get();
    remembered.map = states ? nullptr : kept.map.get();
    if (states) {
        const int last = static_cast<int>(scene->inside()->lights.size()) - 1;
        kept.states.lights = {std::min(options.overlay_light.value_or(0), last)};
        remembered.states = &kept.states;
    }
    // Light that is not asked for under the overlay is not to miss what moves meanwhile.
    if (states && kept.visible) kept.visible->update(*kept.state, *kept.rays, kept.tasks);
    const Progress progress = [this](const ProgressStep&) { return !leaving_; };
    const bool clusters = kept.map && shows_clusters(options);
    if (clusters)
        kept.map->begin_frame(*kept.state, *kept.rays, kept.tasks);
    else
        image->counters = kept.raster ? kept.raster->render(*kept.state, image->eye, kept.buffers, progress)
                                      : trace::trace_frame(*kept.state, *kept.rays, image->eye, traced, kept.tasks,
                                                           kept.buffers, remembered, nullptr, progress);
    end_stage(2);

    if (clusters) {
        image->image = frame::paint_clusters(*scene->inside(), *kept.rays, image->eye, *kept.map, kept.tasks);
    } else if (states) {
        image->image = frame::paint_states(kept.states, {fmt::format("light {}", kept.states.lights[0])},
                                           options.shadow_culling == ShadowCulling::paper);
        const frame::PanelPlace place = frame::panel_place(image->eye.size, 1, 0);
        image->corner = {place.left, place.top};
    } else {
        ImageF& color = kept.buffers.color;
        image->image = Image8(color.width, color.height, 3);
        const double exposure = options.exposure ? *options.exposure : image::auto_exposure(color.data);
        if (kept.raster && kept.raster_redrawn) {
            kept.raster->paint_redrawn(exposure, color);
            image::encode_srgb8(color.data, 0, ToneMap::none, image->image.data);
        } else {
            image::encode_srgb8(color.data, exposure, options.tonemap, image->image.data);
        }
    }
    end_stage(3);

    image->complete = !remembered.visible || !remembered.visible->lacks_points();
    image->time = request.time;
    image->bounds = kept.rays->bounds();
    if (kept.certified) image->remembered_bytes += kept.certified->bytes();
    if (kept.visible) image->remembered_bytes += kept.visible->bytes();
    if (kept.map) image->remembered_bytes += kept.map->bytes();
    if (kept.raster) image->remembered_bytes += kept.raster->remembered_bytes();
    if (request.pick) {
        ray::RayQueue queue;
        glm::vec3 origin, direction;
        float near = 0, far = 0;
        image->eye.ray(request.pick->x, request.pick->y, origin, direction, near, far);
        queue.push(origin, near, direction, far);
        ray::Hits hits;
        hits.resize(1);
        kept.rays->closest(queue, 0, 1, hits, ray::Sides::front);
        Picked& picked = image->picked.emplace();
        picked.object = hits.object[0];
        if (picked.object != scene::none) {
            const scene::Object& object = scene->inside()->objects[picked.object];
            // What moves together is taken by what moves it.
            picked.node = object.group == scene::none ? object.node : scene->inside()->groups[object.group].anchor;
            picked.name = scene->inside()->nodes[object.node].name;
            picked.mobility = object.deforming ? "deforms" : object.dynamic ? "moves" : "stands still";
            picked.position = origin + hits.t[0] * direction;
        }
    }
    return image;
}

}   // namespace gnomon::viewer
