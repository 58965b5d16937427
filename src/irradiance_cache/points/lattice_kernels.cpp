// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "irradiance_cache/points/lattice_kernels.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "irradiance_cache/points/lattice_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::irradiance_cache::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void interpolate_cell_of(const CellAnchors& cell, const LatticeReach& reach, const LatticePoints& points,
                         std::size_t first, std::size_t count, LatticeLight& out)
{
    const hn::CappedTag<float, LatticePoints::k_pad> d;
    using V = hn::Vec<decltype(d)>;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto per_plane = hn::Set(d, 1 / reach.plane), facing_from = hn::Set(d, reach.facing),
               per_facing = hn::Set(d, 1 / (1 - reach.facing));
    const std::vector<float>* const place[3] = {&points.x, &points.y, &points.z};
    const float* const anchor[3] = {cell.x, cell.y, cell.z};
    const float *anchor_b = anchor[(cell.axis + 1) % 3], *anchor_c = anchor[(cell.axis + 2) % 3];
    const float *at_b = place[(cell.axis + 1) % 3]->data(), *at_c = place[(cell.axis + 2) % 3]->data();
    for (std::size_t k = first; k < first + count; k += hn::Lanes(d)) {
        const auto x = hn::LoadU(d, points.x.data() + k), y = hn::LoadU(d, points.y.data() + k),
                   z = hn::LoadU(d, points.z.data() + k);
        const auto gx = hn::LoadU(d, points.gx.data() + k), gy = hn::LoadU(d, points.gy.data() + k),
                   gz = hn::LoadU(d, points.gz.data() + k);
        const auto nx = hn::LoadU(d, points.nx.data() + k), ny = hn::LoadU(d, points.ny.data() + k),
                   nz = hn::LoadU(d, points.nz.data() + k);
        const auto fx = hn::LoadU(d, points.fx.data() + k), fy = hn::LoadU(d, points.fy.data() + k);
        const auto b = hn::LoadU(d, at_b + k), c = hn::LoadU(d, at_c + k);
        const auto gx1 = hn::Sub(one, fx), fy1 = hn::Sub(one, fy);
        const V between[4] = {hn::Mul(gx1, fy1), hn::Mul(fx, fy1), hn::Mul(gx1, fy), hn::Mul(fx, fy)};
        V w[4];
        for (int i = 0; i < 4; ++i) {
            const auto off = hn::Mul(hn::Add(hn::Add(hn::Mul(hn::Sub(hn::Set(d, cell.x[i]), x), gx),
                                                     hn::Mul(hn::Sub(hn::Set(d, cell.y[i]), y), gy)),
                                             hn::Mul(hn::Sub(hn::Set(d, cell.z[i]), z), gz)),
                                     per_plane);
            const auto near = hn::Sub(one, hn::Abs(off));   // NaN if there is no cache point
            const auto agree =
                hn::Add(hn::Add(hn::Mul(hn::Set(d, cell.nx[i]), nx), hn::Mul(hn::Set(d, cell.ny[i]), ny)),
                        hn::Mul(hn::Set(d, cell.nz[i]), nz));
            const auto facing = hn::Min(hn::Max(hn::Mul(hn::Sub(agree, facing_from), per_facing), zero), one);
            const auto along = hn::Mul(hn::IfThenElseZero(hn::Gt(near, zero), near), facing);
            auto weight = hn::Mul(between[i], along);
            if (reach.open_only) {
                const auto db = hn::Sub(hn::Set(d, anchor_b[i]), b), dc = hn::Sub(hn::Set(d, anchor_c[i]), c);
                // Apply the slope only where the wall comes nearer; behind a wall that recedes there may be others.
                const auto nearer = [&](int way, V along_other)
                                        HWY_ATTR { return hn::Mul(hn::Set(d, cell.slope[way][i]), along_other); };
                const auto low = [&](V at, float from, int way, V along_other) HWY_ATTR {
                    return hn::Ge(at, hn::Add(hn::Set(d, from), hn::Max(nearer(way, along_other), zero)));
                };
                const auto high = [&](V at, float from, int way, V along_other) HWY_ATTR {
                    return hn::Le(at, hn::Add(hn::Set(d, from), hn::Min(nearer(way, along_other), zero)));
                };
                const auto open = hn::And(hn::And(low(b, cell.low_b[i], 0, dc), high(b, cell.high_b[i], 1, dc)),
                                          hn::And(low(c, cell.low_c[i], 2, db), high(c, cell.high_c[i], 3, db)));
                weight = hn::IfThenElseZero(open, weight);
            }
            w[i] = weight;
        }
        const auto sum = [](const V(&v)[4]) HWY_ATTR { return hn::Add(hn::Add(v[0], v[1]), hn::Add(v[2], v[3])); };
        const auto weight = sum(w);
        const auto any = hn::Gt(weight, zero);
        const auto safe = hn::IfThenElse(any, weight, one);
        // Find the mean of the cache points' normals, and by how much the surface points' differ from it.
        V mean_x = zero, mean_y = zero, mean_z = zero, turn_x = zero, turn_y = zero, turn_z = zero;
        if (!cell.one_normal) {
            const auto between_normals = [&](const float(&n)[4]) HWY_ATTR {
                return hn::Add(hn::Add(hn::Mul(w[0], hn::Set(d, n[0])), hn::Mul(w[1], hn::Set(d, n[1]))),
                               hn::Add(hn::Mul(w[2], hn::Set(d, n[2])), hn::Mul(w[3], hn::Set(d, n[3]))));
            };
            const auto sx = between_normals(cell.nx), sy = between_normals(cell.ny), sz = between_normals(cell.nz);
            const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(sx, sx), hn::Mul(sy, sy)), hn::Mul(sz, sz)));
            const auto divisor = hn::IfThenElse(hn::Gt(length, zero), length, one);
            mean_x = hn::Div(sx, divisor), mean_y = hn::Div(sy, divisor), mean_z = hn::Div(sz, divisor);
            turn_x = hn::Sub(nx, mean_x), turn_y = hn::Sub(ny, mean_y), turn_z = hn::Sub(nz, mean_z);
        }
        V red[4], green[4], blue[4], form_factor[4];
        for (int i = 0; i < 4; ++i) {
            V tx = nx, ty = ny, tz = nz;
            if (!cell.one_normal) {   // half-way (halfway_normal())
                const auto ax = hn::Set(d, cell.nx[i]), ay = hn::Set(d, cell.ny[i]), az = hn::Set(d, cell.nz[i]);
                const auto cosine = hn::Add(hn::Add(hn::Mul(ax, mean_x), hn::Mul(ay, mean_y)), hn::Mul(az, mean_z));
                const auto both = hn::Add(one, cosine);
                tx = hn::Div(hn::Add(hn::Add(ax, turn_x), nx), both);
                ty = hn::Div(hn::Add(hn::Add(ay, turn_y), ny), both);
                tz = hn::Div(hn::Add(hn::Add(az, turn_z), nz), both);
            }
            const auto of = [&](const float(*vector)[4]) HWY_ATTR {
                const auto value =
                    hn::Add(hn::Add(hn::Mul(hn::Set(d, vector[0][i]), tx), hn::Mul(hn::Set(d, vector[1][i]), ty)),
                            hn::Mul(hn::Set(d, vector[2][i]), tz));
                return hn::Mul(w[i], hn::Max(value, zero));
            };
            red[i] = of(cell.light), green[i] = of(cell.light + 3), blue[i] = of(cell.light + 6);
            form_factor[i] = of(cell.facing);
        }
        hn::StoreU(weight, d, out.weight.data() + k);
        for (int i = 0; i < 4; ++i) hn::StoreU(w[i], d, out.weight_of[i].data() + k);
        hn::StoreU(hn::IfThenElseZero(any, hn::Div(sum(form_factor), safe)), d, out.form_factor.data() + k);
        hn::StoreU(hn::IfThenElseZero(any, hn::Div(sum(red), safe)), d, out.r.data() + k);
        hn::StoreU(hn::IfThenElseZero(any, hn::Div(sum(green), safe)), d, out.g.data() + k);
        hn::StoreU(hn::IfThenElseZero(any, hn::Div(sum(blue), safe)), d, out.b.data() + k);
    }
}

}   // namespace gnomon::irradiance_cache::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::irradiance_cache {

HWY_EXPORT(interpolate_cell_of);

void LatticePoints::resize(std::size_t count)
{
    for (auto* lane : {&x, &y, &z, &gx, &gy, &gz, &nx, &ny, &nz, &fx, &fy})
        if (lane->size() < count + k_pad) lane->resize(count + k_pad);
}

void LatticeLight::resize(std::size_t count)
{
    for (auto* lane : {&r, &g, &b, &form_factor, &weight, weight_of, weight_of + 1, weight_of + 2, weight_of + 3})
        if (lane->size() < count + LatticePoints::k_pad) lane->resize(count + LatticePoints::k_pad);
}

void interpolate_cell(const CellAnchors& cell, const LatticeReach& reach, const LatticePoints& points,
                      std::size_t first, std::size_t count, LatticeLight& light)
{
    HWY_DYNAMIC_DISPATCH(interpolate_cell_of)(cell, reach, points, first, count, light);
}

}   // namespace gnomon::irradiance_cache
#endif
