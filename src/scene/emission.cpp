// SPDX-License-Identifier: Apache-2.0
#include "scene/emission.h"

#include <algorithm>

namespace gnomon::scene {

namespace {

constexpr int k_looks = 8;   // a side of a triangle, at which its mean emission is looked up

}   // namespace

bool may_emit(const Material& material)
{
    return material.emissive != glm::vec3(0) && material.model == ShadingModel::metallic_roughness;
}

Emission::Emission(const Scene& scene, const Mesh& mesh, const Material& material)
    : scene_(scene), mesh_(mesh), material_(material)
{
    const auto has = [&](const TextureUse& use) { return use.used() && !mesh.texcoords[use.texcoord].empty(); };
    textured_ = has(material.emissive_texture);
    const bool thins = material.alpha_mode != AlphaMode::opaque;
    alpha_textured_ = thins && has(material.base_color_texture);
    alpha_varies_ = thins && (alpha_textured_ || !mesh.colors.empty());
}

glm::vec3 Emission::at(std::uint32_t triangle, float u, float v, float step) const
{
    glm::vec3 radiance = material_.emissive;
    const glm::uvec3 index = mesh_.triangles[triangle];
    if (textured_) radiance *= glm::vec3(look_up(material_.emissive_texture, index, u, v, step));
    if (material_.alpha_mode == AlphaMode::opaque) return radiance;
    float alpha = material_.alpha;
    if (!mesh_.colors.empty()) {
        const auto& c = mesh_.colors;
        alpha *= (1 - u - v) * c[index[0]].w + u * c[index[1]].w + v * c[index[2]].w;
    }
    if (alpha_textured_) alpha *= look_up(material_.base_color_texture, index, u, v, step).w;
    if (material_.alpha_mode == AlphaMode::blend) return radiance * std::clamp(alpha, 0.0f, 1.0f);
    return alpha >= material_.alpha_cutoff ? radiance : glm::vec3(0);
}

glm::vec3 Emission::mean(std::uint32_t triangle) const
{
    if (!varies()) return at(triangle, 0, 0, 0);
    // Look at the middles of the small triangles that point the same way, and of the others.
    glm::vec3 sum(0);
    constexpr float step = 1.0f / k_looks;
    for (int i = 0; i < k_looks; ++i)
        for (int j = 0; i + j < k_looks; ++j) {
            const float u = static_cast<float>(i), v = static_cast<float>(j);
            sum += at(triangle, (u + 1.0f / 3) * step, (v + 1.0f / 3) * step, step);
            if (i + j + 1 < k_looks) sum += at(triangle, (u + 2.0f / 3) * step, (v + 2.0f / 3) * step, step);
        }
    return sum / static_cast<float>(k_looks * k_looks);
}

glm::vec4 Emission::look_up(const TextureUse& use, const glm::uvec3& index, float u, float v, float step) const
{
    const auto& t = mesh_.texcoords[use.texcoord];
    const Texture& texture = scene_.textures[use.texture];
    const glm::vec2 here = use.apply((1 - u - v) * t[index[0]] + u * t[index[1]] + v * t[index[2]]);
    const glm::vec2 origin = use.apply(t[index[0]]);
    const float length =
        std::max(glm::length(use.apply(t[index[1]]) - origin), glm::length(use.apply(t[index[2]]) - origin));
    return texture.sample(here, length * step * static_cast<float>(std::max(texture.width(), texture.height())));
}

}   // namespace gnomon::scene
