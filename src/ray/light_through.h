// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much light passes through surfaces that neither block it nor let all of it pass: alpha mode BLEND lets through
// 1 - alpha, and a thin sheet of glass its colour. Bodies of glass let everything through, unless a texture says where
// they are glass.

#include "scene/scene.h"

namespace gnomon::ray {

/// The part of light that passes at a point of a triangle, per channel, 0 to 1. Textures are sampled at full
/// resolution.
/// @param material  the triangle's; scene::thins_light()
glm::vec3 let_through(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
                      std::uint32_t triangle, float u, float v);

}   // namespace gnomon::ray
