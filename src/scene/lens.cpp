// SPDX-License-Identifier: Apache-2.0
#include "scene/lens.h"

#include <cmath>

#include "base/check.h"

namespace gnomon::scene {

float lens_radius(const View& view, double f_number)
{
    GNOMON_CHECK(f_number > 0);
    if (view.orthographic) return static_cast<float>(k_orthographic_focal_length / (2 * f_number));
    // Half of the image's height at distance 1 is `up`.
    const double focal_length = 0.5 * k_sensor_height / static_cast<double>(glm::length(view.up));
    return static_cast<float>(focal_length / (2 * f_number));
}

glm::vec2 disc_point(const glm::vec2& square)
{
    const glm::vec2 p = 2.0f * square - 1.0f;
    if (p.x == 0 && p.y == 0) return glm::vec2(0);
    constexpr auto k_quarter = static_cast<float>(k_pi / 4);
    const bool wide = std::abs(p.x) > std::abs(p.y);
    const float radius = wide ? p.x : p.y;
    const float angle = wide ? k_quarter * (p.y / p.x) : 2 * k_quarter - k_quarter * (p.x / p.y);
    return radius * glm::vec2(std::cos(angle), std::sin(angle));
}

View through_lens(const View& view, const Lens& lens, const glm::vec2& at)
{
    View result = view;
    const float right = glm::length(view.right), up = glm::length(view.up);
    const glm::vec2 offset = lens.radius * at;
    result.eye += offset.x * view.right / right + offset.y * view.up / up;
    const glm::vec2 turn = offset / (lens.focus * glm::vec2(right, up));
    (view.orthographic ? result.skew : result.shift) -= turn;
    return result;
}

void lens_ray(const View& view, const Lens& lens, float x, float y, const glm::vec2& at, glm::vec3& origin,
              glm::vec3& direction, float& tnear, float& tfar)
{
    if (view.orthographic) return through_lens(view, lens, at).ray(x, y, origin, direction, tnear, tfar);
    const float sx = 2.0f * x / static_cast<float>(view.size.width) - 1.0f + view.shift.x;
    const float sy = 1.0f - 2.0f * y / static_cast<float>(view.size.height) + view.shift.y;
    const glm::vec3 offset = lens.radius * (at.x * glm::normalize(view.right) + at.y * glm::normalize(view.up));
    // Its length for each unit of depth: planes at the near and far distance are planes still.
    const glm::vec3 d = view.forward + sx * view.right + sy * view.up - offset / lens.focus;
    const float length = std::sqrt(glm::dot(d, d));
    origin = view.eye + offset;
    direction = d / length;
    tnear = view.near * length, tfar = view.far * length;
}

float circle_of_confusion(const View& view, const Lens& lens, float depth)
{
    if (lens.sharp() || !(depth > 0)) return 0;
    // A point's disc on the plane of focus is the lens's, seen from the point.
    if (view.orthographic) return 2 * lens.radius * std::abs(depth - lens.focus) / (lens.focus * view.pixel_width);
    const float apart = std::isinf(depth) ? 1.0f : std::abs(depth - lens.focus) / depth;
    return 2 * lens.radius * apart / (lens.focus * view.pixel_spread);
}

}   // namespace gnomon::scene
