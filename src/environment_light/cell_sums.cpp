// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "environment_light/cell_sums.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "environment_light/cell_sums.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::environment_light::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

CosineSums cosine_sums_of(const glm::vec3& normal, const UnitLists& cells, std::span<const std::uint64_t> mask,
                          std::span<const std::uint64_t> exists, std::uint64_t flip)
{
    const hn::CappedTag<float, 16> d;
    const hn::RebindToSigned<decltype(d)> whole;
    using V = hn::Vec<decltype(d)>;
    const std::size_t lanes = hn::Lanes(d);
    const V zero = hn::Zero(d), nx = hn::Set(d, normal.x), ny = hn::Set(d, normal.y), nz = hn::Set(d, normal.z);
    auto red = hn::Zero(whole), green = red, blue = red, angle = red;
    for (std::size_t w = 0; w < mask.size(); ++w) {
        const std::uint64_t word = (mask[w] ^ flip) & exists[w];
        if (word == 0) continue;
        for (std::size_t in = 0; in < 64; in += lanes) {
            const std::uint64_t bits = word >> in & ((1u << lanes) - 1);
            if (bits == 0) continue;
            const std::size_t first = 64 * w + in;
            const V x = hn::LoadU(d, cells.mean[0] + first), y = hn::LoadU(d, cells.mean[1] + first),
                    z = hn::LoadU(d, cells.mean[2] + first);
            const V cosine = hn::Add(hn::Add(hn::Mul(nx, x), hn::Mul(ny, y)), hn::Mul(nz, z));
            alignas(8) std::uint8_t bytes[8];
            for (std::size_t i = 0; i < sizeof bytes; ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
            const V lit = hn::IfThenElseZero(hn::And(hn::Gt(cosine, zero), hn::LoadMaskBits(d, bytes)), cosine);
            const auto term = [&](const float* list)
                                  HWY_ATTR { return hn::ConvertTo(whole, hn::Mul(hn::LoadU(d, list + first), lit)); };
            red = hn::Add(red, term(cells.flux[0])), green = hn::Add(green, term(cells.flux[1]));
            blue = hn::Add(blue, term(cells.flux[2])), angle = hn::Add(angle, term(cells.angle));
        }
    }
    const auto sum = [&](auto lanes_of) HWY_ATTR { return std::int64_t{hn::GetLane(hn::SumOfLanes(whole, lanes_of))}; };
    return {{sum(red), sum(green), sum(blue)}, sum(angle)};
}

// The weight of a cell is what the lobe reflects of it: lobe_weight().
LobeSums lobe_sums_of(const WeightedLobe& lobe, const CellLists& cells, std::span<const std::uint64_t> seen)
{
    const hn::CappedTag<float, k_sum_lanes> d;
    using V = hn::Vec<decltype(d)>;
    const std::size_t lanes = hn::Lanes(d);
    const auto dot = [&](const glm::vec3& a, const V& x, const V& y, const V& z) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(d, a.x), x), hn::Mul(hn::Set(d, a.y), y)), hn::Mul(hn::Set(d, a.z), z));
    };
    const V zero = hn::Zero(d), one = hn::Set(d, 1), two = hn::Set(d, 2), least = hn::Set(d, 1e-6f);
    const V a2 = hn::Set(d, lobe.a2), less = hn::Set(d, lobe.a2 - 1), more = hn::Set(d, 1 - lobe.a2);
    const V n_v = hn::Set(d, lobe.n_v), masking = hn::Set(d, lobe.masking), half = hn::Set(d, 0.5f);
    const V f0 = hn::Set(d, lobe.f0), rise = hn::Set(d, lobe.f90 - lobe.f0);
    LobeSums sums;
    for (std::size_t offset = 0; offset < k_sum_lanes; offset += lanes) {
        V all[3] = {zero, zero, zero}, visible[3] = {zero, zero, zero}, angles = zero, visible_angles = zero;
        for (std::size_t first = offset; first < 64 * seen.size(); first += k_sum_lanes) {
            const V x = hn::LoadU(d, cells.mean[0] + first), y = hn::LoadU(d, cells.mean[1] + first),
                    z = hn::LoadU(d, cells.mean[2] + first);
            const V n_l = dot(lobe.normal, x, y, z), g_l = dot(lobe.horizon, x, y, z);
            const auto counts = hn::And(hn::Gt(n_l, zero), hn::Gt(g_l, zero));
            if (hn::AllFalse(d, counts)) continue;
            const V l_v = dot(lobe.to_viewer, x, y, z);
            // The squared cosine between the normal and the half vector.
            const V both = hn::Add(n_l, n_v);
            const V half2 = hn::Div(hn::Mul(both, both), hn::Max(hn::Add(two, hn::Mul(two, l_v)), least));
            const V t = hn::Add(hn::Mul(half2, less), one);
            const V shadowing = hn::Sqrt(hn::Add(a2, hn::Mul(hn::Mul(more, n_l), n_l)));
            const V below = hn::Mul(hn::Mul(t, t), hn::Add(hn::Mul(n_l, masking), hn::Mul(n_v, shadowing)));
            const V v_h = hn::Sqrt(hn::Max(hn::Mul(half, hn::Add(one, l_v)), zero)), away = hn::Sub(one, v_h);
            const V square = hn::Mul(away, away), fifth = hn::Mul(hn::Mul(square, square), away);
            const V fresnel = hn::Add(f0, hn::Mul(rise, fifth));
            const V weight = hn::IfThenElseZero(counts, hn::Mul(fresnel, hn::Div(n_l, below)));
            const std::uint64_t bits = seen[first / 64] >> (first % 64) & ((1u << lanes) - 1);
            alignas(8) std::uint8_t bytes[8];
            for (std::size_t i = 0; i < sizeof bytes; ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
            const V kept = hn::IfThenElseZero(hn::LoadMaskBits(d, bytes), weight);
            const V angle = hn::LoadU(d, cells.angle + first);
            angles = hn::Add(angles, hn::Mul(weight, angle));
            visible_angles = hn::Add(visible_angles, hn::Mul(kept, angle));
            for (std::size_t c = 0; c < 3; ++c) {
                const V flux = hn::LoadU(d, cells.flux[c] + first);
                all[c] = hn::Add(all[c], hn::Mul(weight, flux));
                visible[c] = hn::Add(visible[c], hn::Mul(kept, flux));
            }
        }
        hn::StoreU(angles, d, sums.angles.data() + offset);
        hn::StoreU(visible_angles, d, sums.visible_angles.data() + offset);
        for (std::size_t c = 0; c < 3; ++c) {
            hn::StoreU(all[c], d, sums.all[c].data() + offset);
            hn::StoreU(visible[c], d, sums.visible[c].data() + offset);
        }
    }
    return sums;
}

}   // namespace gnomon::environment_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::environment_light {

HWY_EXPORT(cosine_sums_of);
HWY_EXPORT(lobe_sums_of);

CosineSums cosine_sums(const glm::vec3& normal, const UnitLists& cells, std::span<const std::uint64_t> mask,
                       std::span<const std::uint64_t> exists, std::uint64_t flip)
{
    return HWY_DYNAMIC_DISPATCH(cosine_sums_of)(normal, cells, mask, exists, flip);
}

float lobe_weight(const WeightedLobe& lobe, const glm::vec3& direction)
{
    const float n_l = glm::dot(lobe.normal, direction), g_l = glm::dot(lobe.horizon, direction);
    if (!(n_l > 0 && g_l > 0)) return 0;
    const float both = n_l + lobe.n_v;
    const float l_v = glm::dot(lobe.to_viewer, direction);
    const float half2 = both * both / std::max(2 + 2 * l_v, 1e-6f);
    const float t = half2 * (lobe.a2 - 1) + 1;
    const float shadowing = std::sqrt(lobe.a2 + (1 - lobe.a2) * n_l * n_l);
    const float away = 1 - std::sqrt(std::max(0.5f * (1 + l_v), 0.0f)), square = away * away;
    const float fresnel = lobe.f0 + (lobe.f90 - lobe.f0) * (square * square * away);
    return fresnel * (n_l / (t * t * (n_l * lobe.masking + lobe.n_v * shadowing)));
}

LobeSums lobe_sums(const WeightedLobe& lobe, const CellLists& cells, std::span<const std::uint64_t> seen)
{
    return HWY_DYNAMIC_DISPATCH(lobe_sums_of)(lobe, cells, seen);
}

}   // namespace gnomon::environment_light
#endif
