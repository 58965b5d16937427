// SPDX-License-Identifier: Apache-2.0
#include "lighting/diffuse.h"

#include "scene/material_layers.h"

namespace gnomon::lighting {

glm::vec3 exitance_per_irradiance(const scene::Scene& scene, const ray::ObjectGeometry& geometry,
                                  std::uint32_t triangle, float u, float v)
{
    const scene::Mesh& mesh = *geometry.mesh;
    const glm::uvec3 index = mesh.triangles[triangle];
    const scene::Material& material = scene.materials[mesh.part_of(triangle).material];
    if (material.model == scene::ShadingModel::unlit) return glm::vec3(0);
    const float w = std::max(0.0f, 1 - u - v);
    const auto look_up = [&](const scene::TextureUse& use) {
        const auto& t = mesh.texcoords[use.texcoord];
        return scene.textures[use.texture].sample(use.apply(w * t[index[0]] + u * t[index[1]] + v * t[index[2]]), 0);
    };
    const auto has = [&](const scene::TextureUse& use) { return use.used() && !mesh.texcoords[use.texcoord].empty(); };

    glm::vec3 diffuse = material.base_color;
    if (has(material.base_color_texture)) diffuse *= glm::vec3(look_up(material.base_color_texture));
    if (material.model == scene::ShadingModel::whitted) return static_cast<float>(k_pi) * diffuse;
    if (!mesh.colors.empty())
        diffuse *= glm::vec3(w * mesh.colors[index[0]] + u * mesh.colors[index[1]] + v * mesh.colors[index[2]]);
    float metallic = material.metallic;
    if (has(material.metallic_roughness_texture)) metallic *= look_up(material.metallic_roughness_texture).z;
    float transmission = material.transmission;
    if (material.layers && has(material.layers->transmission_texture))
        transmission *= look_up(material.layers->transmission_texture).x;
    return diffuse * ((1 - metallic) * (1 - transmission));
}

glm::vec3 albedo(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u,
                 float v)
{
    const glm::vec3 exitance = exitance_per_irradiance(scene, geometry, triangle, u, v);
    const scene::Material& material = scene.materials[geometry.mesh->part_of(triangle).material];
    return material.model == scene::ShadingModel::whitted ? exitance * static_cast<float>(1 / k_pi) : exitance;
}

}   // namespace gnomon::lighting
