// SPDX-License-Identifier: Apache-2.0
#include "frame/shown_bounds.h"

#include <algorithm>

namespace gnomon::frame {

bool ShownBounds::adds_to(const scene::Scene& scene)
{
    return std::any_of(scene.objects.begin(), scene.objects.end(),
                       [](const scene::Object& object) { return object.by_default && !object.removed; });
}

Box3 ShownBounds::of(const scene::SceneState& state)
{
    const scene::Scene& scene = state.scene();
    while (meshes_.size() < scene.meshes.size()) meshes_.push_back(scene.meshes[meshes_.size()].bounds());
    Box3 world;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        const scene::Object& object = scene.objects[o];
        const Box3& box = meshes_[object.mesh];
        if (object.removed || object.by_default || box.empty() || !state.object_visible(o)) continue;
        const glm::mat4 m = state.object_matrix(o);
        for (int corner = 0; corner < 8; ++corner)
            world.add(
                transform_point(m, glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                             corner & 4 ? box.high.z : box.low.z)));
    }
    return world;
}

}   // namespace gnomon::frame
