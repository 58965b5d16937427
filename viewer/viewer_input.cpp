// SPDX-License-Identifier: Apache-2.0
// What mouse and keys do.
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "options/option_table.h"
#include "viewer/viewer_impl.h"

namespace gnomon::viewer {

namespace {

constexpr float k_click_pixels = 4;   // a drag shorter than this is a click
constexpr float k_wheel = 0.9f;       // a notch of the wheel multiplies the distance by this

}   // namespace

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

// Looks from a side at all that the frame shows.
void Viewer::Impl::look_from(OrbitCamera::Side side)
{
    take_camera();
    if (!own_camera) return;
    camera.look_from(side);
    camera.fit(image->bounds, view_size());
    dirty = view_jumped = true;
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
    return Gizmo(shown_view(), pivot_of(*panel.picked), corner, size);
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
            view_moved = true;
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
    view_moved = true;
}

void Viewer::Impl::fly(double seconds)
{
    const ImGuiIO& io = ImGui::GetIO();
    flying = false;
    if (io.WantCaptureKeyboard || io.KeyCtrl || !scene) return;
    const auto down = [&](int key) { return io.KeysDown[key] ? 1.0f : 0.0f; };
    const float forward = down(GLFW_KEY_W) - down(GLFW_KEY_S), right = down(GLFW_KEY_D) - down(GLFW_KEY_A),
                up = down(GLFW_KEY_E) - down(GLFW_KEY_Q);
    if (forward == 0 && right == 0 && up == 0) return;
    flying = true;
    take_camera();
    if (!own_camera) return;
    const float step = 0.8f * camera.distance() * static_cast<float>(std::min(seconds, 0.1)) * (io.KeyShift ? 4 : 1);
    camera.fly(step * forward, step * right, step * up);
    view_moved = true;
}

void Viewer::Impl::key(int which)
{
    if (const auto side = OrbitCamera::side_of(which)) look_from(*side);   // GLFW's codes of digits are characters
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
            view_jumped = view_jumped || own_camera;
            own_camera = false;
            dirty = true;
            break;
        case GLFW_KEY_F:
            if (!panel.picked || !panel.picked->instance) break;
            take_camera();
            camera.aim(panel.picked->position);
            dirty = view_jumped = true;
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

}   // namespace gnomon::viewer
