// SPDX-License-Identifier: Apache-2.0
#include "io/aff/shapes.h"

#include <cmath>

#include "base/check.h"

namespace gnomon::io {

namespace {

void turn_inside_out(scene::Mesh& mesh)
{
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    for (glm::vec3& n : mesh.normals) n = -n;
}

}   // namespace

scene::Mesh make_unit_sphere(const AffShapeOptions& options, bool inside)
{
    const auto segments = static_cast<std::uint32_t>(options.sphere_segments);
    const auto rings = static_cast<std::uint32_t>(options.sphere_rings);
    GNOMON_CHECK(segments >= 3 && rings >= 2);

    // Two poles on the y axis, and rings of vertices between them from the top down.
    scene::Mesh mesh;
    mesh.positions.emplace_back(0, 1, 0);
    for (std::uint32_t ring = 1; ring < rings; ++ring)
        for (std::uint32_t s = 0; s < segments; ++s) {
            const double theta = k_pi * ring / rings, phi = 2 * k_pi * s / segments;
            mesh.positions.emplace_back(std::sin(theta) * std::sin(phi), std::cos(theta),
                                        std::sin(theta) * std::cos(phi));
        }
    mesh.positions.emplace_back(0, -1, 0);
    mesh.normals = mesh.positions;

    const auto vertex = [&](std::uint32_t ring, std::uint32_t s) { return 1 + (ring - 1) * segments + s % segments; };
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    for (std::uint32_t s = 0; s < segments; ++s) {
        mesh.triangles.emplace_back(0, vertex(1, s), vertex(1, s + 1));
        for (std::uint32_t ring = 1; ring + 1 < rings; ++ring) {
            mesh.triangles.emplace_back(vertex(ring, s), vertex(ring + 1, s), vertex(ring + 1, s + 1));
            mesh.triangles.emplace_back(vertex(ring, s), vertex(ring + 1, s + 1), vertex(ring, s + 1));
        }
        mesh.triangles.emplace_back(last, vertex(rings - 1, s + 1), vertex(rings - 1, s));
    }
    if (inside) turn_inside_out(mesh);
    return mesh;
}

scene::Mesh make_cone(const AffShapeOptions& options, const glm::dvec3& base, double base_radius,
                      const glm::dvec3& apex, double apex_radius, bool inside)
{
    const auto segments = static_cast<std::uint32_t>(options.cone_segments);
    GNOMON_CHECK(segments >= 3 && base_radius >= 0 && apex_radius >= 0 && base_radius + apex_radius > 0);
    const glm::dvec3 along = apex - base;
    const double length = glm::length(along);
    GNOMON_CHECK(length > 0);

    // Choose two vectors perpendicular to the axis.
    const glm::dvec3 axis = along / length;
    const glm::dvec3 least = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 s = glm::normalize(glm::cross(least, axis)), t = glm::cross(axis, s);

    // Alternate base and apex vertices; the normal leans along the axis like the side.
    scene::Mesh mesh;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double phi = 2 * k_pi * i / segments;
        const glm::dvec3 out = std::cos(phi) * s + std::sin(phi) * t;
        const glm::dvec3 normal = glm::normalize(length * out + (base_radius - apex_radius) * axis);
        mesh.positions.emplace_back(base + base_radius * out);
        mesh.positions.emplace_back(apex + apex_radius * out);
        mesh.normals.insert(mesh.normals.end(), 2, glm::vec3(normal));
    }
    for (std::uint32_t i = 0; i < segments; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % segments);
        if (base_radius > 0) mesh.triangles.emplace_back(a, b, b + 1);
        if (apex_radius > 0) mesh.triangles.emplace_back(a, b + 1, a + 1);
    }
    if (inside) turn_inside_out(mesh);
    return mesh;
}

}   // namespace gnomon::io
