// SPDX-License-Identifier: Apache-2.0
// Highway includes this file repeatedly and compiles it once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shadow_culling/dynamic_mask/texels.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>

#include "shadow_culling/dynamic_mask/texels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::shadow_culling::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void find_texels_of(const LightSpace& space, const CullingView& view, float texel_pixels, Texels& points)
{
    const hn::ScalableTag<float> real;
    const hn::RebindToSigned<decltype(real)> integer;
    const hn::RebindToUnsigned<decltype(real)> word;
    using Real = hn::Vec<decltype(real)>;
    const auto set = [&](float value) { return hn::Set(real, value); };
    const auto dot = [](Real ax, Real ay, Real az, Real bx, Real by, Real bz) {
        return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
    };
    const LightSpace::Single& light = space.single();
    const bool directional = space.light().directional;
    const auto zero = hn::Zero(real), one = set(1), half = set(0.5f), two = set(2);
    const auto none = hn::Set(word, 0xffffffffu);
    for (std::size_t k = 0; k < points.count; k += hn::Lanes(real)) {
        const auto px = hn::LoadU(real, &points.x[k]), py = hn::LoadU(real, &points.y[k]),
                   pz = hn::LoadU(real, &points.z[k]);
        Real x, y, depth, width;
        auto face = hn::Zero(word);
        if (directional) {
            const auto scale = set(light.scale);
            x = hn::Mul(hn::Sub(dot(px, py, pz, set(light.s.x), set(light.s.y), set(light.s.z)), set(light.low_x)),
                        scale);
            y = hn::Mul(hn::Sub(dot(px, py, pz, set(light.t.x), set(light.t.y), set(light.t.z)), set(light.low_y)),
                        scale);
            depth = hn::Neg(dot(px, py, pz, set(light.to.x), set(light.to.y), set(light.to.z)));
            width = hn::Div(one, scale);
        } else {
            const auto qx = hn::Sub(px, set(light.to.x)), qy = hn::Sub(py, set(light.to.y)),
                       qz = hn::Sub(pz, set(light.to.z));
            const auto ax = hn::Abs(qx), ay = hn::Abs(qy), az = hn::Abs(qz);
            const auto by_x = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az)), by_y = hn::Ge(ay, az);
            const auto along = hn::IfThenElse(by_x, qx, hn::IfThenElse(by_y, qy, qz));
            const auto s = hn::IfThenElse(by_x, qy, hn::IfThenElse(by_y, qz, qx));
            const auto t = hn::IfThenElse(by_x, qz, hn::IfThenElse(by_y, qx, qy));
            const auto axis =
                hn::IfThenElse(hn::RebindMask(word, by_x), hn::Zero(word),
                               hn::IfThenElse(hn::RebindMask(word, by_y), hn::Set(word, 2), hn::Set(word, 4)));
            face = hn::Add(axis, hn::IfThenElseZero(hn::RebindMask(word, hn::Lt(along, zero)), hn::Set(word, 1)));
            depth = hn::Abs(along);
            const auto per = hn::Div(half, depth);
            x = hn::Add(half, hn::Mul(per, s));
            y = hn::Add(half, hn::Mul(per, t));
            width = hn::Mul(two, depth);
        }

        // The level is the exponent of the ratio of the face's width to a texel's.
        const auto ex = hn::Sub(px, set(view.eye.x)), ey = hn::Sub(py, set(view.eye.y)),
                   ez = hn::Sub(pz, set(view.eye.z));
        const auto distance = hn::Sqrt(dot(ex, ey, ez, ex, ey, ez));
        const auto pixel = hn::Add(set(view.pixel_width), hn::Mul(set(view.pixel_spread), distance));
        const auto across = hn::Div(width, hn::Mul(set(texel_pixels), pixel));
        auto level = hn::Sub(hn::BitCast(integer, hn::ShiftRight<23>(hn::BitCast(word, hn::Abs(across)))),
                             hn::Set(integer, 127));
        level = hn::Min(hn::Max(level, hn::Set(integer, static_cast<std::int32_t>(k_block_bits))),
                        hn::Set(integer, static_cast<std::int32_t>(k_max_mask_level)));
        const auto texels = hn::BitCast(real, hn::ShiftLeft<23>(hn::Add(level, hn::Set(integer, 127))));

        const auto inside = hn::And(hn::And(hn::Ge(x, zero), hn::Lt(x, one)), hn::And(hn::Ge(y, zero), hn::Lt(y, one)));
        const auto column = hn::BitCast(word, hn::ConvertTo(integer, hn::Mul(hn::IfThenElseZero(inside, x), texels)));
        const auto row = hn::BitCast(word, hn::ConvertTo(integer, hn::Mul(hn::IfThenElseZero(inside, y), texels)));
        const auto high = hn::Or(hn::ShiftLeft<3>(hn::BitCast(word, level)), face);
        const auto low =
            hn::Or(hn::ShiftLeft<16>(hn::ShiftRight<k_block_bits>(column)), hn::ShiftRight<k_block_bits>(row));
        const auto in_block = hn::Set(word, k_block_side - 1);
        const auto texel = hn::Or(hn::ShiftLeft<k_block_bits>(hn::And(row, in_block)), hn::And(column, in_block));
        const auto known = hn::RebindMask(word, inside);
        hn::StoreU(depth, real, &points.depth[k]);
        hn::StoreU(hn::IfThenElse(known, high, none), word, &points.high[k]);
        hn::StoreU(hn::IfThenElse(known, low, none), word, &points.low[k]);
        hn::StoreU(texel, word, &points.texel[k]);
    }
}

}   // namespace gnomon::shadow_culling::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::shadow_culling {

HWY_EXPORT(find_texels_of);

void Texels::resize(std::size_t points)
{
    constexpr std::size_t k_step = 16;   // no instruction set has more lanes
    const std::size_t padded = (points / k_step + 2) * k_step;
    count = points;
    for (std::vector<float>* lane : {&x, &y, &z, &depth}) lane->resize(padded);
    for (std::vector<std::uint32_t>* lane : {&high, &low, &texel}) lane->resize(padded);
}

std::uint32_t level_of(const LightSpace& space, const CullingView& view, float texel_pixels, const glm::vec3& point,
                       float depth)
{
    const float pixel = view.pixel_width + view.pixel_spread * glm::length(point - view.eye);
    const float across = space.face_width(depth) / (texel_pixels * pixel);
    const int level = across > 0 ? std::ilogb(across) : 0;
    return static_cast<std::uint32_t>(
        std::clamp(level, static_cast<int>(k_block_bits), static_cast<int>(k_max_mask_level)));
}

void find_texels(const LightSpace& space, const CullingView& view, float texel_pixels, Texels& points)
{
    HWY_DYNAMIC_DISPATCH(find_texels_of)(space, view, texel_pixels, points);
}

// Processes one point at a time without branches, because gathers cost three times as much for such short runs.
void compare_depths(const Texels& points, std::size_t first, std::size_t end, const MaskTexels& over,
                    const std::uint8_t* moving, float still, MaskAnswer* answer, std::uint8_t* clear)
{
    static_assert(static_cast<int>(MaskAnswer::unknown) == 1 && static_cast<int>(MaskAnswer::free) == 2 &&
                  static_cast<int>(MaskAnswer::occluded) == 3 && static_cast<int>(MaskAnswer::maybe_self) == 4);
    const float* const begins = over.begins.data();
    const float* const ends = over.ends.data();
    for (std::size_t i = first; i < end; ++i) {
        const float depth = points.depth[i];
        const std::uint32_t texel = over.texel[points.texel[i]], moves = moving[i];
        const std::uint32_t near = depth < begins[texel & 255], alone = depth < begins[texel >> 8 & 255];
        const std::uint32_t deep = depth > ends[texel >> 16];
        const std::uint32_t not_deep = 1 + near + 3 * (alone & ~near & moves);
        answer[i] = static_cast<MaskAnswer>(deep ? 3 : not_deep);
        clear[i] = static_cast<std::uint8_t>(moves & static_cast<std::uint32_t>(depth < still));
    }
}

}   // namespace gnomon::shadow_culling
#endif
