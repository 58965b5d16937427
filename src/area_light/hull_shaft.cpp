// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "area_light/hull_shaft.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "area_light/hull_shaft.h"

#ifndef GNOMON_AREA_LIGHT_HULL_SHAFT_ONCE
#define GNOMON_AREA_LIGHT_HULL_SHAFT_ONCE
namespace gnomon::area_light {
// What the tests below read of a shaft. Every lane computes what the scalar form would, in the same order.
struct HullTests {
    const double *x, *y, *z, *distance;   // planes
    std::size_t end;
    const double *hull_x, *hull_y, *hull_z;
    std::size_t hull_end;
    double base, side;   // where the inside of the first plane begins, and of the others

    HullTests(const HullShaft& shaft, double of_base, double of_side)
        : x(shaft.plane_lanes_.x.data()),
          y(shaft.plane_lanes_.y.data()),
          z(shaft.plane_lanes_.z.data()),
          distance(shaft.plane_lanes_.distance.data()),
          end(shaft.plane_lanes_.end),
          hull_x(shaft.hull_lanes_.x.data()),
          hull_y(shaft.hull_lanes_.y.data()),
          hull_z(shaft.hull_lanes_.z.data()),
          hull_end(shaft.hull_lanes_.end),
          base(of_base),
          side(of_side)
    {
    }
};
}   // namespace gnomon::area_light
#endif

HWY_BEFORE_NAMESPACE();
namespace gnomon::area_light::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, 8>;

// The heights of a point over a vector of planes.
HWY_INLINE auto heights(const HullTests& shaft, std::size_t i, const glm::dvec3& p)
{
    const Doubles d;
    const auto product = hn::Add(
        hn::Add(hn::Mul(hn::Load(d, shaft.x + i), hn::Set(d, p.x)), hn::Mul(hn::Load(d, shaft.y + i), hn::Set(d, p.y))),
        hn::Mul(hn::Load(d, shaft.z + i), hn::Set(d, p.z)));
    return hn::Add(product, hn::Load(d, shaft.distance + i));
}

HWY_INLINE auto inside_from(const HullTests& shaft, std::size_t i)
{
    const Doubles d;
    const auto side = hn::Set(d, shaft.side);
    return i == 0 ? hn::IfThenElse(hn::FirstN(d, 1), hn::Set(d, shaft.base), side) : side;
}

bool box_may_meet(const HullTests& shaft, const glm::dvec3& low, const glm::dvec3& high)
{
    const Doubles d;
    for (std::size_t i = 0; i < shaft.end; i += hn::Lanes(d)) {
        // The corner that lies furthest inside.
        const auto most = [&](const double* normal, double a, double b) HWY_ATTR {
            const auto n = hn::Load(d, normal + i);
            return hn::Max(hn::Mul(n, hn::Set(d, a)), hn::Mul(n, hn::Set(d, b)));
        };
        const auto at = hn::Add(
            hn::Add(hn::Add(most(shaft.x, low.x, high.x), most(shaft.y, low.y, high.y)), most(shaft.z, low.z, high.z)),
            hn::Load(d, shaft.distance + i));
        if (!hn::AllFalse(d, hn::Lt(at, inside_from(shaft, i)))) return false;
    }
    return true;
}

bool triangle_may_meet(const HullTests& shaft, const glm::dvec3 (&p)[3], double room)
{
    const Doubles d;
    for (std::size_t i = 0; i < shaft.end; i += hn::Lanes(d)) {
        const auto from = inside_from(shaft, i);
        const auto outside =
            hn::And(hn::And(hn::Lt(heights(shaft, i, p[0]), from), hn::Lt(heights(shaft, i, p[1]), from)),
                    hn::Lt(heights(shaft, i, p[2]), from));
        if (!hn::AllFalse(d, outside)) return false;
    }
    // All of piece and light may lie on one side of the triangle's plane.
    glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(n);
    if (!(length > 0)) return true;
    n /= length;
    bool all_above = true, all_below = true;
    for (std::size_t i = 0; i < shaft.hull_end; i += hn::Lanes(d)) {
        const auto at =
            hn::Add(hn::Add(hn::Mul(hn::Set(d, n.x), hn::Sub(hn::Load(d, shaft.hull_x + i), hn::Set(d, p[0].x))),
                            hn::Mul(hn::Set(d, n.y), hn::Sub(hn::Load(d, shaft.hull_y + i), hn::Set(d, p[0].y)))),
                    hn::Mul(hn::Set(d, n.z), hn::Sub(hn::Load(d, shaft.hull_z + i), hn::Set(d, p[0].z))));
        all_above = all_above && hn::AllTrue(d, hn::Gt(at, hn::Set(d, room)));
        all_below = all_below && hn::AllTrue(d, hn::Lt(at, hn::Set(d, -room)));
    }
    return !all_above && !all_below;
}

bool corner_inside(const HullTests& shaft, const glm::dvec3 (&p)[3])
{
    const Doubles d;
    for (const glm::dvec3& corner : p) {
        bool inside = true;
        for (std::size_t i = 0; inside && i < shaft.end; i += hn::Lanes(d))
            inside = hn::AllTrue(d, hn::Ge(heights(shaft, i, corner), inside_from(shaft, i)));
        if (inside) return true;
    }
    return false;
}

}   // namespace gnomon::area_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <limits>

namespace gnomon::area_light {

HWY_EXPORT(box_may_meet);
HWY_EXPORT(triangle_may_meet);
HWY_EXPORT(corner_inside);

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
    plane_lanes_.end = (count_ + 7) / 8 * 8, hull_lanes_.end = (hull_count_ + 7) / 8 * 8;
    for (std::size_t k = 0; k < plane_lanes_.end; ++k) {
        const visibility::Plane plane =
            k < count_ ? planes_[k] : visibility::Plane{glm::dvec3(0), std::numeric_limits<double>::infinity()};
        plane_lanes_.x[k] = plane.normal.x, plane_lanes_.y[k] = plane.normal.y, plane_lanes_.z[k] = plane.normal.z;
        plane_lanes_.distance[k] = plane.distance;
    }
    for (std::size_t k = 0; k < hull_lanes_.end; ++k) {
        const glm::dvec3& p = hull_[k < hull_count_ ? k : 0];
        hull_lanes_.x[k] = p.x, hull_lanes_.y[k] = p.y, hull_lanes_.z[k] = p.z;
    }
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
    const glm::dvec3 low(box_low), high(box_high);
    const glm::dvec3 reach = glm::max(glm::abs(low), glm::abs(high));
    const double coordinate = std::max({reach.x, reach.y, reach.z});
    const double margin = margin_for(coordinate), wide = margin + lift_;
    for (int axis = 0; axis < 3; ++axis)
        if (low[axis] > high_[axis] + wide || high[axis] < low_[axis] - wide) return false;
    return HWY_DYNAMIC_DISPATCH(box_may_meet)(HullTests(*this, base_for(coordinate), -margin), low, high);
}

bool HullShaft::may_meet(const visibility::StaticTriangle& triangle) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    const glm::dvec3 p[3] = {glm::dvec3(triangle.p[0]), glm::dvec3(triangle.p[1]), glm::dvec3(triangle.p[2])};
    const double margin = margin_for(coordinate);
    return HWY_DYNAMIC_DISPATCH(triangle_may_meet)(HullTests(*this, base_for(coordinate), -margin), p, margin + lift_);
}

bool HullShaft::has_corner_inside(const visibility::StaticTriangle& triangle) const
{
    const double coordinate = static_cast<double>(visibility::largest_coordinate(triangle));
    const glm::dvec3 p[3] = {glm::dvec3(triangle.p[0]), glm::dvec3(triangle.p[1]), glm::dvec3(triangle.p[2])};
    return HWY_DYNAMIC_DISPATCH(corner_inside)(HullTests(*this, base_for(coordinate), -margin_for(coordinate)), p);
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
#endif
