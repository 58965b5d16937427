// SPDX-License-Identifier: Apache-2.0
// Highway includes this file repeatedly and compiles it once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shadow_culling/certified/look_up.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "shadow_culling/certified/look_up.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::shadow_culling::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

Box3 bounds_of_points(std::span<const ShadowPoint> points)
{
    // Load four floats from the origin on; the fourth is not part of it and is ignored.
    static_assert(offsetof(ShadowPoint, origin) + 4 * sizeof(float) <= sizeof(ShadowPoint));
    const hn::FixedTag<float, 4> four;
    auto low = hn::Set(four, k_infinity), high = hn::Set(four, -k_infinity);
    for (const ShadowPoint& point : points) {
        const auto p = hn::LoadU(four, &point.origin.x);
        low = hn::Min(low, p), high = hn::Max(high, p);
    }
    float at_least[4], at_most[4];
    hn::StoreU(low, four, at_least);
    hn::StoreU(high, four, at_most);
    return {glm::vec3(at_least[0], at_least[1], at_least[2]), glm::vec3(at_most[0], at_most[1], at_most[2])};
}

using Reals = hn::ScalableTag<float>;
using Real = hn::Vec<Reals>;
using Addresses = hn::RebindToUnsigned<Reals>;

// The index of the part, among the n * n of a triangle, that contains (x, y). Coordinates are in widths of a part; on
// return they are relative to the part.
HWY_INLINE hn::Vec<Addresses> part_of(Real& x, Real& y, Real count)
{
    const Reals real;
    const hn::RebindToSigned<Reals> integer;
    const auto one = hn::Set(real, 1.0f);
    const auto n = hn::ConvertTo(integer, count), last = hn::Sub(n, hn::Set(integer, 1));
    // Find the cell and its half.
    auto i = hn::ConvertTo(integer, x), j = hn::ConvertTo(integer, y);
    const auto upper = hn::RebindMask(
        integer, hn::Gt(hn::Add(hn::Sub(x, hn::ConvertTo(real, i)), hn::Sub(y, hn::ConvertTo(real, j))), one));
    // Rounding may move a point on the long edge into a cell beyond it.
    const auto reached = hn::Add(hn::Add(i, j), hn::IfThenElseZero(upper, hn::Set(integer, 1)));
    const auto mirrored = hn::And(upper, hn::Lt(reached, n));
    i = hn::Min(i, last);
    j = hn::Min(j, hn::Sub(last, i));
    x = hn::Sub(x, hn::ConvertTo(real, i));
    y = hn::Sub(y, hn::ConvertTo(real, j));
    const auto turned = hn::RebindMask(real, mirrored);
    x = hn::IfThenElse(turned, hn::Sub(one, x), x);
    y = hn::IfThenElse(turned, hn::Sub(one, y), y);
    const auto row = hn::IfThenElse(mirrored, hn::Sub(last, j), j);
    const auto column = hn::IfThenElse(mirrored, hn::Sub(last, i), i);
    return hn::BitCast(Addresses(), hn::Add(hn::Mul(row, n), column));
}

void find_parts_of(LookUp& points, const std::uint8_t* tables)
{
    const Reals real;
    const hn::RebindToSigned<Reals> integer;
    const Addresses address;
    const auto zero = hn::Zero(real), one = hn::Set(real, 1.0f);
    const auto none = hn::Set(address, k_no_slot);
    const auto has_piece = hn::Set(address, k_has_piece);
    const auto in_piece = hn::Set(real, static_cast<float>(1u << k_piece_levels));
    for (std::size_t r = 0; r < points.runs.size(); ++r) {
        const LookUp::Run& run = points.runs[r];
        const std::size_t end = r + 1 < points.runs.size() ? points.runs[r + 1].first : points.count;
        // The last step of a run overlaps the next run, which is written later.
        if (run.begin == k_no_slot) {
            for (std::size_t k = run.first; k < end; k += hn::Lanes(real)) hn::StoreU(none, address, &points.slot[k]);
            continue;
        }
        const auto begin = hn::Set(address, run.begin);
        const auto rim_u = hn::Set(real, run.rim_u), rim_v = hn::Set(real, run.rim_v);
        const auto scale = hn::Set(real, run.per_inner), count = hn::Set(real, run.divisions);
        for (std::size_t k = run.first; k < end; k += hn::Lanes(real)) {
            // Compute the coordinates in the inner triangle.
            Real u, v;
            hn::LoadInterleaved2(real, &points.uv[k].x, u, v);
            auto x = hn::Mul(hn::Sub(u, rim_u), scale), y = hn::Mul(hn::Sub(v, rim_v), scale);
            const auto inside = hn::And(hn::Le(hn::Add(x, y), one), hn::And(hn::Ge(x, zero), hn::Ge(y, zero)));
            x = hn::Mul(hn::IfThenElseZero(inside, x), count);
            y = hn::Mul(hn::IfThenElseZero(inside, y), count);
            auto slot = part_of(x, y, count);
            if (!run.pieces) {
                slot = hn::Add(begin, slot);
            } else {
                // The entry is a piece, or a part without one; mostly the same for all points.
                const std::uint32_t first = hn::GetLane(slot);
                const auto others = hn::And(hn::Ne(slot, hn::Set(address, first)), hn::FirstN(address, end - k));
                if (hn::AllFalse(address, others)) {
                    std::uint32_t below;
                    std::memcpy(&below, tables + run.begin + sizeof below * first, sizeof below);
                    slot = hn::Set(address, below & ~k_has_piece);
                    if (below & k_has_piece) {
                        x = hn::Mul(x, in_piece);
                        y = hn::Mul(y, in_piece);
                        slot = hn::Add(slot, part_of(x, y, in_piece));
                    }
                } else {
                    const auto entry = hn::BitCast(integer, hn::Add(begin, hn::ShiftLeft<2>(slot)));
                    const auto below = hn::BitCast(
                        address, hn::GatherOffset(integer, reinterpret_cast<const std::int32_t*>(tables), entry));
                    slot = hn::AndNot(has_piece, below);
                    const auto parts = hn::IfThenElse(hn::RebindMask(real, hn::Ne(slot, below)), in_piece, one);
                    x = hn::Mul(x, parts);
                    y = hn::Mul(y, parts);
                    slot = hn::Add(slot, part_of(x, y, parts));
                }
            }
            hn::StoreU(hn::IfThenElse(hn::RebindMask(address, inside), slot, none), address, &points.slot[k]);
        }
    }
    for (std::size_t k = points.count; k < points.slot.size(); ++k) points.slot[k] = k_no_slot;
}

void fetch_states_of(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out)
{
    const hn::ScalableTag<std::int32_t> word;
    const hn::RebindToUnsigned<decltype(word)> address;
    const hn::Rebind<std::uint8_t, decltype(word)> byte;
    const auto none = hn::Set(address, k_no_slot);
    const auto keep = hn::Set(word, mask);
    for (std::size_t r = 0; r < points.runs.size(); ++r) {
        const std::size_t first = points.runs[r].first;
        const std::size_t end = r + 1 < points.runs.size() ? points.runs[r + 1].first : points.count;
        if (points.runs[r].begin == k_no_slot) {
            std::fill(out + first, out + end, std::uint8_t{0});
            continue;
        }
        for (std::size_t k = first; k < end; k += hn::Lanes(word)) {
            const auto slot = hn::LoadU(address, &points.slot[k]);
            const auto known = hn::RebindMask(word, hn::Ne(slot, none));
            const auto at = hn::IfThenElseZero(known, hn::BitCast(word, slot));
            // Load four bytes from the part's on; the first one is its state.
            const auto four = hn::GatherOffset(word, reinterpret_cast<const std::int32_t*>(states), at);
            hn::StoreU(hn::DemoteTo(byte, hn::IfThenElseZero(known, hn::And(four, keep))), byte, out + k);
        }
    }
    std::fill(out + points.count, out + points.slot.size(), std::uint8_t{0});
}

}   // namespace gnomon::shadow_culling::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::shadow_culling {

HWY_EXPORT(bounds_of_points);
HWY_EXPORT(find_parts_of);
HWY_EXPORT(fetch_states_of);

void LookUp::resize(std::size_t points)
{
    // A run may begin anywhere, so its last step may end up to a step later.
    const std::size_t padded = (points / k_look_up_step + 2) * k_look_up_step;
    count = points;
    uv.resize(padded), slot.resize(padded);
    runs.clear();
}

Box3 bounds_of(std::span<const ShadowPoint> points)
{
    return HWY_DYNAMIC_DISPATCH(bounds_of_points)(points);
}

void find_parts(LookUp& points, const std::uint8_t* tables)
{
    HWY_DYNAMIC_DISPATCH(find_parts_of)(points, tables);
}

void fetch_states(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out)
{
    HWY_DYNAMIC_DISPATCH(fetch_states_of)(points, states, mask, out);
}

}   // namespace gnomon::shadow_culling
#endif
