// SPDX-License-Identifier: Apache-2.0
#include "io/aff_shapes.h"

#include <cstring>

namespace gnomon::io {

namespace {

void add_quad(scene::Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, bool inside)
{
    for (glm::uvec3 t : {glm::uvec3(a, b, c), glm::uvec3(a, c, d)}) {
        if (mesh.positions[t.x] == mesh.positions[t.y] || mesh.positions[t.y] == mesh.positions[t.z] ||
            mesh.positions[t.z] == mesh.positions[t.x])
            continue;   // at a pole or apex
        if (inside) std::swap(t.y, t.z);
        mesh.triangles.push_back(t);
    }
}

}   // namespace

std::uint32_t AffMeshBuilder::vertex(const Corner& corner)
{
    std::string key(reinterpret_cast<const char*>(&corner.position), sizeof corner.position);
    if (normals_) key.append(reinterpret_cast<const char*>(&corner.normal), sizeof corner.normal);
    if (uvs_) key.append(reinterpret_cast<const char*>(&corner.uv), sizeof corner.uv);
    const auto [at, fresh] = known_.try_emplace(std::move(key), static_cast<std::uint32_t>(mesh_.positions.size()));
    if (fresh) {
        mesh_.positions.push_back(corner.position);
        if (normals_) mesh_.normals.push_back(corner.normal);
        if (uvs_) mesh_.texcoords[0].push_back(corner.uv);
    }
    return at->second;
}

void AffMeshBuilder::add_triangle(const Corner (&corner)[3])
{
    const std::uint32_t a = vertex(corner[0]), b = vertex(corner[1]), c = vertex(corner[2]);
    mesh_.triangles.emplace_back(a, b, c);
}

void AffMeshBuilder::add_polygon(const std::vector<Corner>& corners)
{
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) add_triangle({corners[0], corners[i], corners[i + 1]});
}

scene::Mesh AffMeshBuilder::take(scene::MaterialId material)
{
    mesh_.parts = {{material, 0, static_cast<std::uint32_t>(mesh_.triangles.size())}};
    known_.clear();
    return std::move(mesh_);
}

scene::Mesh aff_sphere(const glm::dvec3& centre, double radius, const AffTessellation& fineness)
{
    scene::Mesh mesh;
    const bool inside = radius < 0;
    const double r = std::abs(radius);
    for (int ring = 0; ring <= fineness.rings; ++ring) {
        const double theta = k_pi * ring / fineness.rings;
        // Exact at the poles, so that the triangles that meet there share one place.
        const double sine = ring == 0 || ring == fineness.rings ? 0 : std::sin(theta);
        for (int i = 0; i < fineness.around; ++i) {
            const double phi = 2 * k_pi * i / fineness.around;
            const glm::dvec3 n(sine * std::sin(phi), std::cos(theta), sine * std::cos(phi));
            mesh.positions.emplace_back(centre + r * n);
            mesh.normals.emplace_back(inside ? -n : n);
        }
    }
    const auto at = [&](int ring, int i) {
        return static_cast<std::uint32_t>(ring * fineness.around + i % fineness.around);
    };
    for (int ring = 0; ring < fineness.rings; ++ring)
        for (int i = 0; i < fineness.around; ++i)
            add_quad(mesh, at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1), inside);
    return mesh;
}

scene::Mesh aff_cone(const glm::dvec3& base, double base_radius, const glm::dvec3& apex, double apex_radius,
                     const AffTessellation& fineness)
{
    scene::Mesh mesh;
    const bool inside = base_radius < 0 || apex_radius < 0;
    const double r0 = std::abs(base_radius), r1 = std::abs(apex_radius);
    const glm::dvec3 axis = apex - base;
    const double height = glm::length(axis);
    const glm::dvec3 up = height > 0 ? axis / height : glm::dvec3(0, 1, 0);
    const glm::dvec3 side = glm::normalize(std::abs(up.y) < 0.9 ? glm::cross(up, glm::dvec3(0, 1, 0))
                                                                : glm::cross(up, glm::dvec3(1, 0, 0)));
    const glm::dvec3 other = glm::cross(up, side);
    for (const bool top : {false, true})
        for (int i = 0; i < fineness.around; ++i) {
            const double phi = 2 * k_pi * i / fineness.around;
            const glm::dvec3 out = std::cos(phi) * side + std::sin(phi) * other;
            const glm::dvec3 n = glm::normalize(height * out + (r0 - r1) * up);
            mesh.positions.emplace_back(top ? apex + r1 * out : base + r0 * out);
            mesh.normals.emplace_back(inside ? -n : n);
        }
    const auto n = static_cast<std::uint32_t>(fineness.around);
    for (std::uint32_t i = 0; i < n; ++i) add_quad(mesh, i, (i + 1) % n, n + (i + 1) % n, n + i, inside);
    return mesh;
}

}   // namespace gnomon::io
