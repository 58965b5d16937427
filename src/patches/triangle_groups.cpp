// SPDX-License-Identifier: Apache-2.0
#include "patches/triangle_groups.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "base/math.h"
#include "patches/detail_cells.h"

namespace gnomon::patches {

namespace {

constexpr std::uint32_t k_steps = 1023;   // of the curve, by axis

std::uint32_t every_third_bit(std::uint32_t x)
{
    x = (x | (x << 16)) & 0x030000ffu;
    x = (x | (x << 8)) & 0x0300f00fu;
    x = (x | (x << 4)) & 0x030c30c3u;
    return (x | (x << 2)) & 0x09249249u;
}

std::uint32_t code_of(const glm::vec3& at, const Box3& box)
{
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float size = box.high[axis] - box.low[axis];
        const float step = size > 0 ? (at[axis] - box.low[axis]) / size * static_cast<float>(k_steps) : 0;
        code |= every_third_bit(static_cast<std::uint32_t>(std::clamp(step, 0.0f, static_cast<float>(k_steps))))
                << axis;
    }
    return code;
}

}   // namespace

TriangleGroups group_triangles(const scene::Scene& scene, const ray::ObjectGeometry& geometry,
                               const GroupOptions& options)
{
    struct Entry {
        std::uint64_t key = 0;   // part of the mesh, facing, place
        std::uint32_t triangle = 0;
        float area = 0;
    };
    const scene::Mesh& mesh = *geometry.mesh;
    const auto corners = [&](std::uint32_t triangle, glm::vec3(&p)[3]) {
        for (int i = 0; i < 3; ++i) p[i] = geometry.positions[mesh.triangles[triangle][i]];
    };
    const auto centre_of = [](const glm::vec3(&p)[3]) { return (p[0] + p[1] + p[2]) / 3.0f; };

    // Sort the triangles.
    Box3 box;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        glm::vec3 p[3];
        corners(t, p);
        for (const glm::vec3& corner : p) box.add(corner);
    }
    std::vector<Entry> entries;
    entries.reserve(mesh.triangles.size());
    for (std::size_t part = 0; part < mesh.parts.size(); ++part) {
        const scene::MeshPart& of = mesh.parts[part];
        if (scene.materials[of.material].surface_class() == scene::SurfaceClass::transparent) continue;
        for (std::uint32_t t = of.first_triangle; t < of.first_triangle + of.triangle_count; ++t) {
            glm::vec3 p[3];
            corners(t, p);
            const glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const float area = 0.5f * glm::length(normal);
            if (!(area > 0) || !std::isfinite(area)) continue;
            const auto facing = static_cast<std::uint64_t>(facing_of(normal));
            entries.push_back(
                {static_cast<std::uint64_t>(part) << 36 | facing << 32 | code_of(centre_of(p), box), t, area});
        }
    }
    interruption_point();
    std::ranges::sort(entries, {}, [](const Entry& e) { return std::pair(e.key, e.triangle); });

    // Cut them into runs of one part and facing.
    TriangleGroups result;
    result.group_of.assign(mesh.triangles.size(), scene::none);
    for (std::size_t begin = 0; begin < entries.size();) {
        std::size_t end = begin;
        float area = 0;
        while (end < entries.size() && end - begin < options.triangles &&
               entries[end].key >> 32 == entries[begin].key >> 32 &&
               (end == begin || area + entries[end].area <= options.area))
            area += entries[end++].area;
        const Entry& middle = entries[begin + (end - begin) / 2];
        TriangleGroups::Group group{middle.triangle, area / middle.area, 0};
        glm::vec3 p[3];
        corners(middle.triangle, p);
        const glm::vec3 centre = centre_of(p);
        const float edge = std::max({glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
        for (std::size_t i = begin; i < end; ++i) {
            result.group_of[entries[i].triangle] = static_cast<std::uint32_t>(result.groups.size());
            glm::vec3 q[3];
            corners(entries[i].triangle, q);
            for (const glm::vec3& corner : q)
                group.radius = std::max(group.radius, glm::distance(corner, centre) / edge);
        }
        result.groups.push_back(group);
        begin = end;
    }
    return result;
}

}   // namespace gnomon::patches
