// SPDX-License-Identifier: Apache-2.0
#pragma once
// What emissive materials emit along a surface: factor, texture, and the alpha of surfaces that are not opaque.
//
// Cost: a texture look-up or two for each place.

#include "scene/scene.h"

namespace gnomon::scene {

/// Whether a material may emit light: its emission is not 0, and it shows more than a colour.
bool may_emit(const Material& material);

/// The emission of a material on a mesh. All arguments must outlive it.
class Emission {
 public:
    Emission(const Scene& scene, const Mesh& mesh, const Material& material);

    /// Whether it differs from place to place.
    bool varies() const { return textured_ || alpha_varies_; }
    /// Radiance at the point (1-u-v) p0 + u p1 + v p2 of a triangle of the mesh.
    /// @param step  the width of the look-up, as a fraction of the triangle's edges
    glm::vec3 at(std::uint32_t triangle, float u, float v, float step) const;
    /// Mean radiance over a triangle.
    glm::vec3 mean(std::uint32_t triangle) const;

 private:
    glm::vec4 look_up(const TextureUse& use, const glm::uvec3& index, float u, float v, float step) const;

    const Scene& scene_;
    const Mesh& mesh_;
    const Material& material_;
    bool textured_, alpha_textured_, alpha_varies_;
};

}   // namespace gnomon::scene
