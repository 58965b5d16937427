// SPDX-License-Identifier: Apache-2.0
#pragma once
// The ray of a light view's texel, and what the texel stands for.

#include "light_views/projection.h"

namespace gnomon::light_quadtree {

/// Views side by side, without overlap: every direction belongs to one texel.
inline constexpr light_views::ProjectionOptions k_projection{.border = 0};

struct TexelRay {
    glm::vec3 origin, direction;   // unit
    double measure;                // solid angle (perspective), or area across the ray
};

inline TexelRay texel_ray(const light_views::ViewProjection& view, int x, int y)
{
    const double texel = 2.0 / view.size;
    const auto cx = static_cast<float>((x + 0.5) * texel - 1), cy = static_cast<float>((y + 0.5) * texel - 1);
    const double cell =
        texel * texel * static_cast<double>(glm::length(view.across)) * static_cast<double>(glm::length(view.down));
    const glm::vec3 off = cx * view.across + cy * view.down;
    if (!view.perspective) return {view.origin + off, glm::normalize(view.forward), cell};
    const glm::vec3 direction = view.forward + off;
    const auto length = static_cast<double>(glm::length(direction));
    const double forward = glm::length(view.forward);
    return {view.origin, glm::normalize(direction), cell * forward / (length * length * length)};
}

}   // namespace gnomon::light_quadtree
