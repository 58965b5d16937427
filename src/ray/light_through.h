// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much light passes through surfaces that neither block it nor let all of it pass: alpha mode BLEND lets through
// 1 - alpha, and a thin sheet of glass its colour. Bodies of glass let everything through, unless a texture says where
// they are glass.

#include "scene/scene.h"

namespace gnomon::ray {

/// A point of such a surface.
struct ThinSurface {
    glm::vec3 passes{1};   // the part of light that passes, per channel, 0 to 1
    float covered = 1;     // the part of the point that is there, and reflects: the alpha of BLEND
};
/// Textures are sampled at full resolution.
/// @param material  the triangle's; scene::thins_light()
ThinSurface thin_surface(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
                         std::uint32_t triangle, float u, float v);

/// The part of light that passes there.
glm::vec3 let_through(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
                      std::uint32_t triangle, float u, float v);

}   // namespace gnomon::ray
