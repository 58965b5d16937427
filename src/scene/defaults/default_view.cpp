// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/default_view.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "scene/defaults/framing.h"
#include "scene/defaults/surface_points.h"
#include "scene/view.h"

namespace gnomon::scene {

namespace {

// From the right, a little above: the angle of product photographs. Panels face the camera, and what lies flat is seen
// from higher up.
constexpr glm::dvec3 k_to_camera{0.55, 0.36, 1.0};
constexpr glm::dvec3 k_before_panel{0.22, 0.12, 1.0}, k_beside_panel{1.0, 0.12, 0.22}, k_above_flat{0.42, 0.85, 0.9};
constexpr double k_thin = 0.12;   // of the larger of the other two sides
constexpr double k_fov = 0.7;
constexpr double k_near = 5e-5;   // of the diagonal
constexpr double k_stage_margin = 1.06;

glm::dvec3 pleasant_direction(const glm::vec3& size)
{
    const glm::dvec3 s(size);
    if (s.z < k_thin * std::max(s.x, s.y) && s.y > k_thin * s.x) return k_before_panel;
    if (s.x < k_thin * std::max(s.y, s.z) && s.y > k_thin * s.z) return k_beside_panel;
    if (s.y < k_thin * std::max(s.x, s.z)) return k_above_flat;
    return k_to_camera;
}

glm::dmat4 matrix_of(const glm::dmat3& axes, const glm::dvec3& eye)
{
    glm::dmat4 result(axes);
    result[3] = glm::dvec4(eye, 1);
    return result;
}

// Frames the scene from a direction.
DefaultView view_from(const SceneState& state, const glm::dvec3& direction)
{
    FramingOptions options;
    options.back = glm::normalize(direction);
    options.vertical_fov = k_fov;
    const Framed framed = frame_clip(state.scene(), options);
    DefaultView view;
    view.camera.name = "default camera";
    view.camera.vertical_fov = k_fov;
    view.camera.near = framed.size * k_near;
    view.camera.fit = framed.fit;
    view.axes = framed.axes;
    view.eye = framed.eye(CameraFit::k_node_aspect);
    return view;
}

// How much of what there is the square image shows.
float rating(const SceneState& state, const DefaultView& view)
{
    const TestImage image = test_image_of(state, view.camera, matrix_of(view.axes, view.eye));
    return image.shown() > 0 ? image.shown_of_all() : -1;
}

DefaultView inside(const Interior& room, double diagonal)
{
    DefaultView view;
    view.room = room;
    view.camera.name = "default camera";
    view.camera.vertical_fov = room.vertical_fov;
    view.camera.near = diagonal * k_near;
    view.axes = camera_axes(-glm::dvec3(room.direction));
    view.eye = glm::dvec3(room.eye);
    if (room.stage) {
        const auto fit = std::make_shared<CameraFit>(CameraFit::Lens{room.vertical_fov, k_stage_margin, 0});
        for (const glm::vec3& corner : room.opening) fit->add(glm::transpose(view.axes) * glm::dvec3(corner));
        view.eye = view.axes * fit->eye(CameraFit::k_node_aspect);
        view.camera.fit = fit;
    }
    return view;
}

}   // namespace

TestImage test_image_of(const SceneState& state, const Camera& camera, const glm::dmat4& camera_to_world)
{
    const View view = make_view(camera, camera_to_world, {1, 1});
    TestImageOptions options;
    options.vertical_fov = 2 * std::atan(static_cast<double>(glm::length(view.up)));
    options.near = std::max(static_cast<double>(view.near), 1e-12);
    const glm::dmat3 axes(glm::normalize(glm::dvec3(view.right)), glm::normalize(glm::dvec3(view.up)),
                          -glm::dvec3(view.forward));
    return draw_test_image(state, glm::dvec3(view.eye), axes, options);
}

std::optional<Interior> believed_interior(const SceneState& state, const DefaultViewOptions& options)
{
    std::optional<Interior> room = find_interior(state.scene());
    if (!room || room->stage) return room;
    if (share_seen_from_outside(state) > 1 - options.hidden) return {};
    const double diagonal = static_cast<double>(state.scene().bounds(state.time()).diagonal());
    const DefaultView view = inside(*room, diagonal);
    const TestImage image = test_image_of(state, view.camera, matrix_of(view.axes, view.eye));
    std::size_t asked = 0, facing = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        // There is sky above a courtyard.
        if (!room->covered && i < image.pixels.size() / 2) continue;
        const TestPixel& pixel = image.pixels[i];
        ++asked;
        facing += pixel.object != none && !pixel.from_behind;
    }
    if (static_cast<float>(facing) < options.enclosed * static_cast<float>(asked)) return {};
    return room;
}

DefaultView choose_view(const SceneState& state, const DefaultViewOptions& options)
{
    const Box3 box = state.scene().bounds(state.time());
    if (const auto room = believed_interior(state, options)) {
        DefaultView view = inside(*room, static_cast<double>(box.diagonal()));
        if (rating(state, view) > 0) return view;
    }
    const glm::dvec3 pleasant = pleasant_direction(box.size());
    DefaultView best = view_from(state, pleasant);
    float most = rating(state, best);
    if (most >= options.enough || box.empty()) return best;
    for (const glm::dvec3& turned : {glm::dvec3(-1, 1, 1), glm::dvec3(1, 1, -1), glm::dvec3(-1, 1, -1),
                                     glm::dvec3(1, -1, 1), glm::dvec3(1, -1, -1)}) {
        const DefaultView other = view_from(state, turned * pleasant);
        const float shows = rating(state, other);
        // Take another direction only if it shows clearly more.
        if (shows > most + 0.1f) most = shows, best = other;
        if (most >= options.enough) break;
    }
    return best;
}

}   // namespace gnomon::scene
