// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/scene_triangles.h"

#include <algorithm>

namespace gnomon::shadow_culling {

SceneTriangles::SceneTriangles(const scene::SceneState& state, const ray::RayScene& rays, int part_levels,
                               float part_edge)
    : rays_(&rays)
{
    const scene::Scene& scene = state.scene();
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) dynamic_.push_back(state.is_dynamic(o));
    if (part_levels > 0) {
        number_parts(state, part_levels, part_edge);
        return;
    }
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        first_.push_back(static_cast<PrimitiveId>(object_.size()));
        object_.resize(object_.size() + scene.meshes[scene.objects[o].mesh].triangles.size(), o);
    }
    first_.push_back(static_cast<PrimitiveId>(object_.size()));
}

void SceneTriangles::number_parts(const scene::SceneState& state, int part_levels, float part_edge)
{
    const scene::Scene& scene = state.scene();
    const float longest = part_edge * rays_->bounds().diagonal();
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        first_.push_back(static_cast<PrimitiveId>(object_.size()));
        first_triangle_.push_back(static_cast<std::uint32_t>(begin_.size()));
        const auto triangles = static_cast<std::uint32_t>(scene.meshes[scene.objects[o].mesh].triangles.size());
        for (std::uint32_t t = 0; t < triangles; ++t) {
            glm::vec3 p[3];
            rays_->geometry(o).corners(t, p);
            // Halve the edges until the longest is short enough.
            float edge = std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[1]), glm::length(p[0] - p[2])});
            int level = 0;
            for (; level < part_levels && edge > longest; ++level) edge *= 0.5f;
            begin_.push_back(static_cast<PrimitiveId>(object_.size()));
            level_.push_back(static_cast<std::uint8_t>(level));
            const std::size_t parts = std::size_t{1} << (2 * level);
            object_.resize(object_.size() + parts, o);
            triangle_.resize(triangle_.size() + parts, t);
        }
    }
    first_.push_back(static_cast<PrimitiveId>(object_.size()));
}

void SceneTriangles::part_corners(PrimitiveId primitive, glm::vec3 (&p)[3]) const
{
    const scene::ObjectId object = object_[primitive];
    const std::uint32_t triangle = triangle_[primitive];
    const std::size_t t = first_triangle_[object] + triangle;
    rays_->geometry(object).corners(triangle, p);
    if (level_[t] == 0) return;
    glm::dvec2 corner[3];
    corners_of(micro_at(primitive - begin_[t], level_[t]), level_[t], corner);
    const glm::dvec3 origin(p[0]), along_u = glm::dvec3(p[1]) - origin, along_v = glm::dvec3(p[2]) - origin;
    for (int i = 0; i < 3; ++i) p[i] = glm::vec3(origin + corner[i].x * along_u + corner[i].y * along_v);
}

Box3 SceneTriangles::bounds(scene::ObjectId object) const
{
    Box3 box;
    glm::vec3 p[3];
    for (PrimitiveId primitive = first_of(object); primitive < end_of(object); ++primitive) {
        corners(primitive, p);
        for (const glm::vec3& corner : p) box.add(corner);
    }
    return box;
}

}   // namespace gnomon::shadow_culling
