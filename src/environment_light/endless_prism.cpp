// SPDX-License-Identifier: Apache-2.0
#include "environment_light/endless_prism.h"

#include <algorithm>
#include <limits>

namespace gnomon::environment_light {

namespace {

constexpr double k_least_sine = 1e-9;   // of two directions that span a plane
constexpr double k_rounding = 1e-12;    // of a direction's component along a plane that contains it

}   // namespace

EndlessPrism::EndlessPrism(const glm::dvec3 (&corner)[3], const glm::dvec3& normal,
                           std::span<const glm::dvec3> direction, double lift, const PrismRules& rules)
    : rules_(rules), lift_(lift), piece_{corner[0], corner[1], corner[2]}
{
    const auto lowest = [&](const glm::dvec3& n) {
        return std::min({glm::dot(n, piece_[0]), glm::dot(n, piece_[1]), glm::dot(n, piece_[2])});
    };
    planes_[count_++] = {normal, -lowest(normal)};

    // The sides of the cone, and through each edge those planes along a corner of the cone that have all of it on one
    // side.
    if (direction.size() > 1)
        for (std::size_t k = 0; k < direction.size(); ++k)
            add_side(glm::cross(direction[k], direction[(k + 1) % direction.size()]), direction);
    for (int e = 0; e < 3; ++e) {
        const glm::dvec3 along = piece_[(e + 1) % 3] - piece_[e];
        int added = 0;
        for (const glm::dvec3& d : direction) {
            if (added == 2) break;
            const std::size_t before = count_;
            const double length = glm::length(along);
            if (!(length > 0)) break;
            add_side(glm::cross(along / length, d), direction);
            added += count_ > before;
        }
    }
    for (std::size_t k = 0; k < count_; ++k)
        for (int axis = 0; axis < 3; ++axis)
            furthest_[k][static_cast<std::size_t>(axis)] = planes_[k].normal[axis] > 0 ? 1 : 0;
}

// Adds a plane with this normal, turned inward, if the cone has no direction on its outer side.
void EndlessPrism::add_side(glm::dvec3 normal, std::span<const glm::dvec3> direction)
{
    const double length = glm::length(normal);
    if (!(length > k_least_sine) || count_ == k_most_planes) return;
    normal /= length;
    double low = 0, high = 0;
    for (const glm::dvec3& d : direction) {
        const double at = glm::dot(normal, d);
        low = std::min(low, at), high = std::max(high, at);
    }
    if (direction.size() == 1) {
        // Both sides are possible: the inner one has the piece.
        const glm::dvec3 at(glm::dot(normal, piece_[0]), glm::dot(normal, piece_[1]), glm::dot(normal, piece_[2]));
        const double middle = (at.x + at.y + at.z) / 3;
        const double below = middle - std::min({at.x, at.y, at.z}), above = std::max({at.x, at.y, at.z}) - middle;
        if (above < below) normal = -normal;
    } else if (low < -k_rounding) {
        if (high > k_rounding) return;
        normal = -normal;
    }
    const double least =
        std::min({glm::dot(normal, piece_[0]), glm::dot(normal, piece_[1]), glm::dot(normal, piece_[2])});
    planes_[count_++] = {normal, -least};
}

// The least value of a plane's function inside the prism, enlarged for a coordinate of this size.
double EndlessPrism::least(std::size_t plane, double coordinate) const
{
    const double most = lift_for(coordinate);
    return plane == 0 ? lift_ - rules_.room * most : -rules_.margin / k_lift * most;
}

bool EndlessPrism::may_meet(const glm::vec3& box_low, const glm::vec3& box_high) const
{
    const glm::dvec3 corner[2] = {glm::dvec3(box_low), glm::dvec3(box_high)};
    const glm::dvec3 reach = glm::max(glm::abs(corner[0]), glm::abs(corner[1]));
    const double coordinate = std::max({reach.x, reach.y, reach.z});
    for (std::size_t k = 0; k < count_; ++k) {
        const std::array<std::uint8_t, 3>& end = furthest_[k];
        const glm::dvec3 q(corner[end[0]].x, corner[end[1]].y, corner[end[2]].z);
        if (planes_[k].at(q) < least(k, coordinate)) return false;
    }
    return true;
}

bool EndlessPrism::may_meet(const visibility::StaticTriangle& triangle) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    const glm::dvec3 p[3] = {glm::dvec3(triangle.p[0]), glm::dvec3(triangle.p[1]), glm::dvec3(triangle.p[2])};
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = least(k, coordinate);
        if (planes_[k].at(p[0]) < from && planes_[k].at(p[1]) < from && planes_[k].at(p[2]) < from) return false;
    }
    return true;
}

bool EndlessPrism::clip(const visibility::StaticTriangle& triangle, ClippedTriangle& clipped) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    ClippedTriangle other;
    ClippedTriangle *now = &clipped, *next = &other;
    for (std::size_t c = 0; c < 3; ++c) now->corner[c] = glm::dvec3(triangle.p[c]);
    now->count = 3;
    // One plane after the other [Sutherland and Hodgman 1974].
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = least(k, coordinate);
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

bool EndlessPrism::meets_segment(const glm::dvec3& a, const glm::dvec3& b, double coordinate) const
{
    double first = 0, last = 1;
    for (std::size_t k = 0; k < count_; ++k) {
        const double from = least(k, coordinate);
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

}   // namespace gnomon::environment_light
