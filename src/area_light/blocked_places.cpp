// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "area_light/blocked_places.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>

#include "area_light/blocked_places.h"
#include "base/math.h"
#include "ray/origin.h"

#ifndef GNOMON_AREA_LIGHT_BLOCKED_PLACES_ONCE
#define GNOMON_AREA_LIGHT_BLOCKED_PLACES_ONCE
namespace gnomon::area_light {
// What a triangle or quadrilateral hides of each row, by lane. The first function is of its plane, the others are of
// its edges; a triangle has one less. A row runs from t = 0 to 1; place i of it is at 64 t = i + shift.
struct Functions {
    static constexpr std::size_t k_lanes = 16, k_count = 5;
    // A function is 0 at 64 t = zero + start * zero_by_start, for the s where a row starts. What is hidden lies beyond
    // that place (side 1), before it (side -1), or anywhere as far as this function goes (side 0).
    alignas(64) float zero[k_count][k_lanes];
    alignas(64) float zero_by_start[k_count][k_lanes];
    alignas(64) float side[k_count][k_lanes];
    // Functions that do not change along a row: at + start * by_start >= 0 in rows of which something may be hidden.
    alignas(64) float at[k_count][k_lanes];
    alignas(64) float by_start[k_count][k_lanes];
    alignas(64) float constant[k_lanes];                       // 1: there is one that is negative in some row, else 0
    alignas(64) float splits[k_lanes];                         // 1: seen edge-on, a quadrilateral is not convex; else 0
    alignas(64) float meets[k_lanes];                          // 1: some place may be hidden, else 0
    alignas(64) float first_row[k_lanes], last_row[k_lanes];   // outside of them, nothing is hidden
};
// Points, by lane.
struct PointLanes {
    alignas(64) float at[3][Functions::k_lanes];

    // Sets so many lanes to one point.
    void set(std::size_t first, std::size_t count, const glm::vec3& p)
    {
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t lane = first; lane < first + count; ++lane) at[axis][lane] = p[axis];
    }
};
// A function whose slope along a row is smaller than this fraction of its values counts as constant.
inline constexpr float k_flat_slope = 1e-12f;
// More than the largest start of a row, so that it bounds what a function changes by from row to row.
inline constexpr float k_most_start = 1.25f;
struct Rows {
    alignas(64) std::array<float, k_rows> start, shift;
};
inline const Rows& rows()
{
    static const Rows made = [] {
        Rows r;
        for (int i = 0; i < k_rows; ++i) {
            r.start[static_cast<std::size_t>(i)] = LightPlaces::row_start(i);
            r.shift[static_cast<std::size_t>(i)] = LightPlaces::row_shift(i);
        }
        return r;
    }();
    return made;
}
}   // namespace gnomon::area_light
#endif

HWY_BEFORE_NAMESPACE();
namespace gnomon::area_light::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct Three {
    V x, y, z;
};
template <class V>
HWY_INLINE Three<V> cross(const Three<V>& a, const Three<V>& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE V dot(const Three<V>& a, const Three<V>& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V>
HWY_INLINE Three<V> minus(const Three<V>& a, const Three<V>& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

// Finds the functions of one vector of triangles, each for the point of its lane.
void find_functions(const PointLanes& points, const TriangleList& triangles, std::size_t first,
                    const LightPlaces& places, Functions& out)
{
    const hn::CappedTag<float, Functions::k_lanes> d;
    using V = hn::Vec<decltype(d)>;
    const auto all = [&](const glm::vec3& v) HWY_ATTR {
        return Three<V>{hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)};
    };
    const Three<V> s = all(places.side_s()), t = all(places.side_t()), origin = all(places.origin()),
                   light_normal = all(places.row_plane().normal), light_row = all(places.row_plane().row);
    const auto zero = hn::Zero(d), end = hn::Set(d, ray::k_shadow_ray_end),
               all_rows = hn::Set(d, static_cast<float>(k_rows - 1));
    for (std::size_t lane = 0; lane < Functions::k_lanes; lane += hn::Lanes(d)) {
        const Three<V> p{hn::Load(d, points.at[0] + lane), hn::Load(d, points.at[1] + lane),
                         hn::Load(d, points.at[2] + lane)};
        const Three<V> to = minus(origin, p);
        // The direction r meets the light's plane in row dot(r, by_row) / dot(r, normal_to_light) + row_of_point.
        const V above = dot(light_normal, to);
        const auto behind = hn::Lt(above, zero);
        const auto turned = [&](V v) HWY_ATTR { return hn::IfThenElse(behind, hn::Neg(v), v); };
        const Three<V> normal_to_light{turned(light_normal.x), turned(light_normal.y), turned(light_normal.z)};
        const V height_of_point = hn::Abs(above);
        const Three<V> by_row{hn::Mul(height_of_point, light_row.x), hn::Mul(height_of_point, light_row.y),
                              hn::Mul(height_of_point, light_row.z)};
        const V row_of_point = hn::Add(dot(light_row, minus(p, origin)), hn::Set(d, LightPlaces::row_at_origin()));
        Three<V> r[4];
        for (std::size_t c = 0; c < 4; ++c)
            r[c] =
                minus({hn::LoadU(d, triangles.at(c, 0) + first + lane), hn::LoadU(d, triangles.at(c, 1) + first + lane),
                       hn::LoadU(d, triangles.at(c, 2) + first + lane)},
                      p);
        const Three<V> side[4] = {cross(r[0], r[1]), cross(r[1], r[2]), cross(r[3], r[0]), cross(r[2], r[3])};
        // The volume's sign tells on which side of the triangle the point is; turn all functions so that it is
        // positive.
        const V volume = dot(side[0], r[2]);
        // Project the corners to the light's plane, for the rows that they span.
        auto before_point = hn::FirstN(d, 0);
        V first_row = hn::Set(d, k_infinity), last_row = hn::Set(d, -k_infinity);
        for (const Three<V>& corner : r) {
            const V along = dot(corner, normal_to_light);
            before_point = hn::Or(before_point, hn::Not(hn::Gt(along, zero)));
            const V row = hn::Add(hn::Div(dot(corner, by_row), along), row_of_point);
            first_row = hn::Min(first_row, row), last_row = hn::Max(last_row, row);
        }
        // A corner that is not before the point may be anywhere; a row more on either side covers the rounding.
        constexpr float k_exact = 1e5f;
        const auto anywhere =
            hn::Or(before_point,
                   hn::Not(hn::And(hn::Gt(first_row, hn::Set(d, -k_exact)), hn::Lt(last_row, hn::Set(d, k_exact)))));
        first_row = hn::IfThenElse(anywhere, zero, hn::Sub(first_row, hn::Set(d, 1.0f)));
        last_row = hn::IfThenElse(anywhere, all_rows, hn::Add(last_row, hn::Set(d, 1.0f)));
        hn::Store(hn::Min(hn::Max(first_row, zero), all_rows), d, out.first_row + lane);
        hn::Store(hn::Min(hn::Max(last_row, hn::Set(d, -1.0f)), all_rows), d, out.last_row + lane);
        const auto back = hn::Lt(volume, zero);
        // Rounding may put the point before one half of a quadrilateral and behind the other. (A triangle's last two
        // volumes are 0.)
        const V volumes[3] = {dot(side[1], r[3]), dot(side[2], r[1]), dot(side[3], r[0])};
        auto splits = hn::Eq(volume, zero);
        for (const V& other : volumes)
            splits = hn::Or(splits, hn::Or(hn::And(back, hn::Gt(other, zero)), hn::AndNot(back, hn::Lt(other, zero))));
        hn::Store(hn::IfThenElseZero(splits, hn::Set(d, 1.0f)), d, out.splits + lane);
        auto meets = hn::Ne(volume, zero);
        auto constant = hn::FirstN(d, 0);
        const auto slant = hn::Set(d, LightPlaces::slant), places_in_row = hn::Set(d, static_cast<float>(k_row_places)),
                   one = hn::Set(d, 1.0f);
        const auto store = [&](std::size_t e, V at, V by_s, V by_t) HWY_ATTR {
            at = hn::IfThenElse(back, hn::Neg(at), at);
            by_s = hn::IfThenElse(back, hn::Neg(by_s), by_s);
            by_t = hn::IfThenElse(back, hn::Neg(by_t), by_t);
            const V along = hn::Add(hn::Mul(slant, by_s), by_t);
            const auto slopes =
                hn::Gt(hn::Abs(along), hn::Mul(hn::Max(hn::Abs(at), hn::Abs(by_s)), hn::Set(d, k_flat_slope)));
            const V inverse = hn::IfThenElseZero(slopes, hn::Div(hn::Neg(one), along));
            hn::Store(hn::Mul(hn::Mul(at, inverse), places_in_row), d, out.zero[e] + lane);
            hn::Store(hn::Mul(hn::Mul(by_s, inverse), places_in_row), d, out.zero_by_start[e] + lane);
            hn::Store(hn::IfThenElseZero(slopes, hn::CopySign(one, along)), d, out.side[e] + lane);
            hn::Store(hn::IfThenElseZero(hn::Not(slopes), at), d, out.at[e] + lane);
            hn::Store(hn::IfThenElseZero(hn::Not(slopes), by_s), d, out.by_start[e] + lane);
            constant =
                hn::Or(constant, hn::AndNot(slopes, hn::Lt(at, hn::Mul(hn::Abs(by_s), hn::Set(d, k_most_start)))));
            return hn::Add(hn::Add(at, hn::Max(by_s, zero)), hn::Max(by_t, zero));   // the largest over the light
        };
        for (std::size_t e = 0; e < 4; ++e)
            meets = hn::And(meets, hn::Ge(store(1 + e, dot(side[e], to), dot(side[e], s), dot(side[e], t)), zero));
        const Three<V> normal = cross(minus(r[1], r[0]), minus(r[2], r[0]));
        const V height = dot(normal, r[0]);
        const V most = store(0, hn::Sub(hn::Mul(end, dot(normal, to)), height), hn::Mul(end, dot(normal, s)),
                             hn::Mul(end, dot(normal, t)));
        meets = hn::And(meets, hn::Ge(most, zero));
        hn::Store(hn::IfThenElseZero(meets, one), d, out.meets + lane);
        hn::Store(hn::IfThenElseZero(constant, one), d, out.constant + lane);
    }
}

// Adds the runs of one triangle or quadrilateral to all rows.
void add_runs(const Functions& f, std::size_t lane, std::size_t corners, PlaceMask& blocked)
{
    const auto first_row = static_cast<std::size_t>(f.first_row[lane]),
               last_row = static_cast<std::size_t>(f.last_row[lane]);
    const hn::CappedTag<float, 16> d;
    const hn::Rebind<std::int32_t, decltype(d)> di;
    const Rows& row = rows();
    alignas(64) std::int32_t begin[k_rows], end[k_rows];
    const auto places = hn::Set(d, static_cast<float>(k_row_places)), before = hn::Set(d, -1.0f), zero = hn::Zero(d),
               last = hn::Set(d, static_cast<float>(k_row_places - 1));
    for (std::size_t i = first_row / hn::Lanes(d) * hn::Lanes(d); i <= last_row; i += hn::Lanes(d)) {
        const auto start = hn::Load(d, row.start.data() + i), shift = hn::Load(d, row.shift.data() + i);
        auto low = hn::Set(d, -k_infinity), high = hn::Set(d, k_infinity);
        for (std::size_t e = 0; e <= corners; ++e) {
            const auto side = hn::Set(d, f.side[e][lane]);
            const auto at = hn::Add(hn::Set(d, f.zero[e][lane]), hn::Mul(start, hn::Set(d, f.zero_by_start[e][lane])));
            low = hn::IfThenElse(hn::Gt(side, zero), hn::Max(low, at), low);
            high = hn::IfThenElse(hn::Lt(side, zero), hn::Min(high, at), high);
        }
        low = hn::Max(hn::Sub(low, shift), zero), high = hn::Min(hn::Sub(high, shift), last);
        if (f.constant[lane] != 0)
            for (std::size_t e = 0; e <= corners; ++e) {
                const auto at = hn::Add(hn::Set(d, f.at[e][lane]), hn::Mul(start, hn::Set(d, f.by_start[e][lane])));
                high = hn::IfThenElse(hn::Lt(at, zero), before, high);
            }
        low = hn::Ceil(hn::Min(low, places)), high = hn::Floor(hn::Max(high, before));
        hn::Store(hn::ConvertTo(di, low), di, begin + i);
        hn::Store(hn::ConvertTo(di, high), di, end + i);
    }
    const hn::CappedTag<std::uint64_t, 8> du;
    const hn::RebindToSigned<decltype(du)> ds;
    const hn::Rebind<std::int32_t, decltype(ds)> dh;
    const auto ones = hn::Set(du, ~std::uint64_t{0});
    const auto top = hn::Set(ds, k_row_places - 1);
    for (std::size_t i = first_row / hn::Lanes(du) * hn::Lanes(du); i <= last_row; i += hn::Lanes(du)) {
        const auto from = hn::PromoteTo(ds, hn::LoadU(dh, begin + i)), to = hn::PromoteTo(ds, hn::LoadU(dh, end + i));
        const auto none = hn::Gt(from, to);
        const auto left = hn::IfThenZeroElse(none, from), right = hn::IfThenZeroElse(none, hn::Sub(top, to));
        const auto run = hn::And(hn::Shl(ones, hn::BitCast(du, left)), hn::Shr(ones, hn::BitCast(du, right)));
        const auto kept = hn::IfThenZeroElse(hn::RebindMask(du, none), run);
        hn::StoreU(hn::Or(hn::LoadU(du, blocked.data() + i), kept), du, blocked.data() + i);
    }
}

bool all_hidden(const LightPlaces& places, const PlaceMask& blocked)
{
    const hn::CappedTag<std::uint64_t, 8> d;
    auto seen = hn::Zero(d);
    for (std::size_t i = 0; i < k_rows; i += hn::Lanes(d))
        seen = hn::Or(seen, hn::AndNot(hn::LoadU(d, blocked.data() + i), hn::LoadU(d, places.inside().data() + i)));
    return hn::AllTrue(d, hn::Eq(seen, hn::Zero(d)));
}

// Adds what entries of a list hide, whose functions are those of so many lanes.
// @param halves  gets the triangles of quadrilaterals that the point sees edge-on
bool add_entries(const TriangleList& triangles, std::size_t first, std::size_t count, const Functions& f,
                 std::size_t first_lane, TriangleList& halves, PlaceMask& blocked)
{
    bool any = false;
    for (std::size_t entry = 0; entry < count; ++entry) {
        const std::size_t lane = first_lane + entry;
        const auto corners = static_cast<std::size_t>(triangles.corners(first + entry));
        if (corners == 4 && f.splits[lane] != 0) {
            triangles.push_halves(first + entry, halves);
        } else if (f.meets[lane] != 0 && f.first_row[lane] <= f.last_row[lane]) {
            add_runs(f, lane, corners, blocked);
            any = true;
        }
    }
    return any;
}

bool add_blocked_of(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places,
                    PlaceMask& blocked)
{
    Functions f;
    bool any = false;
    TriangleList halves;
    PointLanes points;
    points.set(0, Functions::k_lanes, point);
    for (std::size_t first = 0; first < triangles.size(); first += Functions::k_lanes) {
        find_functions(points, triangles, first, places, f);
        const std::size_t count = std::min(Functions::k_lanes, triangles.size() - first);
        any |= add_entries(triangles, first, count, f, 0, halves, blocked);
        // Leave the rest out if nothing is left to hide.
        if (any && first + Functions::k_lanes < triangles.size() && all_hidden(places, blocked)) return true;
    }
    if (halves.size() == 0) return any;
    halves.pad();
    const bool by_halves = add_blocked_of(point, halves, places, blocked);
    return any || by_halves;
}

void add_blocked_of_each(std::span<const glm::vec3> points, const TriangleList& triangles, const LightPlaces& places,
                         PlaceMask* blocked, bool* hides)
{
    // A short list is there several times in a vector, once for each of several points.
    const std::size_t lanes = triangles.lanes(), at_once = Functions::k_lanes / lanes;
    PointLanes of;
    Functions f;
    TriangleList halves;
    for (std::size_t first = 0; first < points.size(); first += at_once) {
        const std::size_t count = std::min(at_once, points.size() - first);
        for (std::size_t k = 0; k < at_once; ++k) of.set(k * lanes, lanes, points[first + std::min(k, count - 1)]);
        find_functions(of, triangles, 0, places, f);
        for (std::size_t k = 0; k < count; ++k) {
            PlaceMask& mask = blocked[first + k];
            hides[first + k] = add_entries(triangles, 0, triangles.size(), f, k * lanes, halves, mask);
            if (halves.size() == 0) continue;
            halves.pad();
            hides[first + k] |= add_blocked_of(points[first + k], halves, places, mask);
            halves.clear();
        }
    }
}

void for_each_blocker_of(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places,
                         const std::function<void(std::size_t, const PlaceMask&)>& hides)
{
    Functions f;
    PointLanes points;
    points.set(0, Functions::k_lanes, point);
    for (std::size_t first = 0; first < triangles.size(); first += Functions::k_lanes) {
        find_functions(points, triangles, first, places, f);
        const std::size_t count = std::min(Functions::k_lanes, triangles.size() - first);
        for (std::size_t lane = 0; lane < count; ++lane) {
            if (f.meets[lane] == 0 || !(f.first_row[lane] <= f.last_row[lane])) continue;
            PlaceMask mask{};
            add_runs(f, lane, static_cast<std::size_t>(triangles.corners(first + lane)), mask);
            hides(first + lane, mask);
        }
    }
}

}   // namespace gnomon::area_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace gnomon::area_light {

HWY_EXPORT(add_blocked_of);
HWY_EXPORT(add_blocked_of_each);
HWY_EXPORT(for_each_blocker_of);

bool add_blocked(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places, PlaceMask& blocked)
{
    return HWY_DYNAMIC_DISPATCH(add_blocked_of)(point, triangles, places, blocked);
}

void add_blocked(std::span<const glm::vec3> points, const TriangleList& triangles, const LightPlaces& places,
                 std::span<PlaceMask> blocked, std::span<bool> hides)
{
    if (triangles.size() <= TriangleList::k_pad && triangles.size() > 0) {
        HWY_DYNAMIC_DISPATCH(add_blocked_of_each)(points, triangles, places, blocked.data(), hides.data());
        return;
    }
    for (std::size_t k = 0; k < points.size(); ++k) hides[k] = add_blocked(points[k], triangles, places, blocked[k]);
}

void for_each_blocker(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places,
                      const std::function<void(std::size_t, const PlaceMask&)>& hides)
{
    HWY_DYNAMIC_DISPATCH(for_each_blocker_of)(point, triangles, places, hides);
}

void TriangleList::grow()
{
    const std::size_t size = corners_.empty() ? 4 * k_pad : 2 * corners_.size();
    for (auto& corner : at_)
        for (auto& axis : corner) axis.resize(size);
    corners_.resize(size);
}

void TriangleList::push_halves(std::size_t entry, TriangleList& halves) const
{
    glm::vec3 p[4];
    for (std::size_t c = 0; c < 4; ++c)
        for (int axis = 0; axis < 3; ++axis) p[c][axis] = at_[c][static_cast<std::size_t>(axis)][entry];
    halves.push({p[0], p[1], p[3]});
    halves.push({p[1], p[2], p[3]});
}

namespace {

// Repeats the first entries of a vector to its end.
template <std::size_t Period>
void repeat(float* values)
{
    float first[Period];
    std::copy_n(values, Period, first);
    for (std::size_t k = 0; k < TriangleList::k_pad; ++k) values[k] = first[k % Period];
}

}   // namespace

void TriangleList::pad()
{
    if (count_ == 0) return;
    const std::size_t padded = (count_ + k_pad - 1) / k_pad * k_pad;   // within the size, a multiple of it
    const std::size_t period = count_ <= k_pad ? lanes() : padded;
    for (auto& corner : at_)
        for (auto& axis : corner) {
            for (std::size_t k = count_; k < period; ++k) axis[k] = axis[count_ - 1];
            switch (period) {
                case 1:
                    repeat<1>(axis.data());
                    break;
                case 2:
                    repeat<2>(axis.data());
                    break;
                case 4:
                    repeat<4>(axis.data());
                    break;
                case 8:
                    repeat<8>(axis.data());
                    break;
                default:
                    break;
            }
        }
}

bool blocks_place(const glm::vec3& point, const glm::vec3 (&corner)[3], const LightPlaces& places, int row, int place)
{
    const auto product = [](const glm::vec3& a, const glm::vec3& b) {
        return glm::vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    };
    const auto scalar = [](const glm::vec3& a, const glm::vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    const glm::vec3 r[3] = {corner[0] - point, corner[1] - point, corner[2] - point};
    const glm::vec3 side[3] = {product(r[0], r[1]), product(r[1], r[2]), product(r[2], r[0])};
    const float volume = scalar(side[0], r[2]);
    if (volume == 0) return false;
    const glm::vec3 normal = product(r[1] - r[0], r[2] - r[0]), to = places.origin() - point;
    const float start = LightPlaces::row_start(row), shift = LightPlaces::row_shift(row);
    float low = -k_infinity, high = k_infinity;
    for (int e = 0; e < 4; ++e) {
        const float end = ray::k_shadow_ray_end;
        float at = e < 3 ? scalar(side[e], to) : end * scalar(normal, to) - scalar(normal, r[0]);
        float by_s = e < 3 ? scalar(side[e], places.side_s()) : end * scalar(normal, places.side_s());
        float by_t = e < 3 ? scalar(side[e], places.side_t()) : end * scalar(normal, places.side_t());
        if (volume < 0) at = -at, by_s = -by_s, by_t = -by_t;
        if (!(at + std::max(by_s, 0.0f) + std::max(by_t, 0.0f) >= 0)) return false;
        const float along = LightPlaces::slant * by_s + by_t;
        if (!(std::abs(along) > std::max(std::abs(at), std::abs(by_s)) * k_flat_slope)) {
            if (at + start * by_s < 0) return false;
            continue;
        }
        const float inverse = -1.0f / along;
        const float zero_at = at * inverse * static_cast<float>(k_row_places) +
                              start * (by_s * inverse * static_cast<float>(k_row_places));
        if (along > 0)
            low = std::max(low, zero_at);
        else
            high = std::min(high, zero_at);
    }
    low = std::max(low - shift, 0.0f), high = std::min(high - shift, static_cast<float>(k_row_places - 1));
    return static_cast<float>(place) >= std::ceil(low) && static_cast<float>(place) <= std::floor(high);
}

}   // namespace gnomon::area_light
#endif
