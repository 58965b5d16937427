// SPDX-License-Identifier: Apache-2.0
#include "shading/lobe_rays.h"

#include <algorithm>

#include "base/sobol.h"
#include "shading/glossy.h"

namespace gnomon::shading {

namespace {

float fraction(std::uint32_t bits)
{
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

}   // namespace

float lobe_share(const SurfacePoint& s)
{
    const float most = std::max({s.specular.x, s.specular.y, s.specular.z});
    if (!(most > k_lobe_reflectance_from) || !has_glossy_lobe(s)) return 0;
    const float t =
        std::min((most - k_lobe_reflectance_from) / (k_lobe_reflectance_to - k_lobe_reflectance_from), 1.0f);
    return t * t * (3 - 2 * t);
}

void reflect_by_lobe(const SurfacePoint& s, Continuation& next)
{
    const float share = lobe_share(s);
    if (share == 0) return;
    next.lobe_weight = share * s.coverage * glossy_albedo(s);
    next.reflected_weight *= 1 - share;
    next.unresolved_weight *= 1 - share;
}

std::size_t lobe_rays(const SurfacePoint& s, std::uint32_t first, const glm::uvec2& flip, bool random,
                      std::span<LobeRay> rays)
{
    std::size_t count = 0;
    glm::vec3 sum(0);
    for (std::uint32_t k = 0; k < rays.size(); ++k) {
        const std::uint32_t i = first + k;
        const float u = fraction(reversed_bits(i) ^ flip.x), v = fraction(second_dimension(i) ^ flip.y);
        const glm::vec3 direction = sample_glossy(s, u, v);
        const float density = glossy_density(s, direction);
        if (!(density > 0)) continue;
        const glm::vec3 weight = reflect_glossy(s, direction) / density;   // 0 below the surface
        if (weight == glm::vec3(0)) continue;
        sum += weight;
        rays[count++] = {direction, weight};
    }
    // What the lobe reflects of light from everywhere is its albedo.
    if (random) sum = static_cast<float>(rays.size()) * s.coverage * glossy_albedo(s);
    for (std::size_t k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c) rays[k].weight[c] = sum[c] > 0 ? rays[k].weight[c] / sum[c] : 0;
    return count;
}

void widen_lobe(SurfacePoint& s)
{
    if (s.model != scene::ShadingModel::metallic_roughness) return;
    const float alpha = s.roughness * s.roughness, half = 0.5f * s.cone.spread;
    s.roughness = std::min(std::sqrt(std::sqrt(alpha * alpha + half * half)), 1.0f);
}

std::uint32_t lobe_block(int x, int y)
{
    static_assert(k_lobe_interleave == 8);
    // Neighbours get blocks that are far apart, and so do blocks of 2 x 2 and of 4 x 4 pixels.
    const auto a = static_cast<std::uint32_t>(x), b = static_cast<std::uint32_t>(y);
    const auto digit = [&](int bit) { return ((a ^ b) >> bit & 1) << 1 | (b >> bit & 1); };
    return digit(0) | digit(1) << 2 | digit(2) << 4;
}

float lobe_width(float roughness)
{
    return roughness * roughness;
}

}   // namespace gnomon::shading
