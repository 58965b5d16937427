// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where what moves is now, as boxes, and which of it can shadow a patch of points from a light: the mask that keeps
// rays from static, unshadowed points away from the dynamic objects' tree.
//
// Cost a frame: the groups that moved, by the depth of a tree of their boxes. Cost a query: what is near, and that
// depth.

#include <vector>

#include "base/box_tree.h"
#include "ray/ray_scene.h"

namespace gnomon::shadow_culling {

class DynamicBounds {
 public:
    DynamicBounds(const scene::SceneState& state, const ray::RayScene& rays);
    /// Follows one advance() of the state, after the ray scene did. Objects that were promoted, or separated from their
    /// group, have boxes of their own from then on.
    void update(const scene::SceneState& state, const ray::RayScene& rays);

    /// Boxes that a ray from anywhere in `points` to the light may meet. Conservative.
    /// @param light  its place, or for a directional light the direction towards it
    /// @return how many boxes were looked at
    std::size_t select(const Box3& points, const glm::vec3& light, bool directional, std::vector<Box3>& selected) const;
    /// The same by looking at all: its slow twin. In another order.
    void select_of_all(const Box3& points, const glm::vec3& light, bool directional, std::vector<Box3>& selected) const;

 private:
    struct DynamicObject {
        scene::ObjectId object;        // none: a group
        scene::GroupId group;          // none: an object by itself
        Box3 own;                      // of a group, in the space of its anchor
        Box3 world;                    // empty while it is hidden
        std::uint64_t placed_at = 0;   // the update that last did
    };
    std::uint32_t dynamic_of(scene::ObjectId object, const scene::SceneState& state);
    void place(DynamicObject& dynamic_object, const scene::SceneState& state, const ray::RayScene& rays);
    void grow_tree();

    std::vector<DynamicObject> dynamic_;
    BoxTree tree_;   // of their world boxes
    std::vector<std::uint32_t> by_group_, by_object_;
    std::uint64_t updates_ = 0;
};

/// Whether a segment from anywhere in `points` to the light may meet the blocker's box. Conservative.
bool may_shadow(const Box3& blocker, const Box3& points, const glm::vec3& light, bool directional);

/// Whether the segment from origin along direction * [0, end] meets a box, with a little room for rounding.
bool segment_meets(const Box3& box, const glm::vec3& origin, const glm::vec3& direction, float end);

}   // namespace gnomon::shadow_culling
