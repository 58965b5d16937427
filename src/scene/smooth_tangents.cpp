// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/interruption.h"
#include "scene/file_surfaces.h"
#include "scene/material_layers.h"
#include "scene/mesh_repairs.h"

namespace gnomon::scene {

namespace {

// The texture coordinates by which a material's tangents run; none: it needs no tangents. -1: those of its textures
// disagree, or are turned or mirrored by a transform, which a mesh's tangents do not follow.
std::optional<int> tangent_set(const Material& material)
{
    std::optional<int> set;
    const auto use = [&](const TextureUse& texture, bool needed) {
        if (!needed) return;
        const int own = texture.used() ? texture.texcoord : 0;
        const bool plain = texture.rotation == 0 && texture.scale.x > 0 && texture.scale.y > 0;
        set = plain && (!set || *set == own) ? own : -1;
    };
    use(material.normal_texture, material.normal_texture.used());
    if (!material.layers) return set;
    const MaterialLayers& layers = *material.layers;
    use(layers.clearcoat_normal_texture, layers.clearcoat_normal_texture.used());
    use(layers.anisotropy_texture, layers.anisotropy > 0 || layers.anisotropy_texture.used());
    return set;
}

// Adds the directions of u on the triangles around each vertex, weighted by their angles there, to sums, and the side
// to which v runs to signs. Returns whether the triangles around each vertex agree on that.
bool sum_tangents(const Mesh& mesh, const MeshPart& part, int set, std::vector<glm::vec3>& sums,
                  std::vector<signed char>& signs)
{
    const std::vector<glm::vec2>& uv = mesh.texcoords[set];
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
        const glm::uvec3 corners = mesh.triangles[t];
        const glm::dvec3 p[3] = {glm::dvec3(mesh.positions[corners.x]), glm::dvec3(mesh.positions[corners.y]),
                                 glm::dvec3(mesh.positions[corners.z])};
        const glm::dvec2 a = glm::dvec2(uv[corners.y]) - glm::dvec2(uv[corners.x]),
                         b = glm::dvec2(uv[corners.z]) - glm::dvec2(uv[corners.x]);
        const double determinant = a.x * b.y - a.y * b.x;
        if (determinant == 0 || !std::isfinite(determinant)) continue;
        // Only the direction counts: leave out the division, but not its sign.
        const double turn = determinant > 0 ? 1 : -1;
        const glm::dvec3 along = turn * ((p[1] - p[0]) * b.y - (p[2] - p[0]) * a.y);
        for (int c = 0; c < 3; ++c) {
            const std::uint32_t v = corners[c];
            const glm::dvec3 n(mesh.normals[v]), to_next = p[(c + 1) % 3] - p[c], to_last = p[(c + 2) % 3] - p[c];
            const double sides = glm::length(to_next) * glm::length(to_last);
            const glm::dvec3 flat = along - n * glm::dot(n, along);
            const double length = glm::length(flat);
            if (!(sides > 0) || !(length > 0)) continue;
            const double angle = std::acos(std::clamp(glm::dot(to_next, to_last) / sides, -1.0, 1.0));
            sums[v] += glm::vec3(flat * (angle / length));
            // In glTF, the second tangent points against v, which runs down.
            const auto sign = static_cast<signed char>(determinant > 0 ? -1 : 1);
            if (signs[v] == -sign) return false;
            signs[v] = sign;
        }
    }
    return true;
}

}   // namespace

std::size_t add_tangents(Scene& scene)
{
    std::size_t added = 0;
    for (MeshId id = 0; id < scene.meshes.size(); ++id) {
        const Mesh& mesh = scene.meshes[id];
        if (mesh.normals.empty() || !mesh.tangents.empty() || mesh.vertex_keys) continue;
        bool needed = false, possible = true;
        for (const MeshPart& part : mesh.parts) {
            const std::optional<int> set = tangent_set(scene.materials[part.material]);
            if (!set) continue;
            needed = true;
            possible = possible && *set >= 0 && *set < 2 && !mesh.texcoords[*set].empty();
        }
        if (!needed || !possible) continue;
        interruption_point();
        std::vector<glm::vec3> sums(mesh.positions.size(), glm::vec3(0));
        std::vector<signed char> signs(mesh.positions.size());
        for (const MeshPart& part : mesh.parts)
            if (const std::optional<int> set = tangent_set(scene.materials[part.material]); set && possible)
                possible = sum_tangents(mesh, part, *set, sums, signs);
        if (!possible) continue;
        std::vector<glm::vec4> tangents(sums.size());
        for (std::size_t v = 0; v < sums.size(); ++v)
            tangents[v] = {unit_or(sums[v], perpendicular_to(mesh.normals[v])), signs[v] < 0 ? -1.0f : 1.0f};
        scene.meshes.edit(id).tangents = std::move(tangents);
        ++added;
    }
    return added;
}

}   // namespace gnomon::scene
