// SPDX-License-Identifier: Apache-2.0
#include "area_light/hull_shaft.h"

#include <algorithm>
#include <limits>

namespace gnomon::area_light {

double lowest(const glm::dvec3& normal, std::span<const glm::dvec3> points)
{
    double least = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& p : points) least = std::min(least, glm::dot(normal, p));
    return least;
}

HullShaft::HullShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, std::span<const glm::dvec3> light,
                     double lift, const ShaftRules& rules)
    : rules_(rules), lift_(lift)
{
    for (const glm::dvec3& c : corner) hull_[hull_count_++] = c;
    for (const glm::dvec3& c : light) hull_[hull_count_++] = c;
    add_plane({normal, -lowest(normal, piece())});
}

void HullShaft::finish()
{
    low_ = high_ = hull_[0];
    for (std::size_t k = 1; k < hull_count_; ++k) low_ = glm::min(low_, hull_[k]), high_ = glm::max(high_, hull_[k]);
    for (std::size_t k = 0; k < count_; ++k)
        for (int axis = 0; axis < 3; ++axis)
            furthest_[k][static_cast<std::size_t>(axis)] = planes_[k].normal[axis] > 0 ? 1 : 0;
}

// Adds the plane through an edge and that corner of the other polygon that leaves all of both on one side. Its distance
// is that of the outermost corner, so that the plane encloses everything however imprecise its normal is.
void HullShaft::add_side(const glm::dvec3& a, const glm::dvec3& b, std::span<const glm::dvec3> far, double most_outside)
{
    const glm::dvec3 along = b - a;
    visibility::Plane best;
    double best_width = -1;   // of what the plane leaves outside; the least wins
    for (const glm::dvec3& c : far) {
        glm::dvec3 n = glm::cross(along, c - a);
        const double length = glm::length(n);
        constexpr double k_min_sine = 1e-9;
        if (!(length > k_min_sine * glm::length(along) * glm::length(c - a))) continue;
        n /= length;
        for (const double sign : {1.0, -1.0}) {
            const glm::dvec3 m = sign * n;
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < hull_count_; ++k) least = std::min(least, glm::dot(m, hull_[k]));
            const double width = glm::dot(m, a) - least;
            if (best_width < 0 || width < best_width) best_width = width, best = {m, -least};
        }
    }
    if (best_width >= 0 && best_width <= most_outside) add_plane(best);
}

bool HullShaft::may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const
{
    const glm::dvec3 corner[2] = {glm::dvec3(box_low), glm::dvec3(box_high)};
    const glm::dvec3 reach = glm::max(glm::abs(corner[0]), glm::abs(corner[1]));
    const double coordinate = std::max({reach.x, reach.y, reach.z});
    const double margin = margin_for(coordinate), base = base_for(coordinate), wide = margin + lift_;
    for (int axis = 0; axis < 3; ++axis)
        if (corner[0][axis] > high_[axis] + wide || corner[1][axis] < low_[axis] - wide) return false;
    for (std::size_t k = 0; k < count_; ++k) {
        const std::array<std::uint8_t, 3>& end = furthest_[k];
        const glm::dvec3 q(corner[end[0]].x, corner[end[1]].y, corner[end[2]].z);
        if (planes_[k].at(q) < (k == 0 ? base : -margin)) return false;
    }
    return true;
}

bool HullShaft::may_meet(const visibility::StaticTriangle& triangle) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    const glm::dvec3 p[3] = {glm::dvec3(triangle.p[0]), glm::dvec3(triangle.p[1]), glm::dvec3(triangle.p[2])};
    const double margin = margin_for(coordinate), base = base_for(coordinate);
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = k == 0 ? base : -margin;
        if (planes_[k].at(p[0]) < from && planes_[k].at(p[1]) < from && planes_[k].at(p[2]) < from) return false;
    }
    // All of piece and light may lie on one side of the triangle's plane.
    glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(n);
    if (!(length > 0)) return true;
    n /= length;
    const double room = margin + lift_;
    int above = 0, below = 0;
    for (std::size_t k = 0; k < hull_count_; ++k) {
        const double at = glm::dot(n, hull_[k] - p[0]);
        above += at > room, below += at < -room;
    }
    return above < static_cast<int>(hull_count_) && below < static_cast<int>(hull_count_);
}

bool HullShaft::clip(const visibility::StaticTriangle& triangle, ClippedTriangle& clipped) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    ClippedTriangle other;
    ClippedTriangle *now = &clipped, *next = &other;
    for (std::size_t c = 0; c < 3; ++c) now->corner[c] = glm::dvec3(triangle.p[c]);
    now->count = 3;
    // One plane after the other [Sutherland and Hodgman 1974].
    const double margin = margin_for(coordinate), base = base_for(coordinate);
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = k == 0 ? base : -margin;
        next->count = 0;
        const glm::dvec3* before = &now->corner[static_cast<std::size_t>(now->count - 1)];
        double before_at = planes_[k].at(*before) - from;
        for (int c = 0; c < now->count; ++c) {
            const glm::dvec3& here = now->corner[static_cast<std::size_t>(c)];
            const double here_at = planes_[k].at(here) - from;
            if ((before_at < 0) != (here_at < 0))
                next->corner[static_cast<std::size_t>(next->count++)] =
                    *before + before_at / (before_at - here_at) * (here - *before);
            if (here_at >= 0) next->corner[static_cast<std::size_t>(next->count++)] = here;
            before = &here, before_at = here_at;
        }
        if (next->count == 0) return false;
        std::swap(now, next);
    }
    if (now != &clipped) clipped = *now;
    return true;
}

bool HullShaft::meets_segment(const glm::dvec3& a, const glm::dvec3& b, double coordinate) const
{
    double first = 0, last = 1;
    const double margin = margin_for(coordinate), base = base_for(coordinate);
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = k == 0 ? base : -margin;
        const double at_a = planes_[k].at(a) - from, at_b = planes_[k].at(b) - from;
        if (at_a < 0 && at_b < 0) return false;
        if (at_a < 0)
            first = std::max(first, at_a / (at_a - at_b));
        else if (at_b < 0)
            last = std::min(last, at_a / (at_a - at_b));
        if (first > last) return false;
    }
    return true;
}

}   // namespace gnomon::area_light
