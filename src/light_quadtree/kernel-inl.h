// SPDX-License-Identifier: Apache-2.0
// The irradiance by one light at a vector of receivers, for the sum over clusters and for the sampling to which it is
// compared. Included once per instruction set, after highway.h.
// clang-format off
#if defined(GNOMON_LIGHT_QUADTREE_KERNEL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_LIGHT_QUADTREE_KERNEL_INL
#undef GNOMON_LIGHT_QUADTREE_KERNEL_INL
#else
#define GNOMON_LIGHT_QUADTREE_KERNEL_INL
#endif
// clang-format on

#include "light_quadtree/gather.h"

#ifndef GNOMON_LIGHT_QUADTREE_LEAST_SQUARE
#define GNOMON_LIGHT_QUADTREE_LEAST_SQUARE
namespace gnomon::light_quadtree {
inline constexpr float k_least_square = 1e-30f;   // avoids division by zero where receiver and light coincide
}
#endif

HWY_BEFORE_NAMESPACE();
namespace gnomon::light_quadtree::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Real = hn::CappedTag<float, k_receiver_step / 2>;
using Lane = hn::Vec<Real>;

struct Light {
    Lane x, y, z, nx, ny, nz, disk, r, g, b;
};
struct Receiver {
    Lane x, y, z, nx, ny, nz;
};
struct Sum {
    Lane r, g, b;
};

HWY_INLINE Sum nothing()
{
    const Real real;
    return {hn::Zero(real), hn::Zero(real), hn::Zero(real)};
}

HWY_INLINE Lane dot(Lane ax, Lane ay, Lane az, Lane bx, Lane by, Lane bz)
{
    return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

HWY_INLINE Receiver load_receiver(const Receivers& from, std::size_t k)
{
    const Real real;
    return {hn::LoadU(real, &from.x[k]),  hn::LoadU(real, &from.y[k]),  hn::LoadU(real, &from.z[k]),
            hn::LoadU(real, &from.nx[k]), hn::LoadU(real, &from.ny[k]), hn::LoadU(real, &from.nz[k])};
}

HWY_INLINE void store(const Sum& sum, Receivers& to, std::size_t k)
{
    const Real real;
    hn::StoreU(sum.r, real, &to.r[k]);
    hn::StoreU(sum.g, real, &to.g[k]);
    hn::StoreU(sum.b, real, &to.b[k]);
}

// No fused operations, so that all instruction sets give the same bits.
HWY_INLINE void add(const Light& light, const Receiver& at, Sum& sum)
{
    const Real real;
    const auto zero = hn::Zero(real);
    const auto x = hn::Sub(light.x, at.x), y = hn::Sub(light.y, at.y), z = hn::Sub(light.z, at.z);
    const auto square = dot(x, y, z, x, y, z);
    const auto there = hn::Neg(dot(x, y, z, light.nx, light.ny, light.nz));
    const auto here = dot(x, y, z, at.nx, at.ny, at.nz);
    const auto below = hn::Add(hn::Mul(square, hn::Add(square, light.disk)), hn::Set(real, k_least_square));
    const auto weight = hn::Div(hn::Mul(hn::Max(there, zero), hn::Max(here, zero)), below);
    sum.r = hn::Add(sum.r, hn::Mul(weight, light.r));
    sum.g = hn::Add(sum.g, hn::Mul(weight, light.g));
    sum.b = hn::Add(sum.b, hn::Mul(weight, light.b));
}

}   // namespace gnomon::light_quadtree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
