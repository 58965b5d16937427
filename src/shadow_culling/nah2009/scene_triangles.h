// SPDX-License-Identifier: Apache-2.0
#pragma once
// All triangles of a scene under one numbering, static and dynamic alike: the primitives of [Nah 2009].
//
// An object's triangles follow one another in its mesh's order. Corners are the very floats that rays are tested
// against; those of dynamic objects are asked of nobody and not kept.

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

    /// World-space corners now.
    void corners(PrimitiveId primitive, glm::vec3 (&p)[3]) const
    {
        const scene::ObjectId object = object_[primitive];
        rays_->geometry(object).corners(primitive - first_[object], p);
    }
    Box3 bounds(scene::ObjectId object) const;
    void follow(const ray::RayScene& rays) { rays_ = &rays; }

 private:
    const ray::RayScene* rays_;
    std::vector<PrimitiveId> first_;        // by object, and one more: the end
    std::vector<scene::ObjectId> object_;   // by primitive
    std::vector<char> dynamic_;             // by object
};

}   // namespace gnomon::shadow_culling
