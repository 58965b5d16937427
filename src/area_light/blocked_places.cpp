// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "area_light/blocked_places.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "area_light/blocked_places.h"
#include "ray/origin.h"

#ifndef GNOMON_AREA_LIGHT_BLOCKED_PLACES_ONCE
#define GNOMON_AREA_LIGHT_BLOCKED_PLACES_ONCE
namespace gnomon::area_light {
// The four linear functions of a triangle over the light, by lane: at + s * by_s + t * by_t >= 0 where it hides.
struct Functions {
    static constexpr std::size_t k_lanes = 16;
    alignas(64) float at[4][k_lanes];
    alignas(64) float by_s[4][k_lanes];
    alignas(64) float by_t[4][k_lanes];
    alignas(64) float meets[k_lanes];   // 1: some place may be hidden, else 0
};
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

// Finds the functions of one vector of triangles.
void find_functions(const glm::vec3& point, const TriangleList& triangles, std::size_t first, const LightPlaces& places,
                    Functions& out)
{
    const hn::CappedTag<float, Functions::k_lanes> d;
    using V = hn::Vec<decltype(d)>;
    const auto all = [&](const glm::vec3& v) HWY_ATTR {
        return Three<V>{hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)};
    };
    const Three<V> p = all(point), to = all(places.origin() - point), s = all(places.side_s()),
                   t = all(places.side_t());
    const auto zero = hn::Zero(d), end = hn::Set(d, ray::k_shadow_ray_end);
    for (std::size_t lane = 0; lane < Functions::k_lanes; lane += hn::Lanes(d)) {
        Three<V> r[3];
        for (std::size_t c = 0; c < 3; ++c)
            r[c] = minus({hn::LoadU(d, triangles.at[c][0].data() + first + lane),
                          hn::LoadU(d, triangles.at[c][1].data() + first + lane),
                          hn::LoadU(d, triangles.at[c][2].data() + first + lane)},
                         p);
        const Three<V> side[3] = {cross(r[0], r[1]), cross(r[1], r[2]), cross(r[2], r[0])};
        // The volume's sign tells on which side of the triangle the point is; turn all functions so that it is
        // positive.
        const V volume = dot(side[0], r[2]);
        const auto back = hn::Lt(volume, zero);
        auto meets = hn::Ne(volume, zero);
        const auto store = [&](std::size_t e, V at, V by_s, V by_t) HWY_ATTR {
            at = hn::IfThenElse(back, hn::Neg(at), at);
            by_s = hn::IfThenElse(back, hn::Neg(by_s), by_s);
            by_t = hn::IfThenElse(back, hn::Neg(by_t), by_t);
            hn::Store(at, d, out.at[e] + lane);
            hn::Store(by_s, d, out.by_s[e] + lane);
            hn::Store(by_t, d, out.by_t[e] + lane);
            return hn::Add(hn::Add(at, hn::Max(by_s, zero)), hn::Max(by_t, zero));   // the largest over the light
        };
        for (std::size_t e = 0; e < 3; ++e)
            meets = hn::And(meets, hn::Ge(store(e, dot(side[e], to), dot(side[e], s), dot(side[e], t)), zero));
        const Three<V> normal = cross(minus(r[1], r[0]), minus(r[2], r[0]));
        const V height = dot(normal, r[0]);
        const V most = store(3, hn::Sub(hn::Mul(end, dot(normal, to)), height), hn::Mul(end, dot(normal, s)),
                             hn::Mul(end, dot(normal, t)));
        meets = hn::And(meets, hn::Ge(most, zero));
        hn::Store(hn::IfThenElseZero(meets, hn::Set(d, 1.0f)), d, out.meets + lane);
    }
}

// Adds the runs of one triangle to all rows.
void add_runs(const Functions& f, std::size_t lane, PlaceMask& blocked)
{
    const hn::CappedTag<float, 16> d;
    const hn::Rebind<std::int32_t, decltype(d)> di;
    const Rows& row = rows();
    alignas(64) std::int32_t begin[k_rows], end[k_rows];
    const auto places = hn::Set(d, static_cast<float>(k_row_places)), before = hn::Set(d, -1.0f), zero = hn::Zero(d),
               last = hn::Set(d, static_cast<float>(k_row_places - 1));
    for (std::size_t i = 0; i < k_rows; i += hn::Lanes(d)) {
        const auto start = hn::Load(d, row.start.data() + i), shift = hn::Load(d, row.shift.data() + i);
        auto low = zero, high = last;
        for (std::size_t e = 0; e < 4; ++e) {
            const float along = LightPlaces::slant * f.by_s[e][lane] + f.by_t[e][lane];
            const auto at = hn::Add(hn::Set(d, f.at[e][lane]), hn::Mul(start, hn::Set(d, f.by_s[e][lane])));
            if (along == 0) {
                high = hn::IfThenElse(hn::Lt(at, zero), before, high);
                continue;
            }
            const auto zero_at = hn::Sub(hn::Mul(hn::Mul(at, hn::Set(d, -1.0f / along)), places), shift);
            if (along > 0)
                low = hn::Max(low, zero_at);
            else
                high = hn::Min(high, zero_at);
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
    for (std::size_t i = 0; i < k_rows; i += hn::Lanes(du)) {
        const auto from = hn::PromoteTo(ds, hn::LoadU(dh, begin + i)), to = hn::PromoteTo(ds, hn::LoadU(dh, end + i));
        const auto none = hn::Gt(from, to);
        const auto left = hn::IfThenZeroElse(none, from), right = hn::IfThenZeroElse(none, hn::Sub(top, to));
        const auto run = hn::And(hn::Shl(ones, hn::BitCast(du, left)), hn::Shr(ones, hn::BitCast(du, right)));
        const auto kept = hn::IfThenZeroElse(hn::RebindMask(du, none), run);
        hn::StoreU(hn::Or(hn::LoadU(du, blocked.data() + i), kept), du, blocked.data() + i);
    }
}

void add_blocked_of(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places,
                    PlaceMask& blocked)
{
    Functions f;
    for (std::size_t first = 0; first < triangles.count; first += Functions::k_lanes) {
        find_functions(point, triangles, first, places, f);
        const std::size_t count = std::min(Functions::k_lanes, triangles.count - first);
        for (std::size_t lane = 0; lane < count; ++lane)
            if (f.meets[lane] != 0) add_runs(f, lane, blocked);
    }
}

}   // namespace gnomon::area_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::area_light {

HWY_EXPORT(add_blocked_of);

void add_blocked(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places, PlaceMask& blocked)
{
    HWY_DYNAMIC_DISPATCH(add_blocked_of)(point, triangles, places, blocked);
}

void TriangleList::clear()
{
    for (auto& corner : at)
        for (auto& axis : corner) axis.clear();
    count = 0;
}

void TriangleList::push(const glm::vec3 (&corner)[3])
{
    for (std::size_t c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis) at[c][static_cast<std::size_t>(axis)].push_back(corner[c][axis]);
    ++count;
}

void TriangleList::pad()
{
    if (count == 0) return;
    const std::size_t padded = (count + k_pad - 1) / k_pad * k_pad;
    for (auto& corner : at)
        for (auto& axis : corner) axis.resize(padded, axis[count - 1]);
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
    float low = 0, high = k_row_places - 1;
    for (int e = 0; e < 4; ++e) {
        const float end = ray::k_shadow_ray_end;
        float at = e < 3 ? scalar(side[e], to) : end * scalar(normal, to) - scalar(normal, r[0]);
        float by_s = e < 3 ? scalar(side[e], places.side_s()) : end * scalar(normal, places.side_s());
        float by_t = e < 3 ? scalar(side[e], places.side_t()) : end * scalar(normal, places.side_t());
        if (volume < 0) at = -at, by_s = -by_s, by_t = -by_t;
        if (!(at + std::max(by_s, 0.0f) + std::max(by_t, 0.0f) >= 0)) return false;
        const float along = LightPlaces::slant * by_s + by_t;
        at += start * by_s;
        if (along == 0) {
            if (at < 0) return false;
            continue;
        }
        const float zero_at = at * (-1.0f / along) * static_cast<float>(k_row_places) - shift;
        if (along > 0)
            low = std::max(low, zero_at);
        else
            high = std::min(high, zero_at);
    }
    return static_cast<float>(place) >= std::ceil(low) && static_cast<float>(place) <= std::floor(high);
}

}   // namespace gnomon::area_light
#endif
