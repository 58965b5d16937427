// SPDX-License-Identifier: Apache-2.0
// The images that are requested, and how they are shown.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "viewer/enlarge.h"
#include "viewer/projection.h"
#include "viewer/viewer_impl.h"

namespace gnomon::viewer {

namespace {

constexpr double k_rest_seconds = 0.15;   // without motion, until a view that is held gets a sharper image

constexpr ImU32 k_outline = IM_COL32(255, 196, 64, 255), k_outline_below = IM_COL32(0, 0, 0, 160);

// The nearest of what an enlarged image shows around a place, in fractions of its width and height.
float nearness_around(const ViewImage& image, const glm::vec2& place)
{
    const int width = image.image.width, height = image.image.height;
    const glm::ivec2 at(glm::round(place * glm::vec2(width, height)));
    float most = 0;
    for (const int y : {at.y - 1, at.y})
        for (const int x : {at.x - 1, at.x})
            if (x >= 0 && y >= 0 && x < width && y < height)
                most = std::max(most, image.nearness[static_cast<std::size_t>(y * width + x)]);
    return most;
}

}   // namespace

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
    latency.forget();
    rendered.forget();
    moving.clear();
    panel.picked.reset();
    object_handles.forget();
    pick.reset();
    own_camera = false;
    dirty = view_jumped = true;
}

// Takes the session's latest image, and saves it if a screenshot or the recording was waiting for it.
// @return whether there is one
bool Viewer::Impl::take_image()
{
    const auto next = session.image(image ? image->number : 0);
    if (!next) return false;
    image = next;
    panel.add(image->times);
    image_ms.push_back(image->times.total());
    ++summary.images;
    if (image->picked && image->scene == scene) panel.picked = image->picked;
    // Let the first image of a request in motion decide how large the next one is.
    std::erase_if(moving, [&](const auto& asked) {
        if (asked.request == image->request && asked.other_time) clip_pace.took(image->times.fixed);
        if (asked.request == image->request)
            motion_size.add(asked.divisor,
                            {.ms = image->times.total(),
                             .fixed_ms = image->times.fixed,
                             .light_ms = image->times.ms[ViewTimes::indirect] - image->times.light_maps,
                             .rays = image->frame.counters.indirect.rays},
                            holds() ? MotionSize::k_held_ms : MotionSize::k_playing_ms);
        return asked.request <= image->request;
    });
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
        if (!recorder.add(image->frame)) {
            end_recording("the size of the image changed");
            return true;
        }
        if (!video_exposure) video_exposure = image->frame.exposure;
        playback.frame = playback.frame + 1 > playback.frames ? 1 : playback.frame + 1;
        dirty = true;
    }
    return true;
}

// Whether the user holds what changes the view: a mouse button or a key.
bool Viewer::Impl::holds() const
{
    return pressed >= 0 || object_handles.dragged() || flying;
}

// Requests the next image from the session if anything changed, or a sharper one if nothing did.
void Viewer::Impl::ask()
{
    if (!scene) return;
    // Record whole frames of one size, whatever the user does with the slider and the window.
    if (recorder.recording()) playback.frame = std::floor(playback.frame);
    const Size size = recorder.recording() ? video_size : view_size();
    if (size.width < 1 || size.height < 1) return;   // iconified
    const bool whole = recorder.recording() || wants_screenshot;
    const bool holds_clip = playback.playing && holds() && !whole && image && image->scene == scene;
    const double time = holds_clip && !clip_pace.goes_on(Clock::now()) ? requested_time : playback.time(*scene);
    const bool moved = dirty || view_moved || time != requested_time || !(size == requested_size) ||
                       overrides.list != requested_overrides;
    if (moved) moved_at = Clock::now();
    const bool sharper = !moved && requested_divisor > 1 && (!holds() || seconds_since(moved_at) > k_rest_seconds);
    if (!moved && !sharper) return;
    // What a scene's first image waits for is no input.
    const bool other = dirty || overrides.list != requested_overrides;
    if ((other || view_moved) && !whole && image && image->scene == scene) {
        latency.note(input->came());
        rendered.note(input->came());
    }
    // Let each image in motion finish, because it shows something and fills caches for the next, while the latest
    // request waits for it. A sharper image of what is shown need not finish, so that a drag never waits for it. An
    // image to save is neither replaced nor requested before all others are there.
    const bool replaces = !whole && !requested_whole;
    if (session.busy() && !(moved && (replaces || session.interruptible()))) return;
    // Delay the recording while images are rendered faster than written, so that they do not fill the memory.
    if (recorder.recording() && recorder.behind()) return;

    // Describe the frame.
    ViewRequest request;
    request.scene = scene;
    const RenderOptions at_rest = settings.render_options();
    request.options = whole ? at_rest : settings.motion_options();
    // An automatic exposure is computed from a recording's first frame, and kept, so that the video does not flicker.
    if (recorder.recording() && !request.options.exposure && !settings.exposure_of_each_frame())
        request.options.exposure = video_exposure;
    request.time = time;
    request.camera = request.options.camera;
    request.overrides = overrides.list;
    if (request.options.turntable_seconds > 0)
        request.turn = 2 * k_pi * ((playback.frame - 1) / playback.fps / request.options.turntable_seconds);
    request.whole = whole;
    // What an image of another view takes is not known.
    if (std::exchange(view_jumped, false) || request.options.camera != requested_camera)
        motion_size.restart(), moving.clear();
    requested_camera = request.options.camera;
    request.interruptible = sharper;
    request.early = !whole;
    request.urgent = other;
    if (!whole && !sharper) request.rays = motion_size.rays();
    requested_divisor = whole ? 1 : sharper ? requested_divisor / 2 : motion_size.divisor();
    request.size = {std::max(size.width / requested_divisor, 16), std::max(size.height / requested_divisor, 16)};
    request.coarse = !whole && !sharper && requested_divisor > 1;
    request.preview = !whole && requested_divisor > 1;
    request.enlarge = enlargement(request.size, requested_divisor);
    if (!whole && requested_divisor == 1 && blurs(at_rest)) request.at_rest = at_rest;
    if (own_camera) request.orbit = camera.camera();
    request.pick = std::exchange(pick, std::nullopt);

    // Remember the request, and send it.
    requested_whole = whole;
    const bool other_time = time != requested_time;
    if (other_time) clip_pace.went_on(Clock::now());
    const bool resized = !(size == requested_size);
    requested_time = time;
    requested_size = size;
    requested_overrides = overrides.list;
    dirty = view_moved = false;
    const std::uint64_t number = session.ask(std::move(request));
    if (other || resized || whole) other_request = number;
    latency.ask(number);
    rendered.ask(number);
    if (!whole && !sharper) moving.push_back({number, requested_divisor, other_time});
    if (wants_screenshot) shot_request = number;
    if (recorder.recording()) video_request = number;
}

Size Viewer::Impl::view_size() const
{
    const Size whole = window.framebuffer();
    const float pixels = ImGui::GetIO().DisplayFramebufferScale.x;   // per unit of the window's coordinates
    const int panel_width = static_cast<int>(std::lround(panel.docked_width() * pixels));
    return {std::max(whole.width - panel_width, 0), whole.height};
}

// Centres the image beside the panel, as large as possible. Its shape may differ from the view's because an overlay has
// a legend and a video keeps its size.
Viewer::Impl::Placed Viewer::Impl::placed() const
{
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const glm::vec2 left(panel.docked_width(), 0), room = glm::vec2(display.x, display.y) - left;
    const glm::vec2 size(image->frame.size.width, image->frame.size.height);
    const float factor = std::min(room.x / size.x, room.y / size.y);
    return {left + (room - factor * size) / 2.0f, factor};
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

// Whether the window shows the image as the interactive camera of now sees it, by moving it if that is another one than
// it was rendered with. Not if more than the view has changed since, because the view may have jumped.
bool Viewer::Impl::follows_view() const
{
    return own_camera && image && image->scene == scene && !image->nearness.empty() && !dirty &&
           image->request >= other_request && overrides.list == requested_overrides && !recorder.recording() &&
           !image_plane_of(image->camera, {1, 1}).orthographic;
}

// The camera that the window shows.
Camera Viewer::Impl::shown_view() const
{
    return follows_view() ? camera.camera() : image->orbit.value_or(image->camera);
}

// How the image is moved to be shown; none: it is shown as it is.
std::optional<Reprojection> Viewer::Impl::reprojection() const
{
    const Camera view = shown_view();
    if (view == image->orbit.value_or(image->camera)) return std::nullopt;
    return Reprojection::between(image->camera, view, {image->frame.size.width, image->frame.size.height});
}

// Draws the image below everything else.
void Viewer::Impl::draw_image()
{
    if (!image) return;
    const Camera view = shown_view();
    if (image->number != drawn_image || !(view == drawn_view)) {
        moved_image.reset();
        if (const auto change = reprojection()) moved_image = change->moved(image->image, image->nearness);
        drawn_image = image->number, drawn_view = view;
        ++drawings;
    }
    const Placed place = placed();
    const float pixels = ImGui::GetIO().DisplayFramebufferScale.x;   // per unit of the window's coordinates
    const glm::vec2 size = place.factor * glm::vec2(image->frame.size.width, image->frame.size.height);
    const glm::ivec2 low(glm::round(pixels * place.corner)), high(glm::round(pixels * (place.corner + size)));
    window.draw(moved_image ? *moved_image : image->image, drawings, low.x, low.y, {high.x - low.x, high.y - low.y});
}

// Outlines the picked object, above the image and below the panels.
void Viewer::Impl::draw_outline() const
{
    if (!image) return;
    const Placed place = placed();
    ImDrawList* const draw = ImGui::GetBackgroundDrawList();
    if (image->scene != scene || recorder.recording()) return;

    // Move it with the image.
    const auto change = reprojection();
    const glm::vec2 view_size(image->frame.view_size.width, image->frame.view_size.height);
    const auto shown = [&](const glm::ivec2& at) {
        if (!change) return glm::vec2(at);
        const glm::vec2 fraction = glm::vec2(at) / view_size;
        const auto moved = change->moved(fraction, nearness_around(*image, fraction));
        return moved ? *moved * view_size : glm::vec2(at);
    };

    // Dark below bright, to be seen before anything.
    const glm::vec2 corner = place.corner + place.factor * glm::vec2(image->frame.view_left, image->frame.view_top);
    for (const auto& [color, width] : {std::pair{k_outline_below, 3.0f}, std::pair{k_outline, 1.0f}})
        for (const OutlineEdge& edge : image->outline) {
            const glm::vec2 from = corner + place.factor * shown(edge.from);
            const glm::vec2 to = corner + place.factor * shown(edge.to);
            const float more = 0.5f * width;   // closes corners
            draw->AddRectFilled({from.x - more, from.y - more}, {to.x + more, to.y + more}, color);
        }
}

}   // namespace gnomon::viewer
