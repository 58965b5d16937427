// SPDX-License-Identifier: Apache-2.0
#pragma once
// Numbers all triangles of a scene, static and dynamic: the primitives of [Nah 2009].
//
// An object's triangles are consecutive, in the order of its mesh. Corners are the floats that rays are tested against;
// those of dynamic objects are not needed and not stored.

#include <vector>

#include "ray/ray_scene.h"
#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

class SceneTriangles {
 public:
    SceneTriangles(const scene::SceneState& state, const ray::RayScene& rays);

    std::size_t size() const { return object_.size(); }
    PrimitiveId id(scene::ObjectId object, std::uint32_t triangle) const { return first_[object] + triangle; }
    PrimitiveId first_of(scene::ObjectId object) const { return first_[object]; }
    PrimitiveId end_of(scene::ObjectId object) const { return first_[object + 1]; }
    scene::ObjectId object_of(PrimitiveId primitive) const { return object_[primitive]; }

    bool is_dynamic(PrimitiveId primitive) const { return dynamic_[object_[primitive]]; }
    bool object_is_dynamic(scene::ObjectId object) const { return dynamic_[object]; }
    void set_dynamic(scene::ObjectId object, bool dynamic) { dynamic_[object] = dynamic; }

    /// Present world-space corners.
    void corners(PrimitiveId primitive, glm::vec3 (&p)[3]) const
    {
        const scene::ObjectId object = object_[primitive];
        rays_->geometry(object).corners(primitive - first_[object], p);
    }
    Box3 bounds(scene::ObjectId object) const;
    void follow(const ray::RayScene& rays) { rays_ = &rays; }

 private:
    const ray::RayScene* rays_;
    std::vector<PrimitiveId> first_;        // by object, plus one entry: the end
    std::vector<scene::ObjectId> object_;   // by primitive
    std::vector<char> dynamic_;             // by object
};

}   // namespace gnomon::shadow_culling
