// SPDX-License-Identifier: Apache-2.0
#include "ray/light_through.h"

#include <algorithm>

#include "scene/material_layers.h"

namespace gnomon::ray {

ThinSurface thin_surface(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
                         std::uint32_t triangle, float u, float v)
{
    const glm::uvec3 index = mesh.triangles[triangle];
    const float w = 1 - u - v;
    const auto look_up = [&](const scene::TextureUse& use) {
        if (!use.used() || mesh.texcoords[use.texcoord].empty()) return glm::vec4(1);
        const auto& t = mesh.texcoords[use.texcoord];
        return scene.textures[use.texture].sample(use.apply(w * t[index[0]] + u * t[index[1]] + v * t[index[2]]), 0);
    };
    glm::vec4 base(material.base_color, material.alpha);
    base *= look_up(material.base_color_texture);
    if (!mesh.colors.empty()) base *= w * mesh.colors[index[0]] + u * mesh.colors[index[1]] + v * mesh.colors[index[2]];
    const float covered = material.alpha_mode == scene::AlphaMode::blend ? std::clamp(base.w, 0.0f, 1.0f) : 1;
    if (!(material.transmission > 0)) return {glm::vec3(1 - covered), covered};

    float transmission = material.transmission;
    glm::vec3 tint(1);
    if (material.layers) {
        transmission *= look_up(material.layers->transmission_texture).x;
        if (material.layers->thin_walled) tint = glm::clamp(glm::vec3(base), glm::vec3(0), glm::vec3(1));
    }
    transmission *= 1 - material.metallic * look_up(material.metallic_roughness_texture).z;
    return {glm::vec3(1 - covered) + covered * transmission * tint, covered};
}

glm::vec3 let_through(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
                      std::uint32_t triangle, float u, float v)
{
    return thin_surface(scene, mesh, material, triangle, u, v).passes;
}

}   // namespace gnomon::ray
