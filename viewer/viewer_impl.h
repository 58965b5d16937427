// SPDX-License-Identifier: Apache-2.0
#pragma once
// The viewer's state: viewer.cpp runs the window, viewer_input.cpp follows mouse and keys, viewer_images.cpp requests
// images and shows them, viewer_files.cpp watches the scene's file and saves images.

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/clip_pace.h"
#include "viewer/gl_window.h"
#include "viewer/input_queue.h"
#include "viewer/latency.h"
#include "viewer/motion_size.h"
#include "viewer/object_handles.h"
#include "viewer/orbit_camera.h"
#include "viewer/panel.h"
#include "viewer/recorder.h"
#include "viewer/reprojection.h"
#include "viewer/viewer.h"
#include "viewer/window_pace.h"

namespace gnomon::viewer {

struct Viewer::Impl {
    using Clock = std::chrono::steady_clock;

    Impl(ViewSettings s, std::string w, int threads);

    ViewSettings settings;
    std::string what;
    GlWindow window;
    ViewSession session;   // after the window, which it wakes
    std::optional<InputQueue> input;
    WindowPace pace;
    std::string shown_news;   // loading, errors, the message
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
    MotionSize motion_size;
    int requested_divisor = 1;
    bool requested_whole = false;
    struct Moving {
        std::uint64_t request;
        int divisor;
        bool other_time;   // than that of the request before
    };
    std::vector<Moving> moving;     // requests in motion without an image yet
    ClipPace clip_pace;             // while the user moves the view
    Clock::time_point moved_at{};   // when something changed last
    Latency latency;                // until the window shows inputs, be it by an image that is moved
    Latency rendered;               // until it shows an image rendered for them
    bool wants_screenshot = false;
    std::uint64_t shot_request = 0, video_request = 0;   // requests for a screenshot and for the video's next frame
    Size video_size{};                                   // the view's size when the recording began
    std::optional<double> video_exposure;                // of the recording's first frame: stops
    bool dirty = true;
    bool view_moved = false;    // the interactive camera moved since the last request,
    bool view_jumped = false;   // or another view is shown
    std::string requested_camera;
    std::uint64_t other_request = 0;   // the last one in which more changed than the interactive camera and the time
    std::vector<UserOverride> requested_overrides;

    // What the window shows.
    std::uint64_t drawings = 0, drawn_image = 0;   // drawings: counts what was shown
    Camera drawn_view;
    std::optional<Image8> moved_image;   // the image, moved to that view

    bool handles = true;   // of the picked object are shown
    ObjectHandles object_handles;

    glm::vec2 pressed_at{0};
    int pressed = -1;
    bool dragged = false, flying = false;
    Clock::time_point looked = Clock::now();
    std::filesystem::file_time_type file_time{};

    // viewer.cpp
    double wait_seconds() const;
    void frame(double seconds);
    void draw(Clock::time_point start, bool new_image);

    // viewer_input.cpp
    void take_camera();
    void look_from(OrbitCamera::Side side);
    std::optional<Gizmo> gizmo() const;
    void follow_mouse();
    void fly(double seconds);
    void key(int which);

    // viewer_images.cpp
    void take_scene();
    bool take_image();
    bool holds() const;
    void ask();
    bool follows_view() const;
    Camera shown_view() const;
    std::optional<Reprojection> reprojection() const;
    void draw_image();
    void draw_outline() const;
    /// The size of the view, which is the window without the docked panel, in pixels.
    Size view_size() const;
    struct Placed {
        glm::vec2 corner;   // top left corner of the image in the window
        float factor = 1;   // window pixels per pixel of the frame
    };
    Placed placed() const;
    std::optional<glm::vec2> image_place(const glm::vec2& at) const;

    // viewer_files.cpp
    void open(const std::string& file);
    void look_at_file();
    void screenshot();
    void toggle_recording();
    void end_recording(const std::string& why);
    void handle_failed_frame(const LoadState& load);
};

inline double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}   // namespace gnomon::viewer
