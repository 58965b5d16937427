// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "trace/lobe_sums.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "trace/lobe_sums.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::trace::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using W = LobeImage::Window;
using Floats = hn::CappedTag<float, W::k_most_lanes>;
using V = hn::Vec<Floats>;

struct Vector3 {
    V x, y, z;
};

HWY_INLINE V load(const float* from)
{
    return hn::LoadU(Floats(), from);
}

// Three rows that follow each other.
HWY_INLINE Vector3 load3(const float* from, int stride)
{
    return {load(from), load(from + stride), load(from + 2 * stride)};
}

HWY_INLINE V dot(const Vector3& a, const Vector3& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE Vector3 minus(const Vector3& a, const Vector3& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

// a + s b
HWY_INLINE Vector3 plus(const Vector3& a, V s, const Vector3& b)
{
    return {hn::Add(a.x, hn::Mul(s, b.x)), hn::Add(a.y, hn::Mul(s, b.y)), hn::Add(a.z, hn::Mul(s, b.z))};
}

HWY_INLINE void add_to(float* sum, V value)
{
    hn::StoreU(hn::Add(load(sum), value), Floats(), sum);
}

struct Lobe {
    Vector3 normal, to_viewer;
    V a2, scale;
};

HWY_INLINE Lobe lobe_at(const W& window, int x, int y)
{
    const V width = load(window.row(W::width, y) + x);
    return {load3(window.row(W::nx, y) + x, window.stride), load3(window.row(W::vx, y) + x, window.stride),
            hn::Mul(width, width), load(window.row(W::scale, y) + x)};
}

// How densely lobes cast rays to where rays of other pixels end, as density_of().
// @param from  where the rays start, seen from where the lobes do
// @param ray   the rows of their directions, and those that follow (Window::OfRay)
HWY_INLINE V density(const Lobe& lobe, const Vector3& from, const float* ray, int stride)
{
    const Floats d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d);
    const Vector3 to = plus(load3(ray, stride), load(ray + W::near * stride), from);
    const V slant = hn::Add(one, dot(load3(ray + W::fx * stride, stride), from));
    const V length = hn::Sqrt(dot(to, to));
    const Vector3 h = plus(to, length, lobe.to_viewer), &n = lobe.normal;
    const V above = dot(n, to), along = dot(n, h), along2 = hn::Mul(along, along);
    const Vector3 cross{hn::Sub(hn::Mul(n.y, h.z), hn::Mul(n.z, h.y)), hn::Sub(hn::Mul(n.z, h.x), hn::Mul(n.x, h.z)),
                        hn::Sub(hn::Mul(n.x, h.y), hn::Mul(n.y, h.x))};
    const V across = dot(cross, cross), below = hn::Add(hn::Mul(lobe.a2, along2), across);
    const V inverse = hn::Div(one, hn::Mul(below, length));
    const V peak = hn::Mul(hn::Mul(hn::Add(along2, across), length), inverse), nearer = hn::Mul(below, inverse);
    const V all = hn::Mul(hn::Mul(hn::Mul(peak, peak), slant), hn::Mul(hn::Mul(nearer, nearer), nearer));
    const auto reached = hn::And(hn::And(hn::Gt(above, zero), hn::Gt(along, zero)), hn::Gt(slant, zero));
    return hn::IfThenElseZero(reached, hn::Mul(lobe.scale, all));
}

// Calls use(x, y, apart, different, share) for the neighbours of a vector of pixels, some of which count: where they
// are in the window, where they start as seen from the pixels, difference(), and how far they count, as Likeness.
// @param x0, y0  of the first pixel, in the window
template <class Use>
HWY_INLINE void for_each_neighbour(const W& window, const LobeSharing& sharing, int x0, int y0, const Use& use)
{
    const Floats d;
    const int stride = window.stride;
    const V zero = hn::Zero(d), one = hn::Set(d, 1), two = hn::Set(d, 2), three = hn::Set(d, 3);
    const V near = hn::Set(d, sharing.near), unlike = hn::Set(d, sharing.likeness.unlike),
            slope = hn::Set(d, sharing.likeness.slope);
    const Vector3 position = load3(window.row(W::px, y0) + x0, stride),
                  axis = load3(window.row(W::ax, y0) + x0, stride);
    const V own_width = load(window.row(W::width, y0) + x0), own_footprint = load(window.row(W::footprint, y0) + x0);
    for (int dy = -k_half; dy <= k_half; ++dy)
        for (int dx = -k_half; dx <= k_half; ++dx) {
            const int x = x0 + dx, y = y0 + dy;
            const Vector3 apart = minus(load3(window.row(W::px, y) + x, stride), position);
            const Vector3 turn = minus(load3(window.row(W::ax, y) + x, stride), axis);
            const V footprint = hn::Max(own_footprint, load(window.row(W::footprint, y) + x));
            const V other_width = load(window.row(W::width, y) + x);
            const V width = hn::Min(own_width, other_width), wider = hn::Sub(hn::Max(own_width, other_width), width);
            const auto close =
                hn::And(hn::Lt(dot(apart, apart), hn::Mul(near, hn::Mul(footprint, footprint))), hn::Gt(width, zero));
            const V different = hn::Div(hn::Add(dot(turn, turn), hn::Mul(wider, wider)), hn::Mul(width, width));
            V t = hn::Mul(hn::Sub(unlike, different), slope);
            const auto some = hn::And(close, hn::Gt(t, zero));
            if (hn::AllFalse(d, some)) continue;
            t = hn::IfThenElse(hn::Lt(t, one), t, one);
            const V alike = hn::Mul(hn::Mul(t, t), hn::Sub(three, hn::Mul(two, t)));
            const V edge = hn::Set(d, part_at(dx) * part_at(dy));
            use(x, y, apart, different, hn::IfThenElseZero(some, hn::Mul(alike, edge)));
        }
}

void find_same_of(W& window, const LobeSharing& sharing, const Likeness& even, int y_of_tile, int first, int end)
{
    const Floats d;
    const int y0 = y_of_tile + k_half, lanes = static_cast<int>(hn::Lanes(d));
    const V zero = hn::Zero(d), one = hn::Set(d, 1), two = hn::Set(d, 2), three = hn::Set(d, 3);
    for (int at = first / lanes * lanes; at < end; at += lanes) {
        const int x0 = at + k_half;
        const V near = load(window.row(W::nearest, y0) + x0), width = load(window.row(W::width, y0) + x0);
        const V parallax = hn::Div(hn::Mul(near, near), hn::Mul(width, width));
        V most = zero, covered = zero, counted = zero;
        for_each_neighbour(window, sharing, x0, y0, [&](int x, int y, const Vector3& apart, V turn, V share) HWY_ATTR {
            const V different = hn::Mul(two, hn::Add(turn, hn::Mul(parallax, dot(apart, apart))));
            most = hn::Max(most, hn::IfThenElseZero(hn::Gt(share, zero), different));
            covered = hn::Add(covered, share);
            counted = hn::Add(counted, hn::Mul(share, load(window.row(W::rays, y) + x)));
        });
        V t = hn::Mul(hn::Sub(hn::Set(d, even.unlike), most), hn::Set(d, even.slope));
        t = hn::IfThenElseZero(hn::Gt(t, zero), hn::IfThenElse(hn::Lt(t, one), t, one));
        hn::StoreU(hn::Mul(hn::Mul(t, t), hn::Sub(three, hn::Mul(two, t))), d, window.same.data() + at);
        hn::StoreU(covered, d, window.covered.data() + at);
        hn::StoreU(counted, d, window.counted.data() + at);
    }
}

void sum_densities_of(W& window, const LobeSharing& sharing, int y_of_tile, int first, int end)
{
    const Floats d;
    const int y0 = y_of_tile + k_half, stride = window.stride, lanes = static_cast<int>(hn::Lanes(d));
    const int listed = window.rays_of_row[static_cast<std::size_t>(y0)];
    window.density.assign(static_cast<std::size_t>(listed * window.padded), 0);
    for (int at = first / lanes * lanes; at < end; at += lanes) {
        const int x0 = at + k_half;
        const V count = load(window.row(W::count, y0) + x0);
        int most = 0;
        while (most < listed && !hn::AllFalse(d, hn::Gt(count, hn::Set(d, static_cast<float>(most))))) ++most;
        for_each_neighbour(window, sharing, x0, y0, [&](int x, int y, const Vector3& apart, V, V share) HWY_ATTR {
            const Lobe lobe = lobe_at(window, x, y);
            const Vector3 from{hn::Neg(apart.x), hn::Neg(apart.y), hn::Neg(apart.z)};
            const V counted = hn::Mul(share, load(window.row(W::rays, y) + x));
            for (int k = 0; k < most; ++k)
                add_to(window.density.data() + k * window.padded + at,
                       hn::Mul(counted, density(lobe, from, window.row(W::dx, k, y0) + x0, stride)));
        });
    }
}

void sum_rays_of(W& window, const LobeSharing& sharing, int y_of_tile, int first, int end)
{
    const Floats d;
    const int y0 = y_of_tile + k_half, stride = window.stride, lanes = static_cast<int>(hn::Lanes(d));
    for (int at = first / lanes * lanes; at < end; at += lanes) {
        const int x0 = at + k_half;
        const Lobe own = lobe_at(window, x0, y0);
        V sums[9];
        for (V& sum : sums) sum = hn::Zero(d);
        for_each_neighbour(window, sharing, x0, y0, [&](int x, int y, const Vector3& apart, V, V share) HWY_ATTR {
            const V counted = hn::Mul(share, load(window.row(W::rays, y) + x));
            // Lobes that are the same for all rays of a pixel need not be asked.
            const V even = hn::Mul(counted, load(window.row(W::even, y) + x));
            if (!hn::AllFalse(d, hn::Gt(even, hn::Zero(d))))
                for (int c = 0; c < 9; ++c)
                    sums[c] = hn::Add(sums[c], hn::Mul(even, load(window.row(W::lr, y) + c * stride + x)));
            const V count = hn::IfThenElseZero(hn::Gt(share, hn::Zero(d)), load(window.row(W::count, y) + x));
            for (int k = 0; k < window.rays_of_row[static_cast<std::size_t>(y)]; ++k) {
                const auto has = hn::Gt(count, hn::Set(d, static_cast<float>(k)));
                if (hn::AllFalse(d, has)) break;
                const float* const ray = window.row(W::dx, k, y) + x;
                const V there = hn::Mul(density(own, apart, ray, stride), load(ray + W::rarity * stride));
                const V counts = hn::IfThenElseZero(has, hn::Mul(counted, there));
                for (int c = 0; c < 6; ++c)
                    sums[c] = hn::Add(sums[c], hn::Mul(counts, load(ray + (W::ray_lr + c) * stride)));
                const auto leaves = hn::Eq(load(ray + W::near * stride), hn::Zero(d));
                if (hn::AllFalse(d, leaves)) continue;
                const V open = hn::IfThenElseZero(leaves, counts);
                for (int c = 0; c < 3; ++c)
                    sums[6 + c] = hn::Add(sums[6 + c], hn::Mul(open, load(ray + (W::ray_wr + c) * stride)));
            }
        });
        for (int c = 0; c < 3; ++c) {
            hn::StoreU(sums[c], d, window.light[c].data() + at);
            hn::StoreU(sums[3 + c], d, window.weight[c].data() + at);
            hn::StoreU(sums[6 + c], d, window.open[c].data() + at);
        }
    }
}

void sum_means_of(W& window, const LobeSharing& sharing, int y_of_tile, int first, int end)
{
    const Floats d;
    const int y0 = y_of_tile + k_half, lanes = static_cast<int>(hn::Lanes(d));
    for (int at = first / lanes * lanes; at < end; at += lanes) {
        V sums[6];
        for (V& sum : sums) sum = hn::Zero(d);
        for_each_neighbour(window, sharing, at + k_half, y0, [&](int x, int y, const Vector3&, V, V share) HWY_ATTR {
            const V counted = hn::Mul(share, load(window.row(W::rays, y) + x));
            for (int c = 0; c < 6; ++c)
                sums[c] = hn::Add(sums[c], hn::Mul(counted, load(window.row(W::lr, y) + c * window.stride + x)));
        });
        for (int c = 0; c < 6; ++c)
            hn::StoreU(sums[c], d, (c < 3 ? window.light[c] : window.weight[c - 3]).data() + at);
    }
}

}   // namespace gnomon::trace::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::trace {

HWY_EXPORT(find_same_of);
HWY_EXPORT(sum_densities_of);
HWY_EXPORT(sum_rays_of);
HWY_EXPORT(sum_means_of);

void find_same(LobeImage::Window& window, const LobeSharing& sharing, const Likeness& even, int y, int first, int end)
{
    HWY_DYNAMIC_DISPATCH(find_same_of)(window, sharing, even, y, first, end);
}

void sum_densities(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end)
{
    HWY_DYNAMIC_DISPATCH(sum_densities_of)(window, sharing, y, first, end);
}

void sum_rays(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end)
{
    HWY_DYNAMIC_DISPATCH(sum_rays_of)(window, sharing, y, first, end);
}

void sum_means(LobeImage::Window& window, const LobeSharing& sharing, int y, int first, int end)
{
    HWY_DYNAMIC_DISPATCH(sum_means_of)(window, sharing, y, first, end);
}

}   // namespace gnomon::trace
#endif
