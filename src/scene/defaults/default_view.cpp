// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/default_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "base/check.h"
#include "base/one_line.h"
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
DefaultView view_from(const SceneState& state, const glm::dvec3& direction, const std::vector<char>& left_out,
                      Survey* found)
{
    FramingOptions options;
    options.left_out = left_out;
    options.back = glm::normalize(direction);
    options.vertical_fov = k_fov;
    const Framed framed = frame_clip(state.scene(), options);
    if (found && left_out.empty()) found->clip = Framed{nullptr, glm::dmat3(1), framed.size, framed.box};
    DefaultView view;
    view.camera.name = "default camera";
    view.camera.vertical_fov = k_fov;
    view.camera.near = framed.size * k_near;
    view.camera.fit = framed.fit;
    view.axes = framed.axes;
    view.eye = framed.eye(CameraFit::k_node_aspect);
    return view;
}

TestImage image_of(const SceneState& state, const DefaultView& view)
{
    return test_image_of(state, view.camera, matrix_of(view.axes, view.eye));
}

// How much of what there is a square image shows.
float rating(const TestImage& image)
{
    return image.shown() > 0 ? image.shown_of_all() : -1;
}

// Whether an image shows more than one even wall: edges between objects or between faces.
bool has_edges(const TestImage& image, float least)
{
    constexpr float k_crease = 0.7f;   // cosine
    std::size_t edges = 0;
    const auto side = static_cast<std::size_t>(image.side);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const TestPixel& a = image.pixels[i];
        for (const std::size_t other :
             {i % side + 1 < side ? i + 1 : i, i + side < image.pixels.size() ? i + side : i}) {
            const TestPixel& b = image.pixels[other];
            edges += a.object != b.object || (a.object != none && glm::dot(a.normal, b.normal) < k_crease);
        }
    }
    return static_cast<float>(edges) >= least * static_cast<float>(image.pixels.size());
}

struct Outside {
    DefaultView view;
    float shown = 0;   // the fraction of the pixels of its square image that show a surface
};

// The best of the directions from which objects are looked at.
Outside best_outside(const SceneState& state, const Box3& box, const std::vector<char>& left_out,
                     const DefaultViewOptions& options, Survey* found)
{
    const glm::dvec3 pleasant = pleasant_direction(box.size());
    Outside best{view_from(state, pleasant, left_out, found)};
    const TestImage first = image_of(state, best.view);
    best.shown = first.shown();
    float most = rating(first);
    if (most >= options.enough || box.empty()) return best;
    for (const glm::dvec3& turned : {glm::dvec3(-1, 1, 1), glm::dvec3(1, 1, -1), glm::dvec3(-1, 1, -1),
                                     glm::dvec3(1, -1, 1), glm::dvec3(1, -1, -1)}) {
        const DefaultView other = view_from(state, turned * pleasant, left_out, found);
        const TestImage image = image_of(state, other);
        // Take another direction only if it shows clearly more.
        if (const float shows = rating(image); shows > most + 0.1f) most = shows, best = {other, image.shown()};
        if (most >= options.enough) break;
    }
    return best;
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
    if (!has_edges(image, options.edges)) return {};
    return room;
}

DefaultView choose_view(const SceneState& state, const DefaultViewOptions& options, Survey* found)
{
    const Box3 box = state.scene().bounds(state.time());
    const auto room = believed_interior(state, options);
    if (found) found->judged = true, found->room = room;
    if (room) {
        DefaultView view = inside(*room, static_cast<double>(box.diagonal()));
        if (rating(image_of(state, view)) > 0) return view;
    }
    FramingOptions framing;
    framing.left_out = surrounding_objects(state);
    const Outside best = best_outside(state, framing.left_out.empty() ? box : frame_clip(state.scene(), framing).box,
                                      framing.left_out, options, found);
    if (!framing.left_out.empty() || box.empty() || best.shown >= options.least_shown) return best.view;

    // Objects that are far apart are specks if all of them are in view.
    framing.left_out = all_but_largest_group(state);
    if (framing.left_out.empty()) return best.view;
    const Outside nearer =
        best_outside(state, frame_clip(state.scene(), framing).box, framing.left_out, options, found);
    return nearer.shown > options.least_shown ? nearer.view : best.view;
}

bool shows_something(const SceneState& state, const Camera& camera, float least)
{
    const glm::dmat4 placed = state.world(camera.node);
    if (camera.orthographic_height > 0 || camera.projection) return true;
    const float far = make_view(camera, placed, {1, 1}).far;
    const TestImage image = test_image_of(state, camera, placed);
    const auto shown = std::count_if(image.pixels.begin(), image.pixels.end(), [&](const TestPixel& pixel) {
        return pixel.object != none && pixel.depth <= far;
    });
    return static_cast<float>(shown) >= least * static_cast<float>(image.pixels.size());
}

void judge_cameras(Scene& scene, const DefaultViewOptions& options)
{
    if (scene.cameras.empty() || scene.objects.empty()) return;
    GNOMON_CHECK(!scene.child_begin.empty());
    constexpr int k_looks = 8;
    SceneState state(std::shared_ptr<const Scene>(std::shared_ptr<const Scene>(), &scene), scene.timeline.start);
    std::vector<char> shows(scene.cameras.size());
    for (int look = 0; look < k_looks && !shows.front(); ++look) {
        if (look > 0) {
            if (!(scene.timeline.end > scene.timeline.start)) break;
            state.advance(scene.timeline.start + (scene.timeline.end - scene.timeline.start) * look / (k_looks - 1));
        }
        for (CameraId c = 0; c < scene.cameras.size(); ++c)
            shows[c] = shows[c] || shows_something(state, state.scene().cameras[c], options.least_shown);
    }
    if (shows.front()) return;
    const auto good = std::find(shows.begin(), shows.end(), 1);
    const std::string name = scene.cameras.front().name;
    if (good == shows.end()) {
        std::vector<Camera> own = std::move(scene.cameras);
        scene.cameras.clear();
        add_default_camera(scene);
        scene.warnings.pop_back();
        scene.warnings.push_back(
            fmt::format("no camera of the scene shows a surface: added a default camera before {}",
                        name.empty() ? std::string("the first") : fmt::format("'{}'", shown_name(name))));
        scene.cameras.insert(scene.cameras.end(), own.begin(), own.end());
        return;
    }
    const auto at = scene.cameras.begin() + (good - shows.begin());
    scene.warnings.push_back(
        fmt::format("camera '{}' shows no surface: '{}' comes first", shown_name(name), shown_name(at->name)));
    std::rotate(scene.cameras.begin(), at, at + 1);
}

}   // namespace gnomon::scene
