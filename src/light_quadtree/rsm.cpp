// SPDX-License-Identifier: Apache-2.0
// This file is compiled once per instruction set: Highway includes it repeatedly.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_quadtree/rsm.cpp"
#include <hwy/foreach_target.h>   // must be the first include of Highway

#include <hwy/highway.h>

#include "light_quadtree/kernel-inl.h"
#include "light_quadtree/rsm.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::light_quadtree::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Adds the light of one view. @param texels  the map's finest level, as words
void sample_view_of(const float* texels, int side, const RsmPattern& pattern, const RsmPlaces& places,
                    Receivers& receivers, std::size_t begin, std::size_t end)
{
    const Real real;
    const hn::RebindToSigned<Real> integer;
    constexpr int k_words = sizeof(LightNode) / sizeof(float);
    constexpr auto k_per_pi = static_cast<float>(1 / k_pi);
    const auto width = hn::Set(real, static_cast<float>(side)), zero = hn::Zero(real);
    for (std::size_t k = begin; k < end; k += hn::Lanes(real)) {
        const Receiver receiver = load_receiver(receivers, k);
        const auto at_x = hn::LoadU(real, &places.x[k - begin]), at_y = hn::LoadU(real, &places.y[k - begin]);
        Sum sum{hn::LoadU(real, &receivers.r[k]), hn::LoadU(real, &receivers.g[k]), hn::LoadU(real, &receivers.b[k])};
        for (std::size_t s = 0; s < pattern.x.size(); ++s) {
            const auto x = hn::Add(at_x, hn::Set(real, pattern.x[s])), y = hn::Add(at_y, hn::Set(real, pattern.y[s]));
            const auto inside =
                hn::And(hn::And(hn::Ge(x, zero), hn::Lt(x, width)), hn::And(hn::Ge(y, zero), hn::Lt(y, width)));
            if (hn::AllFalse(real, inside)) continue;
            const auto column = hn::ConvertTo(integer, hn::IfThenElseZero(inside, x)),
                       row = hn::ConvertTo(integer, hn::IfThenElseZero(inside, y));
            const auto word = hn::Mul(hn::Add(hn::Mul(row, hn::Set(integer, side)), column), hn::Set(integer, k_words));
            const auto weight = hn::IfThenElseZero(inside, hn::Set(real, pattern.weight[s] * k_per_pi));
            const Light light{hn::GatherIndex(real, texels, word),
                              hn::GatherIndex(real, texels + 1, word),
                              hn::GatherIndex(real, texels + 2, word),
                              hn::GatherIndex(real, texels + 3, word),
                              hn::GatherIndex(real, texels + 4, word),
                              hn::GatherIndex(real, texels + 5, word),
                              hn::Mul(hn::GatherIndex(real, texels + 7, word), weight),
                              hn::Mul(hn::GatherIndex(real, texels + 8, word), weight),
                              hn::Mul(hn::GatherIndex(real, texels + 9, word), weight),
                              hn::Mul(hn::GatherIndex(real, texels + 10, word), weight)};
            add(light, receiver, sum);
        }
        store(sum, receivers, k);
    }
}

}   // namespace gnomon::light_quadtree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

#include "base/check.h"

namespace gnomon::light_quadtree {

HWY_EXPORT(sample_view_of);

static_assert(offsetof(LightNode, normal) == 3 * sizeof(float) && offsetof(LightNode, area) == 7 * sizeof(float) &&
              offsetof(LightNode, flux) == 8 * sizeof(float));

namespace {

// The position of a point in a view, in texels; clamped to the edge, or the centre if the view cannot see it.
glm::vec2 place_in(const LightMap::View& view, const glm::vec3& position)
{
    const glm::vec4 clip = view.projection.clip_from_world * glm::vec4(position, 1);
    if (!(clip.w > 0)) return glm::vec2(0.5f * static_cast<float>(view.side()));
    const glm::vec2 place = (glm::vec2(clip) / clip.w * 0.5f + 0.5f);
    return glm::clamp(place, 0.0f, 1.0f) * static_cast<float>(view.side());
}

int samples_a_view(const LightMap& map, const RsmOptions& options)
{
    const auto on = std::count_if(map.views().begin(), map.views().end(), [](const auto& view) { return view.on; });
    return std::max(1, options.samples / static_cast<int>(std::max<std::ptrdiff_t>(on, 1)));
}

}   // namespace

RsmPattern make_rsm_pattern(int samples, float radius, int side)
{
    GNOMON_CHECK(samples > 0 && radius > 0);
    RsmPattern pattern;
    const double reach = static_cast<double>(radius) * side;
    for (int k = 0; k < samples; ++k) {
        double inverse = 0;   // radical inverse of k in base 2
        for (std::uint32_t bits = static_cast<std::uint32_t>(k), i = 1; bits; bits >>= 1, ++i)
            inverse += (bits & 1) * std::ldexp(1.0, -static_cast<int>(i));
        const double xi = (k + 0.5) / samples, angle = 2 * k_pi * inverse;
        pattern.x.push_back(static_cast<float>(reach * xi * std::sin(angle)));
        pattern.y.push_back(static_cast<float>(reach * xi * std::cos(angle)));
        pattern.weight.push_back(static_cast<float>(2 * k_pi * xi * reach * reach / samples));
    }
    return pattern;
}

void sample_map(const LightMap& map, const RsmOptions& options, Receivers& receivers, std::size_t begin,
                std::size_t end, RsmPlaces& places)
{
    GNOMON_CHECK(begin % k_receiver_step == 0 && end % k_receiver_step == 0 && end <= receivers.x.size());
    for (auto* lane : {&receivers.r, &receivers.g, &receivers.b})
        std::fill(lane->begin() + static_cast<std::ptrdiff_t>(begin), lane->begin() + static_cast<std::ptrdiff_t>(end),
                  0.0f);
    RsmPattern pattern;
    for (const LightMap::View& view : map.views()) {
        if (!view.on) continue;
        if (pattern.x.empty()) pattern = make_rsm_pattern(samples_a_view(map, options), options.radius, view.side());
        places.x.resize(end - begin), places.y.resize(end - begin);
        for (std::size_t i = begin; i < end; ++i) {
            const glm::vec2 place = place_in(view, {receivers.x[i], receivers.y[i], receivers.z[i]});
            places.x[i - begin] = place.x, places.y[i - begin] = place.y;
        }
        const auto* texels = reinterpret_cast<const float*>(&map.node(view.node(view.levels, 0, 0)));
        HWY_DYNAMIC_DISPATCH(sample_view_of)(texels, view.side(), pattern, places, receivers, begin, end);
    }
}

glm::vec3 sample_map_one(const LightMap& map, const RsmOptions& options, const glm::vec3& position,
                         const glm::vec3& normal)
{
    glm::vec3 irradiance(0);
    Clusters light;
    for (const LightMap::View& view : map.views()) {
        if (!view.on) continue;
        const RsmPattern pattern = make_rsm_pattern(samples_a_view(map, options), options.radius, view.side());
        const glm::vec2 place = place_in(view, position);
        const auto side = static_cast<float>(view.side());
        for (std::size_t s = 0; s < pattern.x.size(); ++s) {
            const float x = place.x + pattern.x[s], y = place.y + pattern.y[s];
            if (!(x >= 0 && x < side && y >= 0 && y < side)) continue;
            const std::size_t id = view.node(view.levels, static_cast<int>(x), static_cast<int>(y));
            light.clear();
            light.push(map.node(id), id, view.levels);
            // A sample represents several texels, so scale its flux and area.
            for (auto* lane : {&light.disk, &light.r, &light.g, &light.b}) lane->front() *= pattern.weight[s];
            add_light(light, 0, position, normal, irradiance);
        }
    }
    return irradiance;
}

}   // namespace gnomon::light_quadtree
#endif
