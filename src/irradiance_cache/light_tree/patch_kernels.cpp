// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "irradiance_cache/light_tree/patch_kernels.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <bit>

#include "irradiance_cache/light_tree/patch_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::irradiance_cache::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

std::size_t receive_untested_of(PatchRows& rows, const DynamicVirtualLight& light, float untested,
                                std::uint16_t* tested)
{
    const hn::CappedTag<float, 16> d;
    using V = hn::Vec<decltype(d)>;
    const auto dot = [](const V(&a)[3], const V(&b)[3]) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
    };
    const V zero = hn::Zero(d), pi = hn::Set(d, static_cast<float>(k_pi)), area = hn::Set(d, light.area),
            near_square = hn::Set(d, light.near_square()), reach = hn::Set(d, light.reach()),
            quarter = hn::Set(d, 0.25f), fraction = hn::Set(d, untested);
    const V light_normal[3] = {hn::Set(d, light.normal.x), hn::Set(d, light.normal.y), hn::Set(d, light.normal.z)};
    const V weights[3] = {hn::Set(d, 0.2126f), hn::Set(d, 0.7152f), hn::Set(d, 0.0722f)};   // luminance()
    std::size_t found = 0;
    for (std::size_t k = 0; k < rows.count; k += hn::Lanes(d)) {
        // The kernel of a disk, as for points.
        V to[3], normal[3];
        for (int i = 0; i < 3; ++i) {
            to[i] = hn::Sub(hn::Set(d, light.sample[i]), hn::Load(d, rows.sample[i] + k));
            normal[i] = hn::Load(d, rows.normal[i] + k);
        }
        const V square = dot(to, to), cosine = dot(to, normal), mean = hn::Neg(dot(to, light_normal));
        const V most = hn::Mul(reach, hn::Sqrt(square)), within = hn::Max(hn::Add(hn::Min(mean, most), most), zero);
        const V facing =
            hn::Add(hn::Div(hn::Mul(quarter, hn::Mul(within, within)), most), hn::Max(hn::Sub(mean, most), zero));
        const auto faces = hn::And(hn::Gt(cosine, zero), hn::Gt(facing, zero));
        const V kernel = hn::IfThenElseZero(
            faces, hn::Div(hn::Mul(facing, cosine), hn::Mul(square, hn::Add(hn::Mul(pi, square), area))));
        V irradiance[3];
        for (int i = 0; i < 3; ++i) irradiance[i] = hn::Mul(kernel, hn::Set(d, light.flux[i]));

        const auto near = hn::Lt(square, near_square);
        const auto faint = hn::Lt(hn::Mul(hn::Load(d, rows.albedo + k), dot(weights, irradiance)),
                                  hn::Mul(fraction, hn::Load(d, rows.already + k)));
        const auto added = hn::And(hn::And(faces, faint), hn::Not(near));
        for (int i = 0; i < 3; ++i) {
            float* const at = rows.received[i] + k;
            hn::Store(hn::Add(hn::Load(d, at), hn::IfThenElseZero(added, irradiance[i])), d, at);
        }
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, hn::Or(near, hn::AndNot(faint, faces)), bytes);
        unsigned bits = (bytes[0] | static_cast<unsigned>(bytes[1]) << 8) & ((1u << hn::Lanes(d)) - 1);
        for (; bits != 0; bits &= bits - 1) {
            const std::size_t p = k + static_cast<std::size_t>(std::countr_zero(bits));
            if (p < rows.count) tested[found++] = static_cast<std::uint16_t>(p);
        }
    }
    return found;
}

}   // namespace gnomon::irradiance_cache::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::irradiance_cache {

HWY_EXPORT(receive_untested_of);

std::size_t receive_untested(PatchRows& rows, const DynamicVirtualLight& light, float untested, std::uint16_t* tested)
{
    return HWY_DYNAMIC_DISPATCH(receive_untested_of)(rows, light, untested, tested);
}

}   // namespace gnomon::irradiance_cache
#endif
