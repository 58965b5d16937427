// SPDX-License-Identifier: Apache-2.0
#pragma once
// Anisotropic texture filtering: samples a texture over the elongated footprint of a pixel on a slanted surface. One
// trilinear sample has a square footprint, so it would alias along the ellipse or blur across it. Samples as wide as
// the ellipse are spread along its longer diameter [Heckbert 1989; McCormack et al. 1999]. gpu_scene/scene_data.glsl
// has the device's version.
//
// Cost: one look-up up to a ratio of three, in one or two levels; at most k_most_samples from a ratio of ten on.

#include <cmath>

#include "scene/footprint_shared.h"
#include "scene/texture.h"

namespace gnomon::scene {

/// Up to a ratio of k_stretch squared, a single sample is used, with the footprint of the ellipse's area. Beyond,
/// samples are k_stretch times as wide as the ellipse and lie side by side.
inline constexpr float k_stretch = GNOMON_FOOTPRINT_STRETCH;
inline constexpr int k_most_samples = GNOMON_FOOTPRINT_SAMPLES;

/// Linear RGBA over an ellipse around uv. If it is longer than k_most_samples can cover, samples get wider.
/// @param diameter, other  conjugate diameters in uv units; zeros, infinities and NaN are allowed
glm::vec4 sample_ellipse(const Texture& texture, glm::vec2 uv, glm::vec2 diameter, glm::vec2 other);

/// Transforms a difference of two coordinates as a material does: use.apply() without the offset.
inline glm::vec2 apply_to_step(const TextureUse& use, const glm::vec2& step)
{
    const glm::vec2 s = step * use.scale;
    if (use.rotation == 0) return s;
    const float c = std::cos(use.rotation), n = std::sin(use.rotation);
    return {c * s.x + n * s.y, -n * s.x + c * s.y};
}

}   // namespace gnomon::scene
