// SPDX-License-Identifier: Apache-2.0
#pragma once
// Determines which objects cast shadows, and their current bounding boxes.
//
// Boxes of rigid objects are those of their meshes, computed once; those of deforming objects are recomputed when they
// deform. Cost per frame: the vertices of objects that deformed.

#include <memory>
#include <span>
#include <vector>

#include "light_views/projection.h"

namespace gnomon::light_views {

class Casters {
 public:
    explicit Casters(const scene::SceneState& state);

    /// Call after each advance(): updates deformed and appeared objects, and lists added ones.
    void update(const scene::SceneState& state);

    /// Whether it has opaque or alpha-tested triangles. Depends on the scene only.
    bool casts(scene::ObjectId object) const { return casts_[object]; }
    /// In object space (object_matrix() transforms it to world space).
    const Box3& box(scene::ObjectId object) const;
    /// The texels of a view that a caster covers if it is present (SceneState::object_there); empty for others.
    Rect footprint(const ViewProjection& view, const scene::SceneState& state, scene::ObjectId object) const;
    /// The range of its distances from the light.
    DistanceRange distance(const ViewProjection& view, const scene::SceneState& state, scene::ObjectId object) const
    {
        return distance_range(view, state.object_matrix(object), box(object));
    }

 private:
    void measure(const scene::SceneState& state, scene::ObjectId object);
    void list_new(const scene::SceneState& state);

    std::shared_ptr<const scene::Scene> scene_;
    std::vector<char> casts_, mesh_casts_;
    std::vector<Box3> mesh_box_;
    std::vector<std::uint32_t> deformed_slot_;   // by object; none for rigid objects
    std::vector<Box3> deformed_box_;
};

}   // namespace gnomon::light_views
