// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shadow_culling/look_up.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "shadow_culling/look_up.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::shadow_culling::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void find_parts_of(LookUp& points)
{
    const hn::ScalableTag<float> real;
    const hn::RebindToSigned<decltype(real)> integer;
    const hn::RebindToUnsigned<decltype(real)> address;
    const auto zero = hn::Zero(real), one = hn::Set(real, 1.0f);
    const auto none = hn::Set(address, k_no_slot);
    for (std::size_t k = 0; k < points.slot.size(); k += hn::Lanes(real)) {
        // Place in the inner triangle.
        const auto scale = hn::LoadU(real, &points.per_inner[k]);
        auto x = hn::Mul(hn::Sub(hn::LoadU(real, &points.u[k]), hn::LoadU(real, &points.rim_u[k])), scale);
        auto y = hn::Mul(hn::Sub(hn::LoadU(real, &points.v[k]), hn::LoadU(real, &points.rim_v[k])), scale);
        const auto begin = hn::LoadU(address, &points.slot[k]);
        const auto remembered = hn::RebindMask(real, hn::Ne(begin, none));
        const auto inside =
            hn::And(hn::And(remembered, hn::Le(hn::Add(x, y), one)), hn::And(hn::Ge(x, zero), hn::Ge(y, zero)));
        // Cell, and which half of it.
        const auto count = hn::LoadU(real, &points.divisions[k]);
        x = hn::Mul(hn::IfThenElseZero(inside, x), count);
        y = hn::Mul(hn::IfThenElseZero(inside, y), count);
        const auto n = hn::ConvertTo(integer, count), last = hn::Sub(n, hn::Set(integer, 1));
        auto i = hn::ConvertTo(integer, x), j = hn::ConvertTo(integer, y);
        const auto upper = hn::RebindMask(
            integer, hn::Gt(hn::Add(hn::Sub(x, hn::ConvertTo(real, i)), hn::Sub(y, hn::ConvertTo(real, j))), one));
        // Rounding may put a point on the long edge into a cell beyond it.
        const auto reached = hn::Add(hn::Add(i, j), hn::IfThenElseZero(upper, hn::Set(integer, 1)));
        const auto mirrored = hn::And(upper, hn::Lt(reached, n));
        i = hn::Min(i, last);
        j = hn::Min(j, hn::Sub(last, i));
        const auto row = hn::IfThenElse(mirrored, hn::Sub(last, j), j);
        const auto column = hn::IfThenElse(mirrored, hn::Sub(last, i), i);
        const auto index = hn::BitCast(address, hn::Add(hn::Mul(row, n), column));
        hn::StoreU(hn::IfThenElse(hn::RebindMask(address, inside), hn::Add(begin, index), none), address,
                   &points.slot[k]);
    }
}

void fetch_states_of(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out)
{
    const hn::ScalableTag<std::int32_t> word;
    const hn::RebindToUnsigned<decltype(word)> address;
    const hn::Rebind<std::uint8_t, decltype(word)> byte;
    const auto none = hn::Set(address, k_no_slot);
    const auto keep = hn::Set(word, mask);
    for (std::size_t k = 0; k < points.slot.size(); k += hn::Lanes(word)) {
        const auto slot = hn::LoadU(address, &points.slot[k]);
        const auto known = hn::RebindMask(word, hn::Ne(slot, none));
        const auto at = hn::IfThenElseZero(known, hn::BitCast(word, slot));
        // Four bytes from the part's on; the first is its own.
        const auto four = hn::GatherOffset(word, reinterpret_cast<const std::int32_t*>(states), at);
        hn::StoreU(hn::DemoteTo(byte, hn::IfThenElseZero(known, hn::And(four, keep))), byte, out + k);
    }
}

}   // namespace gnomon::shadow_culling::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::shadow_culling {

HWY_EXPORT(find_parts_of);
HWY_EXPORT(fetch_states_of);

void LookUp::resize(std::size_t points)
{
    const std::size_t padded = (points + k_look_up_step - 1) / k_look_up_step * k_look_up_step;
    for (std::vector<float>* lane : {&u, &v, &rim_u, &rim_v, &per_inner, &divisions}) lane->resize(padded, 1.0f);
    slot.resize(padded);
    for (std::size_t k = points; k < padded; ++k) slot[k] = k_no_slot;
}

void find_parts(LookUp& points)
{
    HWY_DYNAMIC_DISPATCH(find_parts_of)(points);
}

void fetch_states(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out)
{
    HWY_DYNAMIC_DISPATCH(fetch_states_of)(points, states, mask, out);
}

}   // namespace gnomon::shadow_culling
#endif
