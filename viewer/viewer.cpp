// SPDX-License-Identifier: Apache-2.0
#include "viewer/viewer.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "viewer/viewer_impl.h"

namespace gnomon::viewer {

namespace {

constexpr Size k_first_size{1280, 720};
constexpr double k_step_seconds = 1.0 / 60;   // between frames of the window while something moves
constexpr double k_slow_seconds = 0.05;       // while progress is shown or text is typed, whose cursor blinks
constexpr double k_idle_seconds = 0.1;        // between checks while nothing happens

Size first_size(const ViewSettings& settings)
{
    const Size size = settings.render_options().size;
    return size.width > 0 ? size : k_first_size;
}

}   // namespace

Viewer::Impl::Impl(ViewSettings s, std::string w, int threads)
    : settings(std::move(s)),
      what(std::move(w)),
      window(first_size(settings), Panel::k_width, fmt::format("Gnomon - {}", what)),
      session(threads, ViewSession::k_rays_a_frame, glfwPostEmptyEvent)
{
}

// How long the window may wait for input and for news of the session; 0: not at all.
double Viewer::Impl::wait_seconds() const
{
    if (!input->empty() || pace.settles()) return 0;
    double seconds = k_idle_seconds;
    const bool plays = playback.playing && playback.frames > 1 && !session.busy();
    const bool sharpens = requested_divisor > 1 && !session.busy();
    if (plays || sharpens || flying || recorder.recording())
        seconds = k_step_seconds;
    else if (session.load_state().loading || ImGui::GetIO().WantTextInput)
        seconds = k_slow_seconds;
    if (pace.pending()) seconds = std::min(seconds, pace.left(Clock::now()).count());
    return seconds;
}

// One frame of the window.
// @param seconds  since the last one
void Viewer::Impl::frame(double seconds)
{
    pace.begin_frame();
    const Clock::time_point start = Clock::now();

    // Take what the session has finished: a scene, an image, an error.
    look_at_file();
    const LoadState load = session.load_state();
    if (!image && load.trouble) std::rethrow_exception(load.trouble);   // there is nothing to show
    take_scene();
    const bool new_image = take_image();
    handle_failed_frame(load);
    // A clip begins when bounced light is prepared: another time would interrupt that, again and again.
    const bool prepares = !image || image->scene != scene || image->early;
    if (!recorder.recording() && !prepares) playback.advance(seconds);

    // Handle the input, compose image and panel, and request the next image.
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    if (input->feed()) pace.touch();
    if (load.loading || ImGui::GetIO().WantTextInput) pace.touch_once();
    if (std::string news =
            fmt::format("{}|{}|{}|{}|{}", load.loading, load.error, load.frame_error, load.preparing, panel.message);
        news != shown_news) {
        shown_news = std::move(news);
        pace.touch();
    }
    ImGui::NewFrame();
    follow_mouse();
    fly(seconds);
    draw_outline();
    if (const auto shown = gizmo()) object_handles.draw(*shown, pressed < 0);
    const PanelEvents events =
        panel.draw(settings, playback, overrides, scene.get(), image.get(), load, own_camera, recorder.recording());
    if (events.options_changed) dirty = true;
    if (events.scene_changed) session.load(settings.recipe(what));
    if (events.screenshot) screenshot();
    if (events.record) toggle_recording();
    if (events.scene_camera) own_camera = false, dirty = view_jumped = true;

    // Draw the frame where it shows something new. Without a graphics card, drawing and rendering take turns on the
    // same cores: a new image is shown before the next one is requested.
    ImGui::Render();
    if (!new_image) ask();
    pace.move_view(follows_view() && !(shown_view() == drawn_view));
    if (pace.draws(new_image, Clock::now())) draw(start, new_image);
}

// @param start  of the frame
void Viewer::Impl::draw(Clock::time_point start, bool new_image)
{
    const Clock::time_point drawing = Clock::now();
    const Size size = window.framebuffer();
    glViewport(0, 0, size.width, size.height);
    glClearColor(0.08f, 0.08f, 0.09f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    draw_image();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glFinish();
    // Its time ends before the swap, which may wait for the screen.
    const Clock::time_point finished = Clock::now();
    pace.drawn(drawing, finished);
    summary.longest_ms = std::max(summary.longest_ms, 1000 * seconds_since(start));
    ++summary.window_frames;
    if (new_image) ask();   // before the swap, for the same reason
    glfwSwapBuffers(window.handle);
    const Clock::time_point shown = Clock::now();
    if (new_image) latency.show(image->request, shown), rendered.show(image->request, shown);
    if (follows_view()) latency.show_all(shown);
}

Viewer::Viewer(ViewSettings settings, std::string scene, int threads)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(scene), threads))
{
    Impl& in = *impl_;
    glfwSetWindowUserPointer(in.window.handle, &in);
    glfwSetDropCallback(in.window.handle, [](GLFWwindow* window, int count, const char** files) {
        if (count > 0) static_cast<Impl*>(glfwGetWindowUserPointer(window))->open(files[0]);
    });
    glfwSetWindowRefreshCallback(in.window.handle, [](GLFWwindow* window) {
        static_cast<Impl*>(glfwGetWindowUserPointer(window))->pace.touch();
    });
    in.window.start_ui();
    in.input.emplace(in.window.handle, [&in](int key) { in.key(key); });
}

Viewer::~Viewer() = default;

ViewSummary Viewer::run(const std::function<bool()>& stopped)
{
    Impl& in = *impl_;
    in.open(in.what);
    using Clock = Impl::Clock;
    Clock::time_point last = Clock::now();

    while (!glfwWindowShouldClose(in.window.handle) && !stopped()) {
        if (const double wait = in.wait_seconds(); wait > 0)
            glfwWaitEventsTimeout(wait);
        else
            glfwPollEvents();
        const Clock::time_point now = Clock::now();
        in.frame(std::chrono::duration<double>(now - std::exchange(last, now)).count());
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
    in.summary.latency = in.latency.summary();
    in.summary.rendered = in.rendered.summary();
    return in.summary;
}

}   // namespace gnomon::viewer
