// SPDX-License-Identifier: Apache-2.0
#include "scene/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/check.h"
#include "base/one_line.h"
#include "gnomon/error.h"

namespace gnomon::scene {

namespace {
glm::dvec3 unit(const glm::dvec3& v, const glm::dvec3& otherwise)
{
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

// Returns the pixel in which a view shows an offset from its eye, whose distance along the view's axis counts as
// `ahead`.
glm::dvec2 pixel_of(const View& view, const glm::dvec3& offset, double ahead)
{
    const glm::dvec3 right(view.right), up(view.up);
    const double sx = glm::dot(offset, right) / (glm::dot(right, right) * ahead) - static_cast<double>(view.shift.x);
    const double sy = glm::dot(offset, up) / (glm::dot(up, up) * ahead) - static_cast<double>(view.shift.y);
    return {0.5 * (sx + 1) * view.size.width, 0.5 * (1 - sy) * view.size.height};
}
}   // namespace

scene::CameraId find_camera(const scene::Scene& scene, const std::string& wanted)
{
    if (scene.cameras.empty()) throw UsageError("the scene has no camera: hand one over with the frame");
    if (wanted == "auto") return 0;
    for (std::size_t c = 0; c < scene.cameras.size(); ++c)
        if (scene.cameras[c].name == wanted) return static_cast<scene::CameraId>(c);
    unsigned number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error == std::errc() && end == wanted.data() + wanted.size() && number < scene.cameras.size()) return number;
    throw UsageError(
        fmt::format("no camera '{}': the scene has {}, numbered from 0", shown_name(wanted), scene.cameras.size()));
}

namespace {

// Half the extent of the image plane at distance 1 (perspective) or anywhere (orthographic), its shift in these units,
// and the depth range.
struct Lens {
    bool orthographic = false;
    glm::dvec2 half{1}, shift{0};
    double near = 0, far = 0;   // far 0: infinite
};

// Reads the extent back from a matrix: ndc = (a x + c z) / -z, or a x + t.
Lens lens_of(const glm::dmat4& p)
{
    Lens lens;
    lens.orthographic = p[3][3] == 1;
    lens.half = {1 / p[0][0], 1 / p[1][1]};
    const double e = p[2][2], f = p[3][2];
    if (lens.orthographic) {
        lens.shift = {-p[3][0], -p[3][1]};
        lens.near = (1 + f) / e, lens.far = (f - 1) / e;
    } else {
        lens.shift = {p[2][0], p[2][1]};
        lens.near = f / (e - 1), lens.far = e == -1 ? 0 : f / (e + 1);
    }
    return lens;
}

}   // namespace

bool is_projection(const glm::dmat4& p)
{
    const auto zero = [&](std::initializer_list<std::pair<int, int>> places) {   // rows and columns
        return std::all_of(places.begin(), places.end(), [&](const auto& at) { return p[at.second][at.first] == 0; });
    };
    if (!(p[0][0] > 0 && p[1][1] > 0) || p[2][2] == 0) return false;
    if (!zero({{0, 1}, {1, 0}, {2, 0}, {2, 1}, {3, 0}, {3, 1}})) return false;
    const bool perspective = p[2][3] == -1 && p[3][3] == 0 && zero({{0, 3}, {1, 3}});
    const bool orthographic = p[2][3] == 0 && p[3][3] == 1 && zero({{0, 2}, {1, 2}});
    if (!perspective && !orthographic) return false;
    // What is seen begins at the camera or before it, and ends farther away.
    const Lens lens = lens_of(p);
    const bool infinite = perspective && p[2][2] == -1;
    return lens.near >= 0 && (infinite || lens.far > lens.near);
}

namespace {

Lens lens_of(const scene::Camera& camera, Size size)
{
    if (camera.projection) return lens_of(*camera.projection);
    Lens lens;
    lens.near = camera.near, lens.far = camera.far;
    if (camera.intrinsics) {
        const Intrinsics& in = *camera.intrinsics;
        const Size of = in.size.width > 0 ? in.size : size;
        lens.half.y = of.height / (2 * in.fy);
        // Another aspect than that of the calibrated image shows more or less at the sides.
        lens.half.x = lens.half.y * (in.fy / in.fx) * size.width / size.height;
        const double centre = (of.width - 2 * in.cx) / (2 * in.fx);   // of the image, right of the axis
        lens.shift = {centre / lens.half.x, 2 * in.cy / of.height - 1};
        return lens;
    }
    lens.orthographic = camera.orthographic_height > 0;
    lens.half.y = lens.orthographic ? camera.orthographic_height / 2 : std::tan(camera.vertical_fov / 2);
    lens.half.x = lens.half.y * size.width / size.height;
    lens.shift = {2 * camera.shift.x * size.height / size.width, 2 * camera.shift.y};
    return lens;
}

}   // namespace

View make_view(const scene::SceneState& state, scene::CameraId id, Size size)
{
    const scene::Camera& camera = state.scene().cameras[id];
    return make_view(camera, state.world(camera.node), size);
}

glm::dmat4 placed(const scene::Camera& camera, const glm::dmat4& world, Size size)
{
    if (!camera.fit || !(size.height > 0)) return world;
    const double aspect = static_cast<double>(size.width) / size.height;
    const glm::dvec3 step = camera.fit->eye(aspect) - camera.fit->eye(CameraFit::k_node_aspect);
    glm::dmat4 result = world;
    result[3] = world * glm::dvec4(step, 1);
    return result;
}

View make_view(const scene::Camera& camera, const glm::dmat4& node, Size size)
{
    const glm::dmat4 world = placed(camera, node, size);
    const glm::dvec3 forward = unit(-glm::dvec3(world[2]), {0, 0, -1});
    const glm::dvec3 right = unit(glm::cross(forward, glm::dvec3(world[1])), {1, 0, 0});
    const glm::dvec3 up = glm::cross(right, forward);
    const Lens lens = lens_of(camera, size);

    View view;
    view.size = size;
    view.eye = glm::vec3(glm::dvec3(world[3]));
    view.forward = glm::vec3(forward);
    view.near = static_cast<float>(lens.near);
    view.far = lens.far > 0 ? static_cast<float>(lens.far) : k_infinity;
    view.orthographic = lens.orthographic;
    view.right = glm::vec3(lens.half.x * right);
    view.up = glm::vec3(lens.half.y * up);
    view.shift = glm::vec2(lens.shift);
    const auto pixel = static_cast<float>(2 * lens.half.y / size.height);
    (view.orthographic ? view.pixel_width : view.pixel_spread) = pixel;
    return view;
}

void View::ray(float x, float y, glm::vec3& origin, glm::vec3& direction, float& tnear, float& tfar) const
{
    const float sx = 2.0f * x / static_cast<float>(size.width) - 1.0f + shift.x;
    const float sy = 1.0f - 2.0f * y / static_cast<float>(size.height) + shift.y;
    if (orthographic) {
        origin = eye + sx * right + sy * up;
        direction = forward;
        tnear = near, tfar = far;
        if (skew == glm::vec2(0)) return;
        const glm::vec3 d = forward + skew.x * right + skew.y * up;
        const float length = std::sqrt(glm::dot(d, d));
        direction = d / length;
        tnear = near * length, tfar = far * length;
        return;
    }
    const glm::vec3 d = forward + sx * right + sy * up;
    const float length = std::sqrt(glm::dot(d, d));
    origin = eye;
    direction = d / length;
    tnear = near * length, tfar = far * length;   // planes, not spheres
}

glm::dmat4 matrix_of(const View& view)
{
    return {glm::dvec4(glm::normalize(glm::dvec3(view.right)), 0), glm::dvec4(glm::normalize(glm::dvec3(view.up)), 0),
            glm::dvec4(-glm::dvec3(view.forward), 0), glm::dvec4(glm::dvec3(view.eye), 1)};
}

std::optional<glm::dvec2> View::project(const glm::dvec3& point) const
{
    const glm::dvec3 offset = point - glm::dvec3(eye);
    if (orthographic) {
        const double ahead = glm::dot(offset, glm::dvec3(forward));
        const glm::dvec3 aside =
            static_cast<double>(skew.x) * glm::dvec3(right) + static_cast<double>(skew.y) * glm::dvec3(up);
        return pixel_of(*this, offset - ahead * aside, 1);
    }
    return project_direction(offset);
}

std::optional<glm::dvec2> View::project_direction(const glm::dvec3& direction) const
{
    const double ahead = glm::dot(direction, glm::dvec3(forward));
    if (orthographic || !(ahead > 0)) return {};
    return pixel_of(*this, direction, ahead);
}

View turned(const View& view, const glm::vec3& centre, double angle)
{
    const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    const auto turn = [&](const glm::vec3& v) { return glm::vec3(c * v.x + s * v.z, v.y, -s * v.x + c * v.z); };
    View result = view;
    result.eye = centre + turn(view.eye - centre);
    result.forward = turn(view.forward);
    result.right = turn(view.right);
    result.up = turn(view.up);
    return result;
}

glm::vec2 sample_offset(int i, int n)
{
    if (n <= 1) return {0.5f, 0.5f};
    constexpr double g1 = 0.7548776662466927, g2 = 0.5698402909980532;   // 1/p and 1/p^2, p^3 = p + 1
    const double x = 0.5 + g1 * i, y = 0.5 + g2 * i;
    return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

glm::vec2 refined_offset(int i)
{
    GNOMON_CHECK(i >= 0 && i < k_refined_samples);
    // In cells of 16 x 16. Of scrambled nets, one whose points are far from each other, from the pixel's centre, and
    // from those of the neighbouring pixels.
    static constexpr std::uint8_t k_cells[k_refined_samples][2] = {
        {8, 14}, {6, 3},  {13, 6},  {2, 8}, {11, 0}, {4, 12}, {15, 10}, {1, 4},
        {9, 5},  {7, 11}, {12, 13}, {3, 1}, {10, 9}, {5, 7},  {14, 2},  {0, 15}};
    return {(static_cast<float>(k_cells[i][0]) + 0.5f) / 16, (static_cast<float>(k_cells[i][1]) + 0.5f) / 16};
}

}   // namespace gnomon::scene
