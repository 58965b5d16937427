// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/interruption.h"
#include "scene/file_surfaces.h"

namespace gnomon::scene {

namespace {

constexpr double k_opposed = 0.98;        // of the area of a part whose normals are turned
constexpr double k_least_volume = 0.02;   // of a part that encloses some, in units of its area to the power of 1.5; a
                                          // ball has .094

// What the triangles of a part say about their sides.
struct Sides {
    double area = 0, opposed = 0;   // of all, and of those whose normals point to their backs
    double volume = 0;              // signed: negative if the triangles are wound inwards
};

Sides sides_of(const Mesh& mesh, const MeshPart& part)
{
    glm::dvec3 centre(0);
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
        for (int c = 0; c < 3; ++c) centre += glm::dvec3(mesh.positions[mesh.triangles[t][c]]);
    centre /= std::max(1.0, 3.0 * part.triangle_count);
    Sides sides;
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
        const glm::uvec3 corners = mesh.triangles[t];
        glm::dvec3 p[3], normal(0);
        for (int c = 0; c < 3; ++c) {
            p[c] = glm::dvec3(mesh.positions[corners[c]]) - centre;
            if (!mesh.normals.empty()) normal += glm::dvec3(mesh.normals[corners[c]]);
        }
        const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double area = 0.5 * glm::length(cross);
        if (!std::isfinite(area)) continue;
        sides.area += area;
        if (glm::dot(cross, normal) < 0) sides.opposed += area;
        sides.volume += glm::dot(p[0], cross) / 6;
    }
    return sides;
}

bool invisible(const Material& m)
{
    if (m.track || m.base_color_texture.used() || m.outline) return false;
    constexpr float k_least = 0.5f / 255;
    return (m.alpha_mode == AlphaMode::blend && m.alpha < k_least) ||
           (m.alpha_mode == AlphaMode::mask && m.alpha < m.alpha_cutoff);
}

}   // namespace

std::size_t turn_surfaces(Scene& scene)
{
    std::size_t turned = 0;
    for (MeshId id = 0; id < scene.meshes.size(); ++id) {
        if (scene.meshes[id].normals.empty() || scene.meshes[id].vertex_keys) continue;
        interruption_point();
        std::vector<char> done;   // by vertex
        for (std::size_t i = 0; i < scene.meshes[id].parts.size(); ++i) {
            const Mesh& mesh = scene.meshes[id];
            const MeshPart part = mesh.parts[i];
            const Material& material = scene.materials[part.material];
            if (material.outline) continue;
            const Sides sides = sides_of(mesh, part);
            if (!(sides.area > 0) || sides.opposed < k_opposed * sides.area) continue;
            ++turned;
            Mesh& edited = scene.meshes.edit(id);
            const bool inwards = sides.volume < -k_least_volume * sides.area * std::sqrt(sides.area);
            if (material.one_sided() && inwards) {
                for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
                    std::swap(edited.triangles[t].y, edited.triangles[t].z);
                continue;
            }
            // Parts may share vertices.
            done.resize(edited.positions.size());
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
                for (int c = 0; c < 3; ++c) {
                    const std::uint32_t v = edited.triangles[t][c];
                    if (std::exchange(done[v], 1)) continue;
                    edited.normals[v] = -edited.normals[v];
                    if (!edited.tangents.empty()) edited.tangents[v].w = -edited.tangents[v].w;
                    for (MorphTarget& target : edited.morph_targets)
                        if (!target.normals.empty()) target.normals[v] = -target.normals[v];
                }
        }
    }
    return turned;
}

bool show_invisible(Scene& scene)
{
    std::vector<char> used(scene.materials.size());
    for (const Node& node : scene.nodes) {
        if (node.mesh == none) continue;
        for (const MeshPart& part : scene.meshes[node.mesh].parts)
            if (part.triangle_count > 0) used[part.material] = 1;
    }
    bool any = false;
    for (MaterialId m = 0; m < scene.materials.size(); ++m) {
        if (!used[m]) continue;
        if (!invisible(scene.materials[m])) return false;
        any = true;
    }
    if (!any) return false;
    for (MaterialId m = 0; m < scene.materials.size(); ++m) {
        if (!used[m]) continue;
        scene.materials[m].alpha = 1;
        scene.materials[m].alpha_mode = AlphaMode::opaque;
    }
    return true;
}

namespace {

// Whether a part of a mesh is one-sided, encloses a volume and is wound inwards.
bool is_shell(const Scene& scene, const Mesh& mesh, const MeshPart& part)
{
    const Material& material = scene.materials[part.material];
    if (!material.one_sided() || material.outline || material.catches_shadows) return false;
    const Sides sides = sides_of(mesh, part);
    return sides.volume < -k_least_volume * sides.area * std::sqrt(sides.area);
}

}   // namespace

bool has_shells(const Scene& scene)
{
    for (MeshId id = 0; id < scene.meshes.size(); ++id) {
        const Mesh& mesh = scene.meshes[id];
        if (std::ranges::any_of(mesh.parts, [&](const MeshPart& part) { return is_shell(scene, mesh, part); }))
            return true;
    }
    return false;
}

std::size_t open_shells(Scene& scene)
{
    std::size_t opened = 0;
    std::map<MaterialId, MaterialId> copies;
    for (MeshId id = 0; id < scene.meshes.size(); ++id)
        for (std::size_t i = 0; i < scene.meshes[id].parts.size(); ++i) {
            const MeshPart part = scene.meshes[id].parts[i];
            if (!is_shell(scene, scene.meshes[id], part)) continue;
            const auto [known, fresh] =
                copies.try_emplace(part.material, static_cast<MaterialId>(scene.materials.size()));
            if (fresh) {
                Material copy = scene.materials[part.material];
                copy.outline = true;
                scene.materials.push_back(std::move(copy));
            }
            scene.meshes.edit(id).parts[i].material = known->second;
            ++opened;
        }
    return opened;
}

void repair_surfaces(Scene& scene)
{
    leave_out_repeats(scene);
    if (const std::size_t turned = turn_surfaces(scene); turned > 0)
        scene.warnings.push_back(fmt::format("{} whose normals point to {} back: turned",
                                             turned == 1 ? "1 surface" : fmt::format("{} surfaces", turned),
                                             turned == 1 ? "its" : "their"));
    find_sky_domes(scene);
    if (show_invisible(scene)) scene.warnings.emplace_back("every surface is entirely transparent: shown as opaque");
}

}   // namespace gnomon::scene
