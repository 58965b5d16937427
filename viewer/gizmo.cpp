// SPDX-License-Identifier: Apache-2.0
#include "viewer/gizmo.h"

#include <algorithm>
#include <cmath>

namespace gnomon::viewer {

namespace {

constexpr int k_ring_parts = 48;
constexpr float k_least_slope = 0.08f;      // of a plane or an axis to the line of sight, for drags on it
constexpr float k_least_ring = 0.15f;       // of a ring's plane, to be shown
constexpr float k_far_side = 0.35f;         // of a ring's radius: what is farther behind its middle is not shown
constexpr float k_pixels_of_double = 100;   // a drag so long to the right doubles the size
constexpr float k_gap = 0.22f;              // of an arrow, around the square

glm::vec3 unit(int axis)
{
    glm::vec3 result(0);
    result[axis] = 1;
    return result;
}

float distance_to(const std::vector<glm::vec2>& line, const glm::vec2& place)
{
    float nearest = k_infinity;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const glm::vec2 way = line[i + 1] - line[i];
        const float square = glm::dot(way, way);
        const float t = square > 0 ? std::clamp(glm::dot(place - line[i], way) / square, 0.0f, 1.0f) : 0.0f;
        nearest = std::min(nearest, glm::length(place - (line[i] + t * way)));
    }
    return nearest;
}

}   // namespace

int Gizmo::axis_of(Handle handle)
{
    return (static_cast<int>(handle) - static_cast<int>(Handle::move_x)) % 3;
}

bool Gizmo::moves(Handle handle)
{
    return handle >= Handle::move_x && handle <= Handle::move_z;
}

Gizmo::Gizmo(const Camera& camera, const glm::vec3& pivot, const glm::vec2& corner, const glm::vec2& size)
    : view_(camera, size),
      pivot_(pivot),
      corner_(corner),
      size_(size),
      metres_per_pixel_(view_.height_at(pivot) / size.y)
{
}

std::optional<glm::vec2> Gizmo::in_window(const glm::vec3& point) const
{
    const std::optional<glm::vec2> place = view_.place_of(point);
    if (!place) return std::nullopt;
    return corner_ + *place * size_;
}

std::vector<glm::vec2> Gizmo::line(Handle handle) const
{
    std::vector<glm::vec2> points;
    const std::optional<glm::vec2> middle = in_window(pivot_);
    if (!middle || handle == Handle::none) return points;
    if (handle == Handle::scale) {
        for (const glm::vec2 corner :
             {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1), glm::vec2(-1, -1)})
            points.push_back(*middle + k_square * corner);
        return points;
    }
    const glm::vec3 axis = unit(axis_of(handle));
    if (moves(handle)) {
        const std::optional<glm::vec2> end = in_window(pivot_ + k_arrow * metres_per_pixel_ * axis);
        if (end) points = {*middle + k_gap * (*end - *middle), *end};
        return points;
    }
    // Leave out a ring that is seen from its edge, and of others what is turned away.
    const glm::vec3 to_viewer = view_.to_viewer(pivot_);
    if (!(std::abs(glm::dot(axis, to_viewer)) > k_least_ring)) return points;
    glm::vec3 x, y;
    make_basis(axis, x, y);
    const glm::vec2 facing(glm::dot(x, to_viewer), glm::dot(y, to_viewer));
    const float depth = glm::length(facing);
    const float half = depth > k_far_side ? std::acos(-k_far_side / depth) : static_cast<float>(k_pi);
    const float middle_turn = std::atan2(facing.y, facing.x);
    for (int i = 0; i <= k_ring_parts; ++i) {
        const float turn = middle_turn + half * (2 * static_cast<float>(i) / k_ring_parts - 1);
        const std::optional<glm::vec2> at =
            in_window(pivot_ + k_ring * metres_per_pixel_ * (std::cos(turn) * x + std::sin(turn) * y));
        if (at) points.push_back(*at);
    }
    return points;
}

Gizmo::Handle Gizmo::at(const glm::vec2& place) const
{
    const std::optional<glm::vec2> middle = in_window(pivot_);
    if (!middle) return Handle::none;
    const glm::vec2 off = glm::abs(place - *middle);
    if (std::max(off.x, off.y) <= k_square + 2) return Handle::scale;
    Handle nearest = Handle::none;
    float distance = k_near;
    for (const Handle handle : k_handles) {
        if (handle == Handle::scale) continue;
        const float here = distance_to(line(handle), place);
        if (here < distance) distance = here, nearest = handle;
    }
    return nearest;
}

// How far along an axis through the pivot a place is: where the axis is nearest to the line of sight.
std::optional<float> Gizmo::along(const glm::vec3& axis, const glm::vec2& place) const
{
    const Projection::Line sight = view_.line_at(fraction_of(place));
    const float cosine = glm::dot(axis, sight.direction), slope = 1 - cosine * cosine;
    if (!(slope > k_least_slope * k_least_slope)) return std::nullopt;
    const glm::vec3 way = sight.origin - pivot_;
    return (glm::dot(way, axis) - cosine * glm::dot(way, sight.direction)) / slope;
}

// The angle about an axis through the pivot of what a place shows in the plane across it.
std::optional<float> Gizmo::around(const glm::vec3& axis, const glm::vec2& place) const
{
    const Projection::Line sight = view_.line_at(fraction_of(place));
    const float slope = glm::dot(axis, sight.direction);
    if (!(std::abs(slope) > k_least_slope)) return std::nullopt;
    const glm::vec3 at = sight.origin + glm::dot(pivot_ - sight.origin, axis) / slope * sight.direction - pivot_;
    glm::vec3 x, y;
    make_basis(axis, x, y);
    return std::atan2(glm::dot(at, y), glm::dot(at, x));
}

Gizmo::Change Gizmo::drag(Handle handle, const glm::vec2& from, const glm::vec2& to) const
{
    Change change;
    if (handle == Handle::none) return change;
    if (handle == Handle::scale) {
        change.factor = std::exp2((to.x - from.x) / k_pixels_of_double);
        return change;
    }
    change.axis = unit(axis_of(handle));
    if (moves(handle)) {
        const std::optional<float> begin = along(change.axis, from), end = along(change.axis, to);
        if (begin && end) change.move = (*end - *begin) * change.axis;
        return change;
    }
    const std::optional<float> begin = around(change.axis, from), end = around(change.axis, to);
    if (begin && end) change.angle = std::remainder(*end - *begin, 2 * static_cast<float>(k_pi));
    return change;
}

UserOverride changed(const UserOverride& before, const Gizmo::Change& change, const glm::dmat4& parent)
{
    UserOverride after = before;
    after.factor *= change.factor;
    const glm::dmat3 linear(parent);
    if (!(std::abs(glm::determinant(linear)) > 0)) return after;
    const glm::dmat3 to_parent = glm::inverse(linear);
    after.offset += glm::vec3(to_parent * glm::dvec3(change.move));
    if (change.angle != 0) {
        const glm::vec3 axis = glm::normalize(glm::vec3(to_parent * glm::dvec3(change.axis)));
        const float angle = glm::determinant(linear) < 0 ? -change.angle : change.angle;
        after.turn = glm::normalize(glm::angleAxis(angle, axis) * before.turn);
    }
    return after;
}

glm::dmat4 parent_of(const Picked& picked)
{
    const glm::dmat4 own = matrix_of(picked.transform);
    if (!(std::abs(glm::determinant(own)) > 0)) return glm::dmat4(1);
    return matrix_of(picked.world) * glm::inverse(own);
}

glm::vec3 pivot_of(const Picked& picked)
{
    return glm::vec3(matrix_of(picked.world) * glm::dvec4(glm::dvec3(picked.pivot), 1));
}

}   // namespace gnomon::viewer
