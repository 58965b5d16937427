// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rays by which a rough surface reflects its surroundings: directions of the glossy lobe (glossy.h), with weights.
//
// The directions of a point are a block of the (0, 2)-sequence (base/sobol.h), mapped to the lobe. The blocks of
// neighbouring pixels interleave: together they are one pattern that is 64 times as fine (lobe_block()).
//
// A second layer, such as a coat, is a lobe like others: copy the surface, and give it the layer's normal, roughness
// and reflectance.

#include <cstdint>
#include <span>

#include "shading/shading.h"

namespace gnomon::shading {

/// Mirror reflectances at normal incidence between which lobe rays replace the mirror ray: metals have lobe rays.
inline constexpr float k_lobe_reflectance_from = 0.1f, k_lobe_reflectance_to = 0.25f;
/// Pixels a side that have patterns of their own.
inline constexpr int k_lobe_interleave = 8;

/// How much of what a surface mirrors is brought by lobe rays, 0 to 1. The rest is brought by a mirror ray and by the
/// background, as continue_from() says.
float lobe_share(const SurfacePoint& s);

/// Moves that share of a surface's reflection to Continuation::lobe_weight.
void reflect_by_lobe(const SurfacePoint& s, Continuation& next);

struct LobeRay {
    glm::vec3 direction{0};   // unit, above the surface
    glm::vec3 weight{0};      // of its radiance, as a fraction of the light that the lobe reflects
    float density = 0;        // with which such rays are cast, per steradian: glossy_density()
};

/// Finds rays of a surface's lobe. @pre has_glossy_lobe(s)
/// @param first   of the pattern's points; a multiple of the number of rays, which is a power of two
/// @param flip    bits to flip in the pattern's points
/// @param random  the flips are random numbers: weights are those of an unbiased estimate. Otherwise they sum to 1
/// @param rays    out
/// @param counts  out, unless null: as how many rays they count beside those of other points, from their weights
/// @return  how many of `rays` were set: others would lie below the surface
std::size_t lobe_rays(const SurfacePoint& s, std::uint32_t first, const glm::uvec2& flip, bool random,
                      std::span<LobeRay> rays, float* counts = nullptr);

/// Finds one ray that stands for all of a lobe: one of a few, chosen as often as it brings light, with a weight of
/// about 1. @pre has_glossy_lobe(s)
/// @param number  of the ray: those of neighbouring numbers are well spread over the lobe together
/// @return  1, or 0: none of them is above the surface
std::size_t choose_lobe_ray(const SurfacePoint& s, std::uint32_t number, LobeRay& ray);

/// Widens a surface's lobe by the ray cone through which it is seen: by the cone's angle, and by how much the surface
/// turns below it. A highlight that is smaller than the part of another lobe in which it is seen would be met by few
/// rays, and be too bright there.
void widen_lobe(const ray::ObjectGeometry& geometry, std::uint32_t triangle, SurfacePoint& s);

/// The number of a pixel's block of the pattern, below the square of k_lobe_interleave.
std::uint32_t lobe_block(int x, int y);

/// An angle, in radians, by which the lobe's directions differ from its axis: half of the median.
float lobe_width(float roughness);

}   // namespace gnomon::shading
