// SPDX-License-Identifier: Apache-2.0
#pragma once
// The ray of a light view's texel, and the measure of the texel.

#include "light_views/projection.h"

namespace gnomon::light_views {

/// Views of a point light without overlap: every direction belongs to one texel.
inline constexpr light_views::ProjectionOptions k_projection{.border = 0};

struct TexelWay {
    glm::vec3 origin, direction;   // unit
};

inline glm::vec3 texel_offset(const light_views::ViewProjection& view, int x, int y)
{
    const double texel = 2.0 / view.size;
    const auto cx = static_cast<float>((x + 0.5) * texel - 1), cy = static_cast<float>((y + 0.5) * texel - 1);
    return cx * view.across + cy * view.down;
}

inline TexelWay texel_way(const light_views::ViewProjection& view, int x, int y)
{
    const glm::vec3 off = texel_offset(view, x, y);
    if (!view.perspective) return {view.origin + off, glm::normalize(view.forward)};
    return {view.origin, glm::normalize(view.forward + off)};
}

/// The measure of a texel: solid angle (perspective), or area perpendicular to the ray.
inline double texel_measure(const light_views::ViewProjection& view, int x, int y)
{
    const double texel = 2.0 / view.size;
    const double cell =
        texel * texel * static_cast<double>(glm::length(view.across)) * static_cast<double>(glm::length(view.down));
    if (!view.perspective) return cell;
    const auto length = static_cast<double>(glm::length(view.forward + texel_offset(view, x, y)));
    const double forward = glm::length(view.forward);
    return cell * forward / (length * length * length);
}

struct TexelRay {
    glm::vec3 origin, direction;   // unit
    double measure;
};

inline TexelRay texel_ray(const light_views::ViewProjection& view, int x, int y)
{
    const TexelWay way = texel_way(view, x, y);
    return {way.origin, way.direction, texel_measure(view, x, y)};
}

}   // namespace gnomon::light_views
