// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/scene_triangles.h"

namespace gnomon::shadow_culling {

SceneTriangles::SceneTriangles(const scene::SceneState& state, const ray::RayScene& rays) : rays_(&rays)
{
    const scene::Scene& scene = state.scene();
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        first_.push_back(static_cast<PrimitiveId>(object_.size()));
        object_.resize(object_.size() + scene.meshes[scene.objects[o].mesh].triangles.size(), o);
        dynamic_.push_back(state.is_dynamic(o));
    }
    first_.push_back(static_cast<PrimitiveId>(object_.size()));
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
