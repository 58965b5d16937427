// SPDX-License-Identifier: Apache-2.0
// Follows the scene from frame to frame: places instances that moved, refits meshes that deformed, and rebuilds the
// TLAS of the dynamic scene.
#include <algorithm>
#include <iterator>

#include "ray/embree/impl.h"

namespace gnomon::ray {

void RayScene::Impl::update(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    ++updates;
    touched.clear();
    const auto touch = [&](std::uint32_t s) -> Solid& {
        Solid& solid = solids[s];
        if (solid.touched_at != updates) touched.push_back(s);
        solid.touched_at = updates;
        return solid;
    };

    const bool edited = follow_edit(state), regrouped = follow_overrides(state) || edited;
    if (regrouped) number_instances();

    // Place what moved. An object that appears may have moved while it was hidden.
    for (const scene::GroupId g : changes.groups_moved) place(touch(solid_of_group[g]), state);
    for (const auto* list : {&changes.moved, &changes.appeared})
        for (const scene::ObjectId o : *list)
            if (solid_of_object[o] != scene::none) place(touch(solid_of_object[o]), state);

    // Refit what deformed.
    for (const scene::ObjectId o : changes.deformed)
        if (solid_of_object[o] != scene::none) refit(touch(solid_of_object[o]), state);

    for (const scene::ObjectId o : changes.vanished)
        if (const std::uint32_t s = solid_of(o); s != scene::none) show(touch(s), false);
    for (const scene::ObjectId o : changes.appeared)
        if (const std::uint32_t s = solid_of(o); s != scene::none) show(touch(s), true);

    // Rebuild the TLAS of the dynamic scene, and nothing else.
    statistics.touched = touched.size();
    if (statistics.touched > 0 || regrouped) follow_margins(regrouped);
    if (statistics.touched > 0 || edited) commit_moving();
    if (!portable_one_scene.instances().empty() || (one.get() && regrouped))
        build_one_tree();
    else if (one.get() && statistics.touched > 0)
        device.commit(one.get());
    device.check();
}

void RayScene::Impl::refit(Solid& solid, const scene::SceneState& state)
{
    const scene::DeformedMesh& shape = state.deformed(solid.objects.front());
    const scene::Mesh& mesh = *geometry[solid.objects.front()].mesh;
    BakedVertices& vertices = solid.vertices.front();
    baked_bytes -= vertices.bytes();   // counted again below
    if (const bool anew = solid.has_points_at_rest || has_points(shape.positions, mesh); anew != solid.sorted_anew) {
        solid.sorted_anew = anew;
        vertices.bake(mesh.positions, mesh.normals, mesh.tangents,
                      glm::dmat4(1));   // refitting starts from the rest shape again
        make_tree_of_one(solid);
        solid.attach_margin(device.get());
        if (!anew && !portable) device.commit(solid.tree.get());
        if (solid.instance.get()) rtcSetGeometryInstancedScene(solid.instance.get(), solid.tree.get());
    }
    std::copy(shape.positions.begin(), shape.positions.end(), vertices.positions.begin());
    vertices.normals = shape.normals;
    vertices.tangents = shape.tangents;
    baked_bytes += vertices.bytes();
    describe(solid.objects.front(), vertices, &solid, solid.mirrored);
    for (unsigned id = 0; id < solid.records.size() && !portable; ++id) {
        RTCGeometry part = rtcGetGeometry(solid.tree.get(), id);
        rtcUpdateGeometryBuffer(part, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(part);
    }
    solid.box = box_of(shape.positions, mesh);
    solid.reach = reach_of(solid.box, solid.to_world);
    solid.set_margin(solid.margin);
    // A refitted tree with vertices that are not finite has an invalid box, which must not enter the TLAS.
    if (can_be_met(shape.positions))
        rtcEnableGeometry(solid.margin_geometry.get());
    else
        rtcDisableGeometry(solid.margin_geometry.get());
    commit(solid, true);
    if (solid.instance.get()) rtcCommitGeometry(solid.instance.get());
}

void RayScene::Impl::place(Solid& solid, const scene::SceneState& state)
{
    solid.to_world = solid.anchor == scene::none ? glm::mat4(1) : glm::mat4(state.world(solid.anchor));
    solid.normal_to_world = normal_matrix(solid.to_world);
    if (const bool mirrored = mirrors(solid.to_world); mirrored != solid.mirrored) {
        solid.mirrored = mirrored;
        for (const scene::ObjectId o : solid.objects) geometry[o].mirrored = !geometry[o].mirrored;
    }
    solid.reach = reach_of(solid.box, solid.to_world);
    solid.meeting = meeting_by(solid.to_world);
    solid.has_volume = solid.meeting != Meeting::never;
    if (solid.has_volume)
        rtcSetGeometryTransform(solid.instance.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &solid.to_world);
    show(solid, solid.visible);
    rtcCommitGeometry(solid.instance.get());
}

void RayScene::Impl::show(Solid& solid, bool visible)
{
    solid.visible = visible;
    const bool enable = visible && solid.has_volume;
    if (enable == solid.enabled) return;
    solid.enabled = enable;
    if (enable)
        rtcEnableGeometry(solid.instance.get());
    else
        rtcDisableGeometry(solid.instance.get());
}

std::uint32_t RayScene::Impl::solid_of(scene::ObjectId o) const
{
    if (scene->objects[o].removed) return scene::none;
    if (solid_of_object[o] != scene::none) return solid_of_object[o];
    const scene::GroupId g = scene->objects[o].group;
    return g != scene::none ? solid_of_group[g] : scene::none;
}

// Removes and adds the solids of objects that were removed and added.
// @return whether there were any
bool RayScene::Impl::follow_edit(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    if (changes.added.empty() && changes.removed.empty()) return false;
    for (const scene::ObjectId o : changes.removed) remove(o);
    geometry.resize(scene->objects.size());
    still_ids.resize(scene->objects.size());
    solid_of_group.resize(scene->groups.size(), scene::none);
    solid_of_object.resize(scene->objects.size(), scene::none);
    std::vector<std::uint32_t> fresh;
    for (const scene::ObjectId o : changes.added) {
        const scene::GroupId g = scene->objects[o].group;
        if (g == scene::none) {
            add_alone(state, o);
            fresh.push_back(solid_of_object[o]);
        } else if (solid_of_group[g] == scene::none) {
            add_group(state, g);
            fresh.push_back(solid_of_group[g]);
        }
    }
    note_all_reaches();
    const float reach = present_reach();
    for (const std::uint32_t s : fresh) {
        solids[s].margin = margin_of(std::max(reach, solids[s].reach), solids[s].to_world);
        finish(s, state);
    }
    return true;
}

// Removes the solid of an object, and with it those of its group, which are removed as well.
void RayScene::Impl::remove(scene::ObjectId o)
{
    geometry[o] = {};
    const scene::GroupId g = scene->objects[o].group;
    std::uint32_t& s = solid_of_object[o] != scene::none || g == scene::none ? solid_of_object[o] : solid_of_group[g];
    if (s == scene::none) return;
    Solid& solid = solids[s];
    rtcDetachGeometry(moving.get(), solid.id);
    for (const BakedVertices& vertices : solid.vertices) baked_bytes -= vertices.bytes();
    solid = {};
    free_solids.push_back(s);
    s = scene::none;
}

// Gives objects that were promoted, or separated from their group, solids of their own, permanently.
// @return whether there were any
bool RayScene::Impl::follow_overrides(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    std::vector<scene::ObjectId> objects;
    std::merge(changes.promoted.begin(), changes.promoted.end(), changes.separated.begin(), changes.separated.end(),
               std::back_inserter(objects));
    bool still_changed = false, any = false;
    for (const scene::ObjectId o : objects) {
        if (solid_of_object[o] != scene::none) continue;   // this scene was built after the step that moved it
        if (const scene::GroupId g = scene->objects[o].group; g != scene::none) {
            separate(o, solids[solid_of_group[g]]);
        } else {
            for (const unsigned id : still_ids[o]) {
                if (!portable) rtcDetachGeometry(still.get(), id);
                if (id < first_instance) {
                    still_records[id].attached = false;
                    continue;
                }
                still_instances[id - first_instance].taken = true;
                shared_taken = true;
            }
            still_ids[o].clear();
            statistics.static_triangles -= geometry[o].mesh->triangles.size();
            still_changed = true;
        }
        add_alone(state, o);
        finish(solid_of_object[o], state);
        any = true;
    }
    if (still_changed) {
        measure_still(state);
        commit_still();
    }
    return any;
}

// Takes an object out of the BLAS of its group, which is then as if it had never been there.
void RayScene::Impl::separate(scene::ObjectId object, Solid& group)
{
    for (unsigned id = 0; id < group.records.size(); ++id)
        if (group.records[id].object == object) {
            if (!portable) rtcDetachGeometry(group.tree.get(), id);
            group.records[id].attached = false;
        }
    std::erase(group.objects, object);
    group.box = {};
    for (const BakedVertices& vertices : group.vertices)
        for (const scene::ObjectId o : group.objects)
            if (geometry[o].positions == vertices.positions.data())
                group.box.add(box_of(vertices.positions, *geometry[o].mesh));
    group.reach = reach_of(group.box, group.to_world);
    group.set_margin(group.margin);
    commit(group);
    if (group.objects.empty()) show(group, false);
    rtcCommitGeometry(group.instance.get());
}

}   // namespace gnomon::ray
