// SPDX-License-Identifier: Apache-2.0
#pragma once
// Numbers all triangles of a scene, static and dynamic: the primitives of [Nah 2009].
//
// An object's primitives are consecutive, in the order of its mesh. Corners are the floats that rays are tested
// against.
//
// Optionally a primitive is a part of a triangle: large triangles are divided into 4^k equal parts
// (base/micro_triangles.h), so that fewer of them are shadowed or hidden in part. The paper names this as future work
// [4], with the subdivision of Dammertz and Keller (2008). Their heuristic bounds the volume of an edge's box, because
// it serves a BVH; here the length of the edges is bounded, because shadows have borders on axis-aligned floors, too.

#include <vector>

#include "base/micro_triangles.h"
#include "ray/ray_scene.h"
#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

class SceneTriangles {
 public:
    /// Objects are dynamic as in SceneState::is_dynamic(), until set_dynamic().
    /// @param part_levels  0: whole triangles; else the largest k of a division into 4^k parts
    /// @param part_edge    longest edge of a part that is not divided, as a fraction of the scene's diagonal
    SceneTriangles(const scene::SceneState& state, const ray::RayScene& rays, int part_levels = 0,
                   float part_edge = 1 / 256.f);

    std::size_t size() const { return object_.size(); }
    /// The first, or only, primitive of a triangle.
    PrimitiveId id(scene::ObjectId object, std::uint32_t triangle) const
    {
        return begin_.empty() ? first_[object] + triangle : begin_[first_triangle_[object] + triangle];
    }
    /// The primitive that contains the point with barycentric coordinates (u, v).
    PrimitiveId at(scene::ObjectId object, std::uint32_t triangle, float u, float v) const
    {
        if (begin_.empty()) return first_[object] + triangle;
        const std::size_t t = first_triangle_[object] + triangle;
        return begin_[t] + micro_index_at(u, v, level_[t]);
    }
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
        if (begin_.empty())
            rays_->geometry(object).corners(primitive - first_[object], p);
        else
            part_corners(primitive, p);
    }
    Box3 bounds(scene::ObjectId object) const;
    void follow(const ray::RayScene& rays) { rays_ = &rays; }
    std::size_t bytes() const
    {
        return 4 * (first_.size() + object_.size() + first_triangle_.size() + begin_.size() + triangle_.size()) +
               level_.size() + dynamic_.size();
    }

 private:
    void number_parts(const scene::SceneState& state, int part_levels, float part_edge);
    void part_corners(PrimitiveId primitive, glm::vec3 (&p)[3]) const;

    const ray::RayScene* rays_;
    std::vector<PrimitiveId> first_;        // by object, plus one entry: the end
    std::vector<scene::ObjectId> object_;   // by primitive
    std::vector<char> dynamic_;             // by object
    // Of parts; empty for whole triangles.
    std::vector<std::uint32_t> first_triangle_;   // by object: index into the next two
    std::vector<PrimitiveId> begin_;              // by triangle of the scene: its first part
    std::vector<std::uint8_t> level_;             // by triangle of the scene: of its division
    std::vector<std::uint32_t> triangle_;         // by primitive: of the object's mesh
};

}   // namespace gnomon::shadow_culling
