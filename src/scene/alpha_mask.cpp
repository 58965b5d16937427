// SPDX-License-Identifier: Apache-2.0
#include "scene/alpha_mask.h"

namespace gnomon::scene {

bool cut_away(const Scene& scene, const Mesh& mesh, const Material& material, std::uint32_t triangle, float u, float v)
{
    const glm::uvec3 index = mesh.triangles[triangle];
    const float w = 1 - u - v;
    float alpha = material.alpha;
    if (!mesh.colors.empty())
        alpha *= w * mesh.colors[index[0]].w + u * mesh.colors[index[1]].w + v * mesh.colors[index[2]].w;
    const TextureUse& use = material.base_color_texture;
    if (use.used() && !mesh.texcoords[use.texcoord].empty()) {
        const auto& t = mesh.texcoords[use.texcoord];
        alpha *= scene.textures[use.texture].alpha(use.apply(w * t[index[0]] + u * t[index[1]] + v * t[index[2]]));
    }
    return alpha < material.alpha_cutoff;
}

}   // namespace gnomon::scene
