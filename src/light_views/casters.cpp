// SPDX-License-Identifier: Apache-2.0
#include "light_views/casters.h"

namespace gnomon::light_views {

Casters::Casters(const scene::SceneState& state) : scene_(state.shared_scene())
{
    list_new(state);
}

// Lists the meshes and objects that are not listed yet.
void Casters::list_new(const scene::SceneState& state)
{
    for (std::size_t m = mesh_box_.size(); m < scene_->meshes.size(); ++m) {
        const scene::Mesh& mesh = scene_->meshes[m];
        mesh_box_.push_back(mesh.bounds());
        bool casts = false;
        for (const scene::MeshPart& part : mesh.parts)
            casts |= part.triangle_count > 0 &&
                     scene_->materials[part.material].surface_class() != scene::SurfaceClass::transparent;
        mesh_casts_.push_back(casts);
    }
    for (std::size_t o = casts_.size(); o < scene_->objects.size(); ++o) {
        const scene::Object& object = scene_->objects[o];
        casts_.push_back(mesh_casts_[object.mesh]);
        deformed_slot_.push_back(scene::none);
        if (!object.deforming) continue;
        deformed_slot_[o] = static_cast<std::uint32_t>(deformed_box_.size());
        deformed_box_.emplace_back();
        measure(state, static_cast<scene::ObjectId>(o));
    }
}

void Casters::update(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    if (!changes.added.empty()) list_new(state);
    for (const auto* list : {&changes.added, &changes.deformed, &changes.appeared})
        for (const scene::ObjectId object : *list)
            if (deformed_slot_[object] != scene::none) measure(state, object);
}

void Casters::measure(const scene::SceneState& state, scene::ObjectId object)
{
    Box3 box;
    for (const glm::vec3& p : state.deformed(object).positions) box.add(p);
    deformed_box_[deformed_slot_[object]] = box;
}

const Box3& Casters::box(scene::ObjectId object) const
{
    const std::uint32_t slot = deformed_slot_[object];
    return slot == scene::none ? mesh_box_[scene_->objects[object].mesh] : deformed_box_[slot];
}

Rect Casters::footprint(const ViewProjection& view, const scene::SceneState& state, scene::ObjectId object) const
{
    if (!casts_[object] || !state.object_there(object)) return {};
    return light_views::footprint(view, state.object_matrix(object), box(object));
}

}   // namespace gnomon::light_views
