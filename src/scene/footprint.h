// SPDX-License-Identifier: Apache-2.0
#pragma once
// A texture over an elongated footprint: what a pixel sees of a surface at a slant. One sample of the pyramid is as
// long as wide, so it would be aliased along the footprint or blurred across; samples as wide as it is are spread along
// it [Heckbert 1989; McCormack et al. 1999]. The device's twin is in gpu_scene/scene_data.glsl.
//
// Cost: one look-up up to a ratio of three, in one or two levels; at most k_most_samples from ten on.

#include <cmath>

#include "scene/footprint_shared.h"
#include "scene/texture.h"

namespace gnomon::scene {

/// A single sample has the footprint of the area it stands for, as long as that is up to k_stretch squared times as
/// long as wide. From there on samples are k_stretch times as wide as the footprint, and lie side by side.
inline constexpr float k_stretch = GNOMON_FOOTPRINT_STRETCH;
inline constexpr int k_most_samples = GNOMON_FOOTPRINT_SAMPLES;

/// Linear RGBA over an ellipse around uv. Where it is longer than k_most_samples can cover, they grow wider.
/// @param diameter, other  conjugate ones, in uv units; zeros, infinities and NaN are allowed
glm::vec4 sample_ellipse(const Texture& texture, glm::vec2 uv, glm::vec2 diameter, glm::vec2 other);

/// A difference of two coordinates as a material uses them: use.apply(), without the offset.
inline glm::vec2 apply_to_step(const TextureUse& use, const glm::vec2& step)
{
    const glm::vec2 s = step * use.scale;
    if (use.rotation == 0) return s;
    const float c = std::cos(use.rotation), n = std::sin(use.rotation);
    return {c * s.x + n * s.y, -n * s.x + c * s.y};
}

}   // namespace gnomon::scene
