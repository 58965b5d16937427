// SPDX-License-Identifier: Apache-2.0
#include "viewer/viewer.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "gnomon/error.h"
#include "options/option_table.h"
#include "viewer/gl_window.h"
#include "viewer/input_queue.h"
#include "viewer/object_handles.h"
#include "viewer/orbit_camera.h"
#include "viewer/panel.h"
#include "viewer/recorder.h"

namespace gnomon::viewer {

namespace {

using Clock = std::chrono::steady_clock;

constexpr Size k_first_size{1280, 720};
constexpr double k_idle_seconds = 1.0 / 60;      // between checks of the input while nothing happens
constexpr double k_look_seconds = 0.5;           // between checks whether the scene's file changed
constexpr double k_slow_ms = 45;                 // slower images in motion get fewer pixels: 20 a second and more
constexpr int k_scales[] = {1, 2, 3, 4, 6, 8};   // every second pixel in x and y, ...
constexpr double k_quick = 0.9;                  // of k_slow_ms: what the next finer image may take
constexpr float k_click_pixels = 4;              // a drag shorter than this is a click
constexpr float k_wheel = 0.9f;                  // a notch of the wheel multiplies the distance by this

constexpr ImU32 k_outline = IM_COL32(255, 196, 64, 255), k_outline_below = IM_COL32(0, 0, 0, 160);

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::filesystem::file_time_type changed_at(const std::string& file)
{
    std::error_code error;
    const auto time = std::filesystem::last_write_time(file, error);
    return error ? std::filesystem::file_time_type{} : time;
}

}   // namespace

struct Viewer::Impl {
    Impl(ViewSettings s, std::string w, int threads)
        : settings(std::move(s)),
          what(std::move(w)),
          session(threads),
          window(settings.render_options().size.width > 0 ? settings.render_options().size : k_first_size,
                 fmt::format("Gnomon - {}", what))
    {
    }

    ViewSettings settings;
    std::string what;
    ViewSession session;
    GlWindow window;
    std::optional<InputQueue> input;
    Panel panel;
    Playback playback;
    OverrideList overrides;
    OrbitCamera camera;
    Recorder recorder;
    bool own_camera = false;   // the interactive camera is in use, not the scene's
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const ViewImage> image;
    std::optional<glm::vec2> pick;
    ViewSummary summary;
    std::vector<double> image_ms;

    // The last request, to detect changes.
    double requested_time = -1;
    Size requested_size{};
    std::size_t scale = std::size(k_scales) - 1;   // of images in motion; coarse, so that the first one is quick
    int requested_scale = 1;
    std::optional<Clock::time_point> input_at;                            // the first input that no request has yet
    std::vector<std::pair<std::uint64_t, Clock::time_point>> requested;   // requests, and when their input came
    std::vector<double> latency_ms;
    bool wants_screenshot = false;
    std::uint64_t shot_request = 0, video_request = 0;   // requests for a screenshot and for the video's next frame
    Size video_size{};                                   // the window's size when the recording began
    bool dirty = true;
    std::vector<UserOverride> requested_overrides;

    bool handles = true;   // of the picked object are shown
    ObjectHandles object_handles;

    glm::vec2 pressed_at{0};
    int pressed = -1;
    bool dragged = false;
    Clock::time_point looked = Clock::now();
    std::filesystem::file_time_type file_time{};

    void open(const std::string& file)
    {
        if (file != what)
            // These names belong to the previous scene.
            for (const char* name : {"camera", "animation", "variant"})
                settings.set(*options::find_option(options::Subcommand::view, name), "");
        what = file;
        file_time = changed_at(what);
        session.load(settings.recipe(what));
        glfwSetWindowTitle(window.handle, fmt::format("Gnomon - {}", what).c_str());
    }
    void take_scene();
    void take_image();
    void adapt_scale();
    void take_camera();
    std::optional<Gizmo> gizmo() const;
    void follow_mouse();
    void fly(double seconds);
    void key(int which);
    void ask();
    void draw_image() const;
    void look_at_file();
    void screenshot();
    void toggle_recording();
    void end_recording(const std::string& why);
    void handle_failed_frame(const LoadState& load);
    struct Placed {
        glm::vec2 corner;   // top left corner of the image in the window
        float factor = 1;   // window pixels per image pixel
    };
    Placed placed() const;
    std::optional<glm::vec2> image_place(const glm::vec2& at) const;
};

// Switches to a scene that the session has loaded.
void Viewer::Impl::take_scene()
{
    const auto now = session.scene();
    if (now == scene) return;
    if (scene && recorder.recording()) end_recording("another scene was loaded");   // a video shows one scene
    scene = now;
    playback.frames = scene->frame_count();
    playback.fps = scene->fps();
    playback.frame = std::min(playback.frame, static_cast<double>(playback.frames));
    overrides.list.clear();
    shot_request = video_request = 0;   // request them again with the new scene
    requested.clear();
    input_at.reset();
    panel.picked.reset();
    object_handles.forget();
    pick.reset();
    own_camera = false;
    dirty = true;
}

// Shows the session's latest image, and saves it if a screenshot or the recording was waiting for it.
void Viewer::Impl::take_image()
{
    const auto next = session.image(image ? image->number : 0);
    if (!next) return;
    image = next;
    window.show(image->image);
    panel.add(image->times);
    image_ms.push_back(image->times.total());
    ++summary.images;
    if (image->picked && image->scene == scene) panel.picked = image->picked;
    // Note how long the input waited that this image shows.
    const Clock::time_point now = Clock::now();
    std::erase_if(requested, [&](const auto& request) {
        if (request.first > image->request) return false;
        latency_ms.push_back(std::chrono::duration<double, std::milli>(now - request.second).count());
        return true;
    });
    adapt_scale();
    // Save the image if it is the requested screenshot or the next frame of the recording.
    const bool finished = image->frame.complete && image->scene == scene;
    if (wants_screenshot && finished && image->request == shot_request) {
        wants_screenshot = false;
        const std::string file = recorder.save(image->frame);
        summary.files.push_back(file);
        panel.message = fmt::format("saved {}", file);
    }
    if (recorder.recording() && finished && image->request == video_request) {
        video_request = 0;
        if (!recorder.add(image->frame)) return end_recording("the size of the image changed");
        playback.frame = playback.frame + 1 > playback.frames ? 1 : playback.frame + 1;
        dirty = true;
    }
}

// Adapts the number of pixels of images in motion to the speed of the last one.
void Viewer::Impl::adapt_scale()
{
    if (requested_scale != k_scales[scale]) return;   // a sharper image of what stands still
    const double ms = image->times.total();
    if (ms > k_slow_ms && scale + 1 < std::size(k_scales)) ++scale;
    if (scale == 0) return;
    const double finer = static_cast<double>(k_scales[scale]) / k_scales[scale - 1];
    if (ms * finer * finer < k_quick * k_slow_ms) --scale;
}

// Switches to the interactive camera, which starts at the scene's camera.
void Viewer::Impl::take_camera()
{
    if (own_camera || !image || image->scene != scene) return;
    const Box3& bounds = image->bounds;
    float distance = glm::dot(bounds.centre() - eye_of(image->camera), forward_of(image->camera));
    const float extent = glm::length(bounds.high - bounds.low);
    if (!(distance > 0.02f * extent) || !std::isfinite(distance)) distance = std::max(0.25f * extent, 1e-3f);
    camera.follow(image->camera, image->frame.view_size, distance);
    own_camera = true;
}

// The handles at the picked object; none while nothing is picked or the image is not of what the panel describes.
std::optional<Gizmo> Viewer::Impl::gizmo() const
{
    if (!handles || !image || image->scene != scene || recorder.recording() || !panel.picked ||
        !panel.picked->instance || image->outline.empty())
        return std::nullopt;
    const Placed place = placed();
    const glm::vec2 corner = place.corner + place.factor * glm::vec2(image->frame.view_left, image->frame.view_top);
    const glm::vec2 size = place.factor * glm::vec2(image->frame.view_size.width, image->frame.view_size.height);
    return Gizmo(image->camera, pivot_of(*panel.picked), corner, size);
}

void Viewer::Impl::follow_mouse()
{
    const ImGuiIO& io = ImGui::GetIO();
    const glm::vec2 at(io.MousePos.x, io.MousePos.y);
    if (pressed < 0 && object_handles.follow(gizmo(), panel, overrides)) return;

    // Zoom with the wheel; note where a button went down.
    if (!io.WantCaptureMouse && scene) {
        for (int button = 0; button < 3; ++button)
            if (ImGui::IsMouseClicked(button)) pressed = button, pressed_at = at, dragged = false;
        if (io.MouseWheel != 0) {
            take_camera();
            camera.zoom(std::pow(k_wheel, io.MouseWheel));
            dirty = true;
        }
    }
    if (pressed < 0) return;

    // Pick an object at a click.
    if (!ImGui::IsMouseDown(pressed)) {
        if (pressed == 0 && !dragged && image) {
            pick = image_place(at);
            dirty = dirty || pick;
        }
        pressed = -1;
        return;
    }

    // Move the camera with a drag.
    if (glm::length(at - pressed_at) > k_click_pixels) dragged = true;
    if (!dragged || (io.MouseDelta.x == 0 && io.MouseDelta.y == 0)) return;
    take_camera();
    if (!own_camera) return;
    const float across = io.MouseDelta.x / io.DisplaySize.y, down = io.MouseDelta.y / io.DisplaySize.y;
    constexpr float k_turn = 4;   // radians per height of the window
    if (pressed == 1)
        camera.look(0.5f * k_turn * across, -0.5f * k_turn * down);
    else if (pressed == 2 || io.KeyShift)
        camera.pan(across, -down);
    else
        camera.orbit(k_turn * across, -k_turn * down);
    dirty = true;
}

void Viewer::Impl::fly(double seconds)
{
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureKeyboard || io.KeyCtrl || !scene) return;
    const auto down = [&](int key) { return io.KeysDown[key] ? 1.0f : 0.0f; };
    const float forward = down(GLFW_KEY_W) - down(GLFW_KEY_S), right = down(GLFW_KEY_D) - down(GLFW_KEY_A),
                up = down(GLFW_KEY_E) - down(GLFW_KEY_Q);
    if (forward == 0 && right == 0 && up == 0) return;
    take_camera();
    if (!own_camera) return;
    const float step = 0.8f * camera.distance() * static_cast<float>(std::min(seconds, 0.1)) * (io.KeyShift ? 4 : 1);
    camera.fly(step * forward, step * right, step * up);
    dirty = true;
}

void Viewer::Impl::key(int which)
{
    if (const auto side = OrbitCamera::side_of(which)) {   // GLFW's codes of digits are their characters
        take_camera();
        camera.look_from(*side);
        dirty = true;
    }
    const options::Option* const overlay = options::find_option(options::Subcommand::view, "overlay");
    switch (which) {
        case GLFW_KEY_ESCAPE:
            // End a drag or close an open list first, then the window.
            if (object_handles.dragged())
                object_handles.cancel(overrides);
            else if (ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup))
                ImGui::SetWindowFocus(nullptr);
            else
                glfwSetWindowShouldClose(window.handle, GLFW_TRUE);
            break;
        case GLFW_KEY_SPACE:
            playback.playing = !playback.playing;
            break;
        case GLFW_KEY_LEFT:
            playback.step(-1);
            break;
        case GLFW_KEY_RIGHT:
            playback.step(1);
            break;
        case GLFW_KEY_HOME:
            playback.go(1);
            break;
        case GLFW_KEY_END:
            playback.go(playback.frames);
            break;
        case GLFW_KEY_TAB:
            panel.shown = !panel.shown;
            break;
        case GLFW_KEY_H:
            panel.help = !panel.help;
            break;
        case GLFW_KEY_G:
            handles = !handles;
            break;
        case GLFW_KEY_C:
        case GLFW_KEY_ENTER:
            own_camera = false;
            dirty = true;
            break;
        case GLFW_KEY_F:
            if (!panel.picked || !panel.picked->instance) break;
            take_camera();
            camera.aim(panel.picked->position);
            dirty = true;
            break;
        case GLFW_KEY_O: {
            const char* const other =
                settings.render_options().renderer == RenderMethod::raster ? "redrawn" : "shadow-states";
            panel.message = settings.set(*overlay, settings.values().given("overlay") ? "" : other);
            dirty = true;
            break;
        }
        case GLFW_KEY_UP:
            session.load(settings.recipe(what));
            break;
        case GLFW_KEY_P:
        case GLFW_KEY_F12:
            screenshot();
            break;
        case GLFW_KEY_R:
            toggle_recording();
            break;
        default:
            break;
    }
}

// Requests the next image from the session if anything changed, or a sharper one if nothing did.
void Viewer::Impl::ask()
{
    if (!scene) return;
    // Record whole frames of one size, whatever the user does with the slider and the window.
    if (recorder.recording()) playback.frame = std::floor(playback.frame);
    const Size size = recorder.recording() ? video_size : window.framebuffer();
    if (size.width < 1 || size.height < 1) return;   // iconified
    const double time = playback.time(*scene);
    const bool moved =
        dirty || time != requested_time || !(size == requested_size) || overrides.list != requested_overrides;
    const bool sharper = !moved && requested_scale > 1;
    const bool whole = recorder.recording() || wants_screenshot;
    if (!moved && !sharper) return;
    // What a scene's first image waits for is no input.
    const bool asked = dirty || overrides.list != requested_overrides;
    if (asked && !whole && !input_at && image && image->scene == scene) input_at = Clock::now();
    // Send one request at a time and let each finish, because every frame fills caches for the next. A sharper image
    // of what is shown need not finish, so that a drag never waits for it.
    if (session.busy() && !(moved && session.interruptible())) return;
    // Delay the recording while images are rendered faster than written, so that they do not fill the memory.
    if (recorder.recording() && recorder.behind()) return;

    // Describe the frame.
    ViewRequest request;
    request.scene = scene;
    request.options = settings.render_options();
    request.time = time;
    request.camera = request.options.camera;
    request.overrides = overrides.list;
    if (request.options.turntable_seconds > 0)
        request.turn = 2 * k_pi * ((playback.frame - 1) / playback.fps / request.options.turntable_seconds);
    request.whole = whole;
    request.interruptible = sharper;
    requested_scale = whole ? 1 : sharper ? requested_scale / 2 : k_scales[scale];
    request.size = {std::max(size.width / requested_scale, 16), std::max(size.height / requested_scale, 16)};
    if (own_camera) request.orbit = camera.camera();
    request.pick = std::exchange(pick, std::nullopt);

    // Remember the request, and send it.
    requested_time = time;
    requested_size = size;
    requested_overrides = overrides.list;
    dirty = false;
    const std::uint64_t number = session.ask(std::move(request));
    if (input_at) requested.emplace_back(number, *input_at);
    input_at.reset();
    if (wants_screenshot) shot_request = number;
    if (recorder.recording()) video_request = number;
}

// Centres the image in the window, as large as possible. Its shape may differ from the window's because an overlay has
// a legend and a video keeps its size.
Viewer::Impl::Placed Viewer::Impl::placed() const
{
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const glm::vec2 size(image->image.width, image->image.height);
    const float factor = std::min(display.x / size.x, display.y / size.y);
    return {(glm::vec2(display.x, display.y) - factor * size) / 2.0f, factor};
}

// Converts a position in the window to fractions of the view's width and height; none outside the view, such as on a
// legend.
std::optional<glm::vec2> Viewer::Impl::image_place(const glm::vec2& at) const
{
    const Placed place = placed();
    const Frame& frame = image->frame;
    const glm::vec2 fraction = ((at - place.corner) / place.factor - glm::vec2(frame.view_left, frame.view_top)) /
                               glm::vec2(frame.view_size.width, frame.view_size.height);
    if (!(fraction.x >= 0 && fraction.y >= 0 && fraction.x < 1 && fraction.y < 1)) return std::nullopt;
    return fraction;
}

void Viewer::Impl::draw_image() const
{
    if (!image) return;
    const Placed place = placed();
    const glm::vec2 end = place.corner + place.factor * glm::vec2(image->image.width, image->image.height);
    ImDrawList* const draw = ImGui::GetBackgroundDrawList();
    draw->AddImage(window.texture(), {place.corner.x, place.corner.y}, {end.x, end.y});
    if (image->scene != scene || recorder.recording()) return;

    // Outline the picked object: dark below bright, to be seen before anything.
    const glm::vec2 corner = place.corner + place.factor * glm::vec2(image->frame.view_left, image->frame.view_top);
    for (const auto& [color, width] : {std::pair{k_outline_below, 3.0f}, std::pair{k_outline, 1.0f}})
        for (const OutlineEdge& edge : image->outline) {
            const glm::vec2 from = corner + place.factor * glm::vec2(edge.from);
            const glm::vec2 to = corner + place.factor * glm::vec2(edge.to);
            const float more = 0.5f * width;   // closes corners
            draw->AddRectFilled({from.x - more, from.y - more}, {to.x + more, to.y + more}, color);
        }
}

// Loads the scene's file again when it has changed.
void Viewer::Impl::look_at_file()
{
    if (seconds_since(looked) < k_look_seconds || what.starts_with("builtin:")) return;
    looked = Clock::now();
    const auto now = changed_at(what);
    if (now == file_time || now == std::filesystem::file_time_type{}) return;
    file_time = now;
    session.load(settings.recipe(what));
}

void Viewer::Impl::screenshot()
{
    wants_screenshot = dirty = true;
    shot_request = 0;
}

void Viewer::Impl::toggle_recording()
{
    if (recorder.recording()) return end_recording({});
    if (!scene) {   // the scene determines the frame rate
        panel.message = "the scene is still loading; record when it is shown";
        return;
    }
    panel.message = recorder.start(playback.fps);
    if (!panel.message.empty()) return;
    panel.message = "recording every frame of the clip; press R to stop";
    video_size = window.framebuffer();
    video_request = 0;   // ignore images that were requested before
    playback.playing = false;
    dirty = true;
}

/// @param why  the reason; empty if the user stopped the recording
void Viewer::Impl::end_recording(const std::string& why)
{
    const std::string file = recorder.stop();
    if (!file.empty()) summary.files.push_back(file);
    panel.message = file.empty() ? "nothing was recorded" : fmt::format("encoding {}", file);
    if (!why.empty()) panel.message = fmt::format("recording ended: {}; {}", why, panel.message);
}

// Ends the recording or cancels the screenshot whose frame failed.
void Viewer::Impl::handle_failed_frame(const LoadState& load)
{
    if (load.failed == 0) return;
    if (recorder.recording() && load.failed == video_request) end_recording("a frame failed");
    if (load.failed == shot_request) wants_screenshot = false;
}

Viewer::Viewer(ViewSettings settings, std::string scene, int threads)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(scene), threads))
{
    Impl& in = *impl_;
    glfwSetWindowUserPointer(in.window.handle, &in);
    glfwSetDropCallback(in.window.handle, [](GLFWwindow* window, int count, const char** files) {
        if (count > 0) static_cast<Impl*>(glfwGetWindowUserPointer(window))->open(files[0]);
    });
    in.window.start_ui();
    in.input.emplace(in.window.handle, [&in](int key) { in.key(key); });
}

Viewer::~Viewer() = default;

ViewSummary Viewer::run(const std::function<bool()>& stopped)
{
    Impl& in = *impl_;
    in.open(in.what);
    Clock::time_point last = Clock::now();

    // One frame of the window.
    while (!glfwWindowShouldClose(in.window.handle) && !stopped()) {
        // Wait for input while nothing plays or loads.
        const bool calm =
            !in.playback.playing && !in.session.busy() && !in.session.load_state().loading && in.input->empty();
        if (calm)
            glfwWaitEventsTimeout(k_idle_seconds);
        else
            glfwPollEvents();
        const Clock::time_point start = Clock::now();
        const double seconds = std::chrono::duration<double>(start - last).count();
        last = start;

        // Take what the session has finished: a scene, an image, an error.
        in.look_at_file();
        const LoadState load = in.session.load_state();
        if (!in.image && load.trouble) std::rethrow_exception(load.trouble);   // there is nothing to show
        in.take_scene();
        in.take_image();
        in.handle_failed_frame(load);
        if (!in.recorder.recording()) in.playback.advance(seconds);

        // Handle the input, draw image and panel, and request the next image.
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        in.input->feed();
        ImGui::NewFrame();
        in.follow_mouse();
        in.fly(seconds);
        in.draw_image();
        if (const auto gizmo = in.gizmo()) in.object_handles.draw(*gizmo, in.pressed < 0);
        const PanelEvents events = in.panel.draw(in.settings, in.playback, in.overrides, in.scene.get(), in.image.get(),
                                                 load, in.own_camera, in.recorder.recording());
        if (events.options_changed) in.dirty = true;
        if (events.scene_changed) in.session.load(in.settings.recipe(in.what));
        if (events.screenshot) in.screenshot();
        if (events.record) in.toggle_recording();
        if (events.scene_camera) in.own_camera = false, in.dirty = true;
        in.ask();

        // Present the frame. Its time ends before the swap, which may wait for the screen.
        ImGui::Render();
        const Size size = in.window.framebuffer();
        glViewport(0, 0, size.width, size.height);
        glClearColor(0.08f, 0.08f, 0.09f, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        in.summary.longest_ms = std::max(in.summary.longest_ms, 1000 * seconds_since(start));
        ++in.summary.window_frames;
        glfwSwapBuffers(in.window.handle);
        if (seconds_since(start) < 0.002)
            glfwWaitEventsTimeout(k_idle_seconds / 2);   // the swap does not wait on every screen
    }

    // Finish the recording, and summarise.
    if (in.recorder.recording()) in.end_recording({});
    in.recorder.finish();
    in.summary.options_set = in.panel.options_set;
    in.summary.frozen = in.panel.frozen;
    in.summary.moved = in.panel.moved;
    in.summary.loads = in.session.load_state().loads;
    if (!in.image_ms.empty()) {
        const auto middle = in.image_ms.begin() + static_cast<std::ptrdiff_t>(in.image_ms.size() / 2);
        std::nth_element(in.image_ms.begin(), middle, in.image_ms.end());
        in.summary.median_image_ms = *middle;
    }
    if (!in.latency_ms.empty()) {
        std::sort(in.latency_ms.begin(), in.latency_ms.end());
        in.summary.latency = {in.latency_ms.size(), in.latency_ms[in.latency_ms.size() / 2], in.latency_ms.back()};
    }
    return in.summary;
}

}   // namespace gnomon::viewer
