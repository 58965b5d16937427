// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "area_light/holed_places.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <bit>

#include "area_light/holed_places.h"

#ifndef GNOMON_AREA_LIGHT_HOLED_PLACES_ONCE
#define GNOMON_AREA_LIGHT_HOLED_PLACES_ONCE
namespace gnomon::area_light {
inline constexpr std::size_t k_step = 16;   // places of a row that are looked up together
// Texture coordinates along a row: (u, v) / w at t is (at + t * by_t), the first two components over the third.
struct AlongRow {
    glm::vec3 at, by_t;
    float shift;   // place i lies at t = (i + shift) / 64
};
struct LookUps {
    std::uint64_t solid = 0, mixed = 0;       // a bit for each place
    alignas(64) float u[k_step], v[k_step];   // coordinates
};
}   // namespace gnomon::area_light
#endif

HWY_BEFORE_NAMESPACE();
namespace gnomon::area_light::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A coordinate within one period, as Texture::alpha() reduces it.
template <class D, class V>
HWY_INLINE V reduced(D d, V x, scene::Wrap wrap)
{
    const auto zero = hn::Zero(d);
    const auto finite = hn::Lt(hn::Abs(x), hn::Set(d, k_infinity));
    x = hn::IfThenElse(finite, x, zero);
    switch (wrap) {
        case scene::Wrap::repeat:
            return hn::Sub(x, hn::Floor(x));
        case scene::Wrap::mirror:
            return hn::Sub(x, hn::Mul(hn::Set(d, 2.0f), hn::Floor(hn::Mul(hn::Set(d, 0.5f), x))));
        case scene::Wrap::clamp:
            break;
    }
    return hn::Min(hn::Max(x, hn::Set(d, -1.0f)), hn::Set(d, 2.0f));
}

void look_up(const AlongRow& row, int first, const HoleMap& map, LookUps& out)
{
    const hn::CappedTag<float, k_step> d;
    const hn::Rebind<std::int32_t, decltype(d)> di;
    const scene::Texture& texture = map.texture();
    const scene::Sampler& sampler = texture.sampler();
    const auto half = hn::Set(d, sampler.magnify == scene::Filter::linear ? 0.5f : 0.0f), one = hn::Set(d, 1.0f),
               zero = hn::Zero(d), scale = hn::Set(d, 1.0f / k_row_places);
    // The number of an entry along one side of the map.
    const auto entry_of = [&](auto coordinate, int size, int entries) HWY_ATTR {
        const auto texel = hn::Floor(hn::Sub(hn::Mul(coordinate, hn::Set(d, static_cast<float>(size))), half));
        const auto entry = hn::Add(texel, one);
        return hn::ConvertTo(di, hn::Min(hn::Max(entry, zero), hn::Set(d, static_cast<float>(entries - 1))));
    };
    const auto* const kinds = reinterpret_cast<const std::int32_t*>(map.kinds());   // read byte by byte
    out.solid = out.mixed = 0;
    for (std::size_t lane = 0; lane < k_step; lane += hn::Lanes(d)) {
        const auto place = hn::Iota(d, static_cast<float>(static_cast<std::size_t>(first) + lane));
        const auto t = hn::Mul(hn::Add(place, hn::Set(d, row.shift)), scale);
        const auto along = [&](int axis) HWY_ATTR {
            return hn::Add(hn::Set(d, row.at[axis]), hn::Mul(t, hn::Set(d, row.by_t[axis])));
        };
        const auto w = along(2);
        const auto u = hn::Div(along(0), w), v = hn::Div(along(1), w);
        hn::Store(u, d, out.u + lane);
        hn::Store(v, d, out.v + lane);
        const auto x = entry_of(reduced(d, u, sampler.wrap_u), texture.width(), map.columns());
        const auto y = entry_of(reduced(d, v, sampler.wrap_v), texture.height(), map.rows());
        const auto entry = hn::Add(hn::Mul(y, hn::Set(di, map.columns())), x);
        const auto kind = hn::And(hn::GatherOffset(di, kinds, entry), hn::Set(di, 0xff));
        const auto bits = [&](HoleMap::Kind of) HWY_ATTR {
            std::uint8_t stored[8]{};
            hn::StoreMaskBits(di, hn::Eq(kind, hn::Set(di, of)), stored);
            return static_cast<std::uint64_t>(stored[0] | stored[1] << 8) << lane;
        };
        out.solid |= bits(HoleMap::solid), out.mixed |= bits(HoleMap::mixed);
    }
}

}   // namespace gnomon::area_light::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace gnomon::area_light {

HWY_EXPORT(look_up);

namespace {

int period(int size, scene::Wrap wrap)
{
    return wrap == scene::Wrap::mirror ? 2 * size : size;
}

// How much of each corner of a triangle there is where a line from a point meets it, times a common factor: linear
// functions over a light's parallelogram.
struct CornerWeights {
    glm::dvec3 at, by_s, by_t;
    CornerWeights(const glm::vec3& point, const glm::vec3 (&corner)[3], const LightPlaces& places)
    {
        glm::dvec3 r[3];
        for (int c = 0; c < 3; ++c) r[c] = glm::dvec3(corner[c]) - glm::dvec3(point);
        const glm::dvec3 side[3] = {glm::cross(r[1], r[2]), glm::cross(r[2], r[0]), glm::cross(r[0], r[1])};
        const glm::dvec3 to(places.origin() - point), s(places.side_s()), t(places.side_t());
        for (int c = 0; c < 3; ++c)
            at[c] = glm::dot(side[c], to), by_s[c] = glm::dot(side[c], s), by_t[c] = glm::dot(side[c], t);
    }
};

}   // namespace

HoleMap::HoleMap(std::shared_ptr<const scene::Texture> texture, float alpha, float cutoff)
    : texture_(std::move(texture)), alpha_(alpha), cutoff_(cutoff)
{
    const scene::Sampler& sampler = texture_->sampler();
    columns_ = period(texture_->width(), sampler.wrap_u) + 1, rows_ = period(texture_->height(), sampler.wrap_v) + 1;
    constexpr std::size_t k_pad = 3;   // entries are read as words
    kinds_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + k_pad);
    const bool linear = sampler.magnify == scene::Filter::linear;
    // Filtering rounds, so that what is near the cutoff counts as mixed.
    constexpr float k_rounding = 1e-5f;
    const float above = cutoff * (1 + k_rounding), below = cutoff * (1 - k_rounding);
    // Find the least and the largest alpha of each two texels in a row, then of two rows.
    struct Range {
        std::uint8_t least, most;
    };
    std::vector<Range> upper(static_cast<std::size_t>(columns_)), lower(upper.size());
    const auto fill = [&](int y, std::vector<Range>& ranges) {
        for (int x = -1; x < columns_ - 1; ++x) {
            const std::uint8_t here = texture_->alpha_texel(x, y),
                               next = linear ? texture_->alpha_texel(x + 1, y) : here;
            ranges[static_cast<std::size_t>(x + 1)] = {std::min(here, next), std::max(here, next)};
        }
    };
    fill(-1, lower);
    std::uint8_t* kind = kinds_.data();
    for (int y = -1; y < rows_ - 1; ++y) {
        std::swap(upper, lower);
        fill(y + 1, lower);
        for (std::size_t x = 0; x < upper.size(); ++x, ++kind) {
            const Range range =
                linear ? Range{std::min(upper[x].least, lower[x].least), std::max(upper[x].most, lower[x].most)}
                       : upper[x];
            constexpr float k_scale = 1.0f / 255.0f;
            if (alpha * (range.least * k_scale) > above)
                *kind = solid;
            else
                *kind = alpha * (range.most * k_scale) < below ? hole : mixed;
        }
    }
}

bool add_blocked_past_holes(const glm::vec3& point, const glm::vec3 (&corner)[3], const glm::vec2 (&texcoord)[3],
                            const HoleMap& map, const LightPlaces& places, const PlaceMask& mask, PlaceMask& blocked)
{
    // Find the texture coordinates as linear functions over the light's parallelogram, divided by the sum of the
    // corners' weights.
    const CornerWeights weights(point, corner, places);
    glm::dvec3 at(0), along_s(0), along_t(0);
    for (int c = 0; c < 3; ++c) {
        const glm::dvec3 uv(texcoord[c].x, texcoord[c].y, 1);
        at += weights.at[c] * uv, along_s += weights.by_s[c] * uv, along_t += weights.by_t[c] * uv;
    }
    const glm::vec3 along_row(static_cast<double>(LightPlaces::slant) * along_s + along_t);

    bool any = false;
    LookUps found;
    for (int row = 0; row < k_rows; ++row) {
        const auto number = static_cast<std::size_t>(row);
        const std::uint64_t asked = mask[number] & places.inside()[number] & ~blocked[number];
        if (asked == 0) continue;
        const AlongRow along{glm::vec3(at + static_cast<double>(LightPlaces::row_start(row)) * along_s), along_row,
                             LightPlaces::row_shift(row)};
        std::uint64_t hidden = 0;
        for (int first = 0; first < k_row_places; first += static_cast<int>(k_step)) {
            const std::uint64_t bits = asked >> first & ((std::uint64_t{1} << k_step) - 1);
            if (bits == 0) continue;
            HWY_DYNAMIC_DISPATCH(look_up)(along, first, map, found);
            std::uint64_t solid = found.solid & bits;
            for (std::uint64_t mixed = found.mixed & bits; mixed != 0; mixed &= mixed - 1) {
                const auto k = static_cast<std::size_t>(std::countr_zero(mixed));
                if (!map.is_hole({found.u[k], found.v[k]})) solid |= std::uint64_t{1} << k;
            }
            hidden |= solid << first;
        }
        blocked[number] |= hidden;
        any = any || hidden != 0;
    }
    return any;
}

bool add_blocked_past_holes(const glm::vec3& point, const glm::vec3 (&corner)[3],
                            const std::function<bool(float, float)>& is_hole, const LightPlaces& places,
                            const PlaceMask& mask, PlaceMask& blocked)
{
    const CornerWeights weights(point, corner, places);
    bool any = false;
    for (int row = 0; row < k_rows; ++row) {
        const auto number = static_cast<std::size_t>(row);
        for (std::uint64_t bits = mask[number] & places.inside()[number] & ~blocked[number]; bits != 0;
             bits &= bits - 1) {
            const int place = std::countr_zero(bits);
            const glm::dvec2 st(places.at(row, place));
            const glm::dvec3 here = weights.at + st.x * weights.by_s + st.y * weights.by_t;
            const double sum = here.x + here.y + here.z;
            if (sum != 0 && is_hole(static_cast<float>(here.y / sum), static_cast<float>(here.z / sum))) continue;
            blocked[number] |= std::uint64_t{1} << place;
            any = true;
        }
    }
    return any;
}

}   // namespace gnomon::area_light
#endif
