// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "area_light/visible_cells.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include "area_light/visible_cells.h"

#ifndef GNOMON_AREA_LIGHT_VISIBLE_CELLS_ONCE
#define GNOMON_AREA_LIGHT_VISIBLE_CELLS_ONCE
namespace gnomon::area_light {
// Sums by lane of a vector of 16, whatever the processor's vectors are, so that the bits are the same.
inline constexpr std::size_t k_lanes = 16;
struct CellSums {
    alignas(64) float seen[k_lanes]{};
    alignas(64) float all[k_lanes]{};
};
struct CellArrays {
    const float *x, *y, *z, *count;
    const std::uint8_t* visible;
};
// Set bits of each group of four of a row: even and odd groups are the bytes of a word each.
struct GroupCounts {
    alignas(64) std::uint64_t even[k_rows], odd[k_rows];
};
}   // namespace gnomon::area_light
#endif

HWY_BEFORE_NAMESPACE();
namespace gnomon::area_light::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void sum_cells(const CellArrays& cells, const glm::vec3& point, const glm::vec3& normal, const glm::vec3& horizon,
               const glm::vec3& light_normal, CellSums& sums)
{
    const hn::CappedTag<float, k_lanes> d;
    const hn::Rebind<std::int32_t, decltype(d)> whole;
    const hn::Rebind<std::uint8_t, decltype(d)> byte;
    const auto zero = hn::Zero(d);
    const auto px = hn::Set(d, point.x), py = hn::Set(d, point.y), pz = hn::Set(d, point.z);
    for (std::size_t i = 0; i < k_cells; i += hn::Lanes(d)) {
        const auto x = hn::Sub(hn::LoadU(d, cells.x + i), px), y = hn::Sub(hn::LoadU(d, cells.y + i), py),
                   z = hn::Sub(hn::LoadU(d, cells.z + i), pz);
        const auto along = [&](const glm::vec3& n) HWY_ATTR {
            return hn::Add(hn::Add(hn::Mul(x, hn::Set(d, n.x)), hn::Mul(y, hn::Set(d, n.y))),
                           hn::Mul(z, hn::Set(d, n.z)));
        };
        const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
        const auto here = along(normal), there = hn::Neg(along(light_normal));
        const auto arrives = hn::And(hn::And(hn::Gt(here, zero), hn::Gt(there, zero)), hn::Gt(along(horizon), zero));
        const auto weight = hn::IfThenElseZero(arrives, hn::Div(hn::Mul(here, there), hn::Mul(square, square)));
        const std::size_t lane = i % k_lanes;
        const auto visible = hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(byte, cells.visible + i)));
        hn::Store(hn::Add(hn::Load(d, sums.seen + lane), hn::Mul(weight, visible)), d, sums.seen + lane);
        hn::Store(hn::Add(hn::Load(d, sums.all + lane), hn::Mul(weight, hn::LoadU(d, cells.count + i))), d,
                  sums.all + lane);
    }
}

// @return  the number of bits of `inside` that are not blocked
int count_groups(const std::uint64_t* inside, const std::uint64_t* blocked, GroupCounts& out)
{
    const hn::CappedTag<std::uint64_t, 8> d;
    const auto pairs = hn::Set(d, 0x5555555555555555ull), fours = hn::Set(d, 0x3333333333333333ull),
               groups = hn::Set(d, 0x0f0f0f0f0f0f0f0full);
    auto sum = hn::Zero(d);   // four sums of 16 bits a lane
    for (std::size_t r = 0; r < k_rows; r += hn::Lanes(d)) {
        auto bits = hn::AndNot(hn::LoadU(d, blocked + r), hn::LoadU(d, inside + r));
        bits = hn::Sub(bits, hn::And(hn::ShiftRight<1>(bits), pairs));
        bits = hn::Add(hn::And(bits, fours), hn::And(hn::ShiftRight<2>(bits), fours));
        const auto even = hn::And(bits, groups), odd = hn::And(hn::ShiftRight<4>(bits), groups);
        hn::Store(even, d, out.even + r);
        hn::Store(odd, d, out.odd + r);
        const auto both = hn::Add(even, odd);
        const auto low = hn::Set(d, 0x00ff00ff00ff00ffull);
        sum = hn::Add(sum, hn::Add(hn::And(both, low), hn::And(hn::ShiftRight<8>(both), low)));
    }
    alignas(64) std::uint64_t lanes[8]{};
    hn::Store(sum, d, lanes);
    std::uint64_t count = 0;
    for (const std::uint64_t lane : lanes)
        for (int k = 0; k < 64; k += 16) count += lane >> k & 0xffff;
    return static_cast<int>(count);
}

}   // namespace gnomon::area_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cstring>

namespace gnomon::area_light {

namespace {

// A row of cells holds those of even columns first.
constexpr int k_columns = 16;
int column_of(int cell)
{
    const int at = cell % k_columns, half = k_columns / 2;
    return at < half ? 2 * at : 2 * (at - half) + 1;
}

}   // namespace

HWY_EXPORT(sum_cells);
HWY_EXPORT(count_groups);

int count_visible(const LightPlaces& places, const PlaceMask& blocked, VisibleCells& visible)
{
    GroupCounts groups;
    const int count = HWY_DYNAMIC_DISPATCH(count_groups)(places.inside().data(), blocked.data(), groups);
    // Add up the groups of each four rows.
    for (std::size_t r = 0; r < blocked.size(); r += 4) {
        const std::uint64_t even = groups.even[r] + groups.even[r + 1] + groups.even[r + 2] + groups.even[r + 3],
                            odd = groups.odd[r] + groups.odd[r + 1] + groups.odd[r + 2] + groups.odd[r + 3];
        std::memcpy(visible.data() + r * 4, &even, sizeof even);
        std::memcpy(visible.data() + r * 4 + sizeof even, &odd, sizeof odd);
    }
    return count;
}

LightCells::LightCells(const LightPlaces& places) : light_normal_(places.polygon().normal)
{
    for (int cell = 0; cell < k_cells; ++cell) {
        const int row = cell / k_columns * 4, first = column_of(cell) * 4;
        glm::dvec2 sum(0), middle(0);
        int count = 0;
        for (int r = row; r < row + 4; ++r)
            for (int i = first; i < first + 4; ++i) {
                const glm::dvec2 st(places.at(r, i));
                middle += st / 16.0;
                if ((places.inside()[static_cast<std::size_t>(r)] >> i & 1) == 0) continue;
                sum += st;
                ++count;
            }
        const glm::dvec2 st = count > 0 ? sum / static_cast<double>(count) : middle;
        const glm::dvec3 p =
            glm::dvec3(places.origin()) + st.x * glm::dvec3(places.side_s()) + st.y * glm::dvec3(places.side_t());
        const auto c = static_cast<std::size_t>(cell);
        x_[c] = static_cast<float>(p.x), y_[c] = static_cast<float>(p.y), z_[c] = static_cast<float>(p.z);
        count_[c] = static_cast<float>(count);
    }
    area_ = glm::length(glm::cross(places.side_s(), places.side_t())) / (k_square_rows * k_row_places);
}

float LightCells::share(const glm::vec3& point, const glm::vec3& normal, const glm::vec3& horizon,
                        const VisibleCells& visible) const
{
    CellSums sums;
    HWY_DYNAMIC_DISPATCH(sum_cells)
    ({x_.data(), y_.data(), z_.data(), count_.data(), visible.data()}, point, normal, horizon, light_normal_, sums);
    double part = 0, whole = 0;
    for (std::size_t lane = 0; lane < k_lanes; ++lane)
        part += static_cast<double>(sums.seen[lane]), whole += static_cast<double>(sums.all[lane]);
    return whole > 0 ? static_cast<float>(part / whole) : 0;
}

}   // namespace gnomon::area_light
#endif
