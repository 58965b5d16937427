// SPDX-License-Identifier: Apache-2.0
#include "ray/portable/judge.h"

#include <tuple>

#include "ray/light_through.h"
#include "scene/alpha_mask.h"

namespace gnomon::ray {

namespace {

const scene::Material& material_of(const GeometryRecord& record, std::uint32_t triangle)
{
    return record.scene->materials[record.mesh->part_of(triangle).material];
}

bool is_hole(const GeometryRecord& record, std::uint32_t triangle, float u, float v)
{
    const scene::Material& material = material_of(record, triangle);
    return material.alpha_mode == scene::AlphaMode::mask &&
           scene::cut_away(*record.scene, *record.mesh, material, triangle, u, v);
}

}   // namespace

bool is_hole(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle, float u, float v)
{
    const GeometryRecord& record = instance.tree->record(geometry);
    return is_hole(record, record.first_triangle + triangle, u, v);
}

bool occludes(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle, float u, float v,
              const RayQuery& query, std::size_t lane)
{
    const GeometryRecord& record = instance.tree->record(geometry);
    const std::uint32_t of_mesh = record.first_triangle + triangle;
    if (record.masked) return !is_hole(record, of_mesh, u, v);
    if (!query.thin) return false;
    const scene::Material& material = material_of(record, of_mesh);
    if (!scene::thins_light(material)) return false;
    const glm::vec3 passes = let_through(*record.scene, *record.mesh, material, of_mesh, u, v);
    if (passes != glm::vec3(1))
        query.thin->push_back({static_cast<unsigned>(lane), instance.id, geometry, triangle, passes});
    return false;
}

bool comes_first(const TreeInstance& a, std::uint32_t a_geometry, std::uint32_t a_triangle, const TreeInstance& b,
                 std::uint32_t b_geometry, std::uint32_t b_triangle)
{
    return std::tuple(object_of(a, a_geometry), triangle_of(a, a_geometry, a_triangle)) >
           std::tuple(object_of(b, b_geometry), triangle_of(b, b_geometry, b_triangle));
}

scene::ObjectId object_of(const TreeInstance& instance, std::uint32_t geometry)
{
    return instance.object != scene::none ? instance.object : instance.tree->record(geometry).object;
}

std::uint32_t triangle_of(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle)
{
    return instance.tree->record(geometry).first_triangle + triangle;
}

}   // namespace gnomon::ray
