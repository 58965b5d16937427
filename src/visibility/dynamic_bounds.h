// SPDX-License-Identifier: Apache-2.0
#pragma once
// World-space boxes of the dynamic objects, and a query for those that can shadow a patch of points from a light. It
// saves static, unshadowed points the rays against dynamic objects.
//
// Cost per frame: the objects and groups that moved, times the depth of a tree of their boxes. Cost per query: that
// depth, and the boxes found.

#include <vector>

#include "base/box_tree.h"
#include "ray/ray_scene.h"

namespace gnomon::visibility {

class DynamicBounds {
 public:
    DynamicBounds(const scene::SceneState& state, const ray::RayScene& rays);
    /// Follows one advance() of the state, after the ray scene did. Objects that were promoted, or separated from their
    /// group, have boxes of their own from then on.
    void update(const scene::SceneState& state, const ray::RayScene& rays);

    /// Finds the boxes that a ray from anywhere in `points` to the light may intersect. Conservative.
    /// @param light  its position, or for a directional light the direction towards it
    /// @return how many boxes were tested
    std::size_t select(const Box3& points, const glm::vec3& light, bool directional, std::vector<Box3>& selected) const;
    /// The same for rays to anywhere in a box around a light with size.
    /// @param selected  indices of boxes
    std::size_t select(const Box3& points, const Box3& light, std::vector<std::uint32_t>& selected) const;
    /// The boxes of all visible dynamic objects.
    void all(std::vector<Box3>& boxes) const;
    /// The reference implementation, which tests all boxes. Returns them in another order.
    void select_of_all(const Box3& points, const glm::vec3& light, bool directional, std::vector<Box3>& selected) const;

    /// A box that the last update placed, and where it was before; empty: nowhere.
    struct Placed {
        std::uint32_t index;
        Box3 before;
    };
    const std::vector<Placed>& placed() const { return placed_; }
    /// Number of boxes; an index stays its object's or its group's.
    std::size_t size() const { return dynamic_.size(); }
    const Box3& box(std::uint32_t index) const { return dynamic_[index].world; }
    /// The update that last placed a box; 0: none did.
    std::uint64_t placed_at(std::uint32_t index) const { return dynamic_[index].placed_at; }
    /// Finds the objects in a box.
    void objects_of(std::uint32_t index, const scene::SceneState& state, std::vector<scene::ObjectId>& objects) const;

 private:
    struct DynamicObject {
        scene::ObjectId object;        // none: a group
        scene::GroupId group;          // none: an object by itself
        Box3 own;                      // of a group, in the space of its anchor
        Box3 world;                    // empty while it is hidden
        std::uint64_t placed_at = 0;   // the update that last placed it
    };
    std::uint32_t dynamic_of(scene::ObjectId object, const scene::SceneState& state);
    void place(DynamicObject& dynamic_object, const scene::SceneState& state, const ray::RayScene& rays);
    void measure_group(scene::GroupId group, const scene::SceneState& state, const ray::RayScene& rays);
    void grow_tree();

    std::vector<DynamicObject> dynamic_;
    BoxTree tree_;   // of their world boxes
    std::vector<Placed> placed_;
    std::vector<std::uint32_t> by_group_, by_object_;
    std::uint64_t updates_ = 0;
};

/// Whether a segment from anywhere in `points` to the light may intersect the blocker's box. Conservative.
bool may_shadow(const Box3& blocker, const Box3& points, const glm::vec3& light, bool directional);
/// The same for segments to anywhere in a box around a light with size.
bool may_shadow(const Box3& blocker, const Box3& points, const Box3& light);
/// The same for endless rays towards a disc in the sky.
/// @param to_light  its middle, unit
/// @param radius    angular, radians
bool may_shadow(const Box3& blocker, const Box3& points, const glm::vec3& to_light, float radius);

/// Whether the segment origin + direction * [0, end] intersects a box, with a margin for rounding.
bool segment_meets(const Box3& box, const glm::vec3& origin, const glm::vec3& direction, float end);

}   // namespace gnomon::visibility
