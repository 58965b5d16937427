// SPDX-License-Identifier: Apache-2.0
#include "visibility/shaft.h"

#include <algorithm>

namespace gnomon::visibility {

namespace {
// If a piece is thinner than this fraction of its length, its side planes are too imprecise.
constexpr double k_min_sine = 1e-9;
}   // namespace

Shaft::Shaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const LightPoint& light, double lift,
             const ShaftRules& rules)
    : light_(light), rules_(rules), lift_(lift), centroid_((corner[0] + corner[1] + corner[2]) / 3.0)
{
    planes_[3] = {normal, -glm::dot(normal, centroid_)};

    // Construct the sides: through each edge and the light, with the third corner inside.
    const double thinnest = rules.margin / k_lift * lift;
    for (int e = 0; e < 3; ++e) {
        const glm::dvec3& a = corner[e];
        const glm::dvec3 along = corner[(e + 1) % 3] - a;
        const glm::dvec3 up = light.directional ? light.place : light.place - a;
        glm::dvec3 n = glm::cross(along, up);
        const double length = glm::length(n);
        if (!(length > k_min_sine * glm::length(along) * glm::length(up))) return;
        n /= length;
        Plane& side = planes_[static_cast<std::size_t>(e)];
        side = {n, -glm::dot(n, a)};
        const double third = side.at(corner[(e + 2) % 3]);
        if (third < 0) side = {-n, -side.distance};
        if (!(std::abs(third) > thinnest)) return;
    }

    // Bound the piece and the light; the prism of a directional light is infinite.
    glm::dvec3 low = glm::min(glm::min(corner[0], corner[1]), corner[2]) - lift;
    glm::dvec3 high = glm::max(glm::max(corner[0], corner[1]), corner[2]) + lift;
    if (light.directional) {
        for (int axis = 0; axis < 3; ++axis) {
            if (light.place[axis] > 0) high[axis] = std::numeric_limits<double>::infinity();
            if (light.place[axis] < 0) low[axis] = -std::numeric_limits<double>::infinity();
        }
        light_height_ = std::numeric_limits<double>::infinity();
    } else {
        low = glm::min(low, light.place);
        high = glm::max(high, light.place);
        light_height_ = planes_[3].at(light.place);
    }
    low_ = glm::vec3(low), high_ = glm::vec3(high);
    for (int axis = 0; axis < 3; ++axis) {
        low_[axis] = std::nextafter(low_[axis], -k_infinity);
        high_[axis] = std::nextafter(high_[axis], k_infinity);
    }
    for (std::size_t k = 0; k < planes_.size(); ++k)
        for (int axis = 0; axis < 3; ++axis)
            furthest_[k][static_cast<std::size_t>(axis)] = planes_[k].normal[axis] > 0 ? 1 : 0;
    valid_ = true;
}

bool Shaft::may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const
{
    const glm::vec3 reach = glm::max(glm::abs(box_low), glm::abs(box_high));
    const ShaftRoom room = room_for(std::max({reach.x, reach.y, reach.z}));
    // Double the margin, so that rounding in single precision cannot reduce it.
    const auto widen = static_cast<float>(2 * room.side);
    for (int axis = 0; axis < 3; ++axis)
        if (box_low[axis] > high_[axis] + widen || box_high[axis] < low_[axis] - widen) return false;
    const glm::dvec3 corner[2] = {glm::dvec3(box_low), glm::dvec3(box_high)};
    for (std::size_t k = 0; k < planes_.size(); ++k) {
        // Test the box corner that is furthest inside.
        const std::array<std::uint8_t, 3>& end = furthest_[k];
        const glm::dvec3 q(corner[end[0]].x, corner[end[1]].y, corner[end[2]].z);
        if (planes_[k].at(q) < (k < 3 ? -room.side : room.base)) return false;
    }
    return true;
}

bool Shaft::clip(const glm::dvec3 (&p)[3], const ShaftRoom& room, ClippedPolygon& clipped) const
{
    std::array<Plane, 4> planes = planes_;
    for (std::size_t k = 0; k < 3; ++k) planes[k].distance += room.side;
    planes[3].distance -= room.base;
    return clip_triangle(planes, p, clipped);
}

bool clip_triangle(const std::array<Plane, 4>& planes, const glm::dvec3 (&p)[3], ClippedPolygon& clipped)
{
    // Return early if all corners are outside one plane, as for most triangles.
    double at[4][3];
    bool cuts[4];
    for (std::size_t k = 0; k < planes.size(); ++k) {
        for (int c = 0; c < 3; ++c) at[k][c] = planes[k].at(p[c]);
        const int outside = (at[k][0] < 0) + (at[k][1] < 0) + (at[k][2] < 0);
        if (outside == 3) return false;
        cuts[k] = outside > 0;
    }

    // Clip by the planes that cut it, one after the other [Sutherland and Hodgman 1974].
    ClippedPolygon other;
    ClippedPolygon *now = &clipped, *next = &other;
    now->corner[0] = p[0], now->corner[1] = p[1], now->corner[2] = p[2];
    now->count = 3;
    for (std::size_t k = 0; k < planes.size(); ++k) {
        if (!cuts[k]) continue;
        const Plane& plane = planes[k];
        next->count = 0;
        const glm::dvec3* before = &now->corner[static_cast<std::size_t>(now->count - 1)];
        double before_at = plane.at(*before);
        for (int c = 0; c < now->count; ++c) {
            const glm::dvec3& here = now->corner[static_cast<std::size_t>(c)];
            const double here_at = plane.at(here);
            if ((before_at < 0) != (here_at < 0)) {
                const double t = before_at / (before_at - here_at);
                next->corner[static_cast<std::size_t>(next->count++)] = *before + t * (here - *before);
            }
            if (here_at >= 0) next->corner[static_cast<std::size_t>(next->count++)] = here;
            before = &here, before_at = here_at;
        }
        if (next->count == 0) return false;
        std::swap(now, next);
    }
    if (now != &clipped) {
        clipped.count = now->count;
        std::copy_n(now->corner.begin(), now->count, clipped.corner.begin());
    }
    return true;
}

bool Shaft::meets_segment(const glm::dvec3& a, const glm::dvec3& b, const ShaftRoom& room) const
{
    double first = 0, last = 1;
    for (std::size_t k = 0; k < planes_.size(); ++k) {
        const double least = k < 3 ? -room.side : room.base;
        const double at_a = planes_[k].at(a) - least, at_b = planes_[k].at(b) - least;
        if (at_a < 0 && at_b < 0) return false;
        if (at_a < 0)
            first = std::max(first, at_a / (at_a - at_b));
        else if (at_b < 0)
            last = std::min(last, at_a / (at_a - at_b));
        if (first > last) return false;
    }
    return true;
}

}   // namespace gnomon::visibility
