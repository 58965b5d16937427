// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/dynamic_mask/dynamic_shapes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

namespace gnomon::shadow_culling {

namespace {

// Largest number of triangles times corners for which heights are computed.
constexpr std::size_t k_most_rises = 1u << 16;

// Numbers the corners so that equal positions share a number; lowest index first.
std::vector<std::uint32_t> weld(const ray::ObjectGeometry& geometry, bool deforming)
{
    const std::size_t count = geometry.mesh->positions.size();
    std::vector<std::uint32_t> same(count);
    std::iota(same.begin(), same.end(), 0u);
    if (deforming) return same;
    const auto bits = [&](std::uint32_t v) {
        const glm::vec3 p = geometry.positions[v] + glm::vec3(0.0f);   // -0 and 0 are the same position
        std::array<std::uint32_t, 3> b;
        std::memcpy(b.data(), &p, sizeof p);
        return b;
    };
    std::vector<std::uint32_t> order = same;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto of_a = bits(a), of_b = bits(b);
        return of_a != of_b ? of_a < of_b : a < b;
    });
    for (std::size_t i = 1; i < count; ++i)
        if (bits(order[i]) == bits(order[i - 1])) same[order[i]] = same[order[i - 1]];
    return same;
}

void find_edges(DynamicShape& shape)
{
    struct Half {
        std::uint32_t a, b, triangle;
        bool forward;
    };
    std::vector<Half> halves;
    halves.reserve(3 * shape.triangle.size());
    for (std::uint32_t t = 0; t < shape.triangle.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t a = shape.triangle[t][e], b = shape.triangle[t][(e + 1) % 3];
            halves.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    std::sort(halves.begin(), halves.end(), [](const Half& x, const Half& y) {
        if (x.a != y.a) return x.a < y.a;
        if (x.b != y.b) return x.b < y.b;
        return x.triangle < y.triangle;
    });
    for (std::size_t begin = 0; begin < halves.size();) {
        const Half& first = halves[begin];
        std::size_t end = begin;
        const auto side = static_cast<std::uint32_t>(shape.sides.size());
        for (; end < halves.size() && halves[end].a == first.a && halves[end].b == first.b; ++end)
            shape.sides.push_back({halves[end].triangle, halves[end].forward});
        shape.edge.push_back({first.a, first.b, side, static_cast<std::uint32_t>(end - begin)});
        begin = end;
    }
}

void find_rises(DynamicShape& shape, const ray::ObjectGeometry& geometry)
{
    const scene::Mesh& mesh = *geometry.mesh;
    std::vector<std::uint32_t> used(shape.masked_vertex);
    used.insert(used.end(), shape.vertex.begin(), shape.vertex.end());
    if (mesh.triangles.size() * used.size() > k_most_rises) return;
    shape.rise.assign(2 * mesh.triangles.size(), k_infinity);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        glm::dvec3 p[3];
        for (int c = 0; c < 3; ++c) p[c] = glm::dvec3(geometry.positions[mesh.triangles[t][c]]);
        const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double length = glm::length(cross);
        if (!(length > 0)) continue;
        const glm::dvec3 normal = cross / length;
        double above = 0, below = 0;
        for (const std::uint32_t v : used) {
            const double height = glm::dot(normal, glm::dvec3(geometry.positions[v]) - p[0]);
            above = std::max(above, height), below = std::max(below, -height);
        }
        shape.rise[2 * t] = static_cast<float>(above);
        shape.rise[2 * t + 1] = static_cast<float>(below);
    }
}

}   // namespace

DynamicShape shape_of(const scene::Scene& scene, const ray::ObjectGeometry& geometry, bool deforming)
{
    const scene::Mesh& mesh = *geometry.mesh;
    DynamicShape shape;
    const std::vector<std::uint32_t> same = weld(geometry, deforming);
    std::vector<std::uint32_t> number(mesh.positions.size(), 0xffffffffu);   // index in `vertex`
    for (const scene::MeshPart& part : mesh.parts) {
        const scene::SurfaceClass surface = scene.materials[part.material].surface_class();
        if (surface == scene::SurfaceClass::transparent) continue;
        for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
            const glm::uvec3& corners = mesh.triangles[part.first_triangle + i];
            glm::uvec3 triangle;
            for (int c = 0; c < 3; ++c) {
                if (surface == scene::SurfaceClass::masked) {
                    shape.masked_vertex.push_back(corners[c]);
                    continue;
                }
                const std::uint32_t v = same[corners[c]];
                if (number[v] == 0xffffffffu) {
                    number[v] = static_cast<std::uint32_t>(shape.vertex.size());
                    shape.vertex.push_back(v);
                }
                triangle[c] = number[v];
            }
            // Skip triangles without area: they occlude nothing and are not neighbours.
            const bool degenerate = triangle.x == triangle.y || triangle.y == triangle.z || triangle.z == triangle.x;
            if (surface == scene::SurfaceClass::opaque && !degenerate) shape.triangle.push_back(triangle);
        }
    }
    find_edges(shape);
    if (!deforming) find_rises(shape, geometry);
    return shape;
}

}   // namespace gnomon::shadow_culling
