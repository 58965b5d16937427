// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which objects cast shadows, and the box each is in now.
//
// Boxes of rigid objects are their mesh's, made once; those of deforming ones are made again when they deform. Cost a
// frame: the vertices of what deformed.

#include <span>
#include <vector>

#include "light_views/projection.h"

namespace gnomon::light_views {

class Casters {
 public:
    explicit Casters(const scene::SceneState& state);

    /// Follows one advance(): deformed and appeared objects.
    void update(const scene::SceneState& state);

    /// Whether it has triangles that block light: opaque or alpha-tested ones. Depends on the scene alone.
    bool casts(scene::ObjectId object) const { return casts_[object]; }
    /// In the space that object_matrix() takes to the world.
    const Box3& box(scene::ObjectId object) const;
    /// Where a caster that is there (SceneState::object_there) falls in a view; empty for others.
    Rect footprint(const ViewProjection& view, const scene::SceneState& state, scene::ObjectId object) const;
    /// How far from the light it is.
    DistanceRange distance(const ViewProjection& view, const scene::SceneState& state, scene::ObjectId object) const
    {
        return distance_range(view, state.object_matrix(object), box(object));
    }

 private:
    void measure(const scene::SceneState& state, scene::ObjectId object);

    const scene::Scene* scene_;
    std::vector<char> casts_;
    std::vector<Box3> mesh_box_;
    std::vector<std::uint32_t> deformed_slot_;   // by object; none for rigid ones
    std::vector<Box3> deformed_box_;
};

}   // namespace gnomon::light_views
