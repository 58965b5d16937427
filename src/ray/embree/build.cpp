// SPDX-License-Identifier: Apache-2.0
// Constructs a RayScene: distributes the triangles among the static scene and the solids of the dynamic scene.
#include <algorithm>
#include <unordered_map>

#include "base/interruption.h"
#include "ray/embree/impl.h"
#include "ray/embree/packets.h"

namespace gnomon::ray {

namespace {

// A mesh that so many static objects share, with at least so many triangles in all instances together, is stored once
// and instanced. Below these limits, flattened copies trace faster than instances.
constexpr std::size_t k_instancing_copies = 8;
constexpr std::size_t k_instancing_triangles = 1u << 20;

// The matrices that take the nodes of a rigid group to the space of its anchor. Each is multiplied once, however long
// the chains are.
class ToAnchor {
 public:
    ToAnchor(const std::vector<scene::Node>& nodes, scene::NodeId anchor) : nodes_(nodes)
    {
        known_.emplace(anchor, glm::dmat4(1));
    }

    const glm::dmat4& of(scene::NodeId node)
    {
        chain_.clear();
        for (; !known_.contains(node); node = nodes_[node].parent) chain_.push_back(node);
        const glm::dmat4* matrix = &known_.at(node);
        for (auto below = chain_.rbegin(); below != chain_.rend(); ++below)
            matrix = &known_.emplace(*below, *matrix * nodes_[*below].local).first->second;
        return *matrix;
    }

 private:
    const std::vector<scene::Node>& nodes_;
    std::unordered_map<scene::NodeId, glm::dmat4> known_;
    std::vector<scene::NodeId> chain_;
};

}   // namespace

glm::mat3 normal_matrix(const glm::mat4& m)
{
    const glm::mat3 linear(m);
    const glm::mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                             glm::cross(linear[0], linear[1]));
    return glm::determinant(linear) < 0 ? -1.0f * cofactor : cofactor;
}

bool mirrors(const glm::dmat4& m)
{
    return glm::determinant(glm::dmat3(m)) < 0;
}

Meeting meeting_by(const glm::mat4& m)
{
    if (!has_volume(m)) return Meeting::never;
    return stray_of(m) <= k_true_stray ? Meeting::truly : Meeting::roughly;
}

SceneHandle RayScene::Impl::new_scene(RTCBuildQuality quality, unsigned flags) const
{
    SceneHandle handle(rtcNewScene(device.get()));
    rtcSetSceneFlags(handle.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));
    rtcSetSceneBuildQuality(handle.get(), quality);
    return handle;
}

void RayScene::Impl::build(const scene::SceneState& state)
{
    scene = state.shared_scene();
    width = packet_width();
    thins_light = std::any_of(scene->materials.begin(), scene->materials.end(), scene::thins_light);
    geometry.resize(scene->objects.size());
    still_ids.resize(scene->objects.size());
    solid_of_group.assign(scene->groups.size(), scene::none);
    solid_of_object.assign(scene->objects.size(), scene::none);
    still = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    moving = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);

    // Decide which static meshes are worth keeping once: as the clip has them, so that a promoted object does not
    // change how the others are stored.
    std::vector<std::size_t> copies(scene->meshes.size(), 0);
    for (const scene::Object& object : scene->objects) copies[object.mesh] += !object.dynamic;
    const auto instanced = [&](const scene::Object& object) {
        const std::size_t n = copies[object.mesh];
        return !object.deforming && n >= k_instancing_copies &&
               n * scene->meshes[object.mesh].triangles.size() >= k_instancing_triangles &&
               meeting_by(glm::mat4(state.world(object.node))) == Meeting::truly;   // singular ones are flattened
    };

    // Add dynamic objects first, because the margins of all depend on them: those of the clip, then those that the user
    // took, in the order in which an updated scene has them.
    measure_still(state);
    for (scene::GroupId g = 0; g < scene->groups.size(); ++g)
        if (!scene->groups[g].objects.empty()) add_group(state, g);
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o) {
        const scene::Object& object = scene->objects[o];
        if (object.dynamic && !object.removed && object.group == scene::none) add_alone(state, o);
    }
    for (const scene::ObjectId o : state.taken_objects()) add_alone(state, o);
    note_all_reaches();

    // Add flattened objects first, because their geometry ids are the indices of the records.
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
        if (!state.is_dynamic(o) && !instanced(scene->objects[o])) add_still(state, o);
    first_instance = static_cast<unsigned>(still_records.size());
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
        if (!state.is_dynamic(o) && instanced(scene->objects[o])) add_still_instance(state, o);
    measure_thin(state);
    finish_shared();
    commit_still();
    device.check();

    const float reach = present_reach();
    for (std::uint32_t s = 0; s < solids.size(); ++s) {
        solids[s].margin = margin_of(std::max(reach, solids[s].reach), solids[s].to_world);
        finish(s, state);
    }
    number_instances();
    commit_moving();
    device.check();
}

// Builds a solid's BLAS, or the one of a shared mesh.
void RayScene::Impl::commit(Solid& solid, bool follow)
{
    if (!portable)
        device.commit(solid.tree.get());
    else if (follow)
        solid.portable.refit();
    else
        solid.portable.build(solid.records);
}

void RayScene::Impl::commit_still()
{
    if (portable)
        commit_portable_still();
    else
        device.commit(still.get());
}

void RayScene::Impl::commit_moving()
{
    if (portable)
        commit_portable_moving();
    else
        device.commit(moving.get());
}

// Returns an empty place for a solid.
std::uint32_t RayScene::Impl::new_solid()
{
    if (free_solids.empty()) {
        solids.emplace_back();
        return static_cast<std::uint32_t>(solids.size() - 1);
    }
    const std::uint32_t s = free_solids.back();
    free_solids.pop_back();
    return s;
}

// Attaches the instances of all solids in the order of their nodes, so that the dynamic scene does not depend on the
// order in which its parts were added.
void RayScene::Impl::number_instances()
{
    struct Place {
        scene::NodeId node;
        bool alone;   // an object by itself, which may lie on the anchor of a group
        std::uint32_t solid;
        auto operator<=>(const Place&) const = default;
    };
    std::vector<Place> places;
    for (std::uint32_t s = 0; s < solids.size(); ++s) {
        const Solid& solid = solids[s];
        if (!solid.is_there()) continue;
        const bool alone = !solid.objects.empty() && solid_of_object[solid.objects.front()] == s;
        places.push_back({alone ? scene->objects[solid.objects.front()].node : solid.anchor, alone, s});
    }
    std::sort(places.begin(), places.end());
    for (unsigned id = 0; id < places.size(); ++id) {
        Solid& solid = solids[places[id].solid];
        if (solid.id == id || solid.id == RTC_INVALID_GEOMETRY_ID) continue;
        rtcDetachGeometry(moving.get(), solid.id);
        solid.id = RTC_INVALID_GEOMETRY_ID;
    }
    solid_of_instance.clear();
    for (unsigned id = 0; id < places.size(); ++id) {
        Solid& solid = solids[places[id].solid];
        if (solid.id == RTC_INVALID_GEOMETRY_ID) rtcAttachGeometryByID(moving.get(), solid.instance.get(), id);
        solid.id = id;
        solid_of_instance.push_back(places[id].solid);
    }
}

// Finds the largest coordinate of the static objects.
void RayScene::Impl::measure_still(const scene::SceneState& state)
{
    still_reach = 0;
    std::vector<Box3> mesh_box(scene->meshes.size());
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o) {
        if (state.is_dynamic(o)) continue;
        const scene::Object& object = scene->objects[o];
        Box3& box = mesh_box[object.mesh];
        if (box.empty()) box = scene->meshes[object.mesh].bounds();
        const float reach = reach_of(box, glm::mat4(state.world(object.node)));
        if (reach <= k_largest_coordinate) still_reach = std::max(still_reach, reach);
    }
}

// Finds a box around the static objects that thin light. Those that are promoted later leave it too large.
void RayScene::Impl::measure_thin(const scene::SceneState& state)
{
    thin_box = {};
    if (!thins_light) return;
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o) {
        if (state.is_dynamic(o) || !geometry[o].mesh) continue;
        const scene::Mesh& mesh = *geometry[o].mesh;
        if (std::ranges::none_of(mesh.parts, [&](const scene::MeshPart& part) {
                return scene::thins_light(scene->materials[part.material]);
            }))
            continue;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            glm::vec3 p[3];
            geometry[o].corners(t, p);
            for (const glm::vec3& corner : p) thin_box.add(corner);
        }
    }
    if (thin_box.empty()) return;
    // More than intersections deviate by rounding.
    constexpr float k_room = 1e-3f;
    const glm::vec3 reach = glm::max(glm::abs(thin_box.low), glm::abs(thin_box.high)) + thin_box.size();
    const float room = k_room * std::max({reach.x, reach.y, reach.z});
    thin_box.low -= room, thin_box.high += room;
}

void RayScene::Impl::bake(BakedVertices& vertices, const scene::Mesh& mesh, const glm::dmat4& matrix)
{
    interruption_point();
    vertices.bake(mesh.positions, mesh.normals, mesh.tangents, matrix);
    baked_bytes += vertices.bytes();
    device.limit().check(device.bytes() + baked_bytes, "the vertices of the ray tracing trees");
}

// Fills an object's ObjectGeometry.
void RayScene::Impl::describe(scene::ObjectId object, const BakedVertices& vertices, const Solid* solid, bool mirrored)
{
    ObjectGeometry& g = geometry[object];
    g.mesh = &scene->meshes[scene->objects[object].mesh];
    g.positions = vertices.positions.data();
    g.normals = vertices.normals.empty() ? nullptr : vertices.normals.data();
    g.tangents = vertices.tangents.empty() ? nullptr : vertices.tangents.data();
    g.to_world = solid ? &solid->to_world : nullptr;
    g.normal_to_world = solid ? &solid->normal_to_world : nullptr;
    g.mirrored = mirrored;
    g.axis = vertices.axis;
}

void RayScene::Impl::add_still(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    const glm::dmat4& world = state.world(object.node);
    BakedVertices& vertices = still_vertices.emplace_back();
    if (object.deforming) {   // a constant morph
        const scene::DeformedMesh& shape = state.deformed(o);
        vertices.bake(shape.positions, shape.normals, shape.tangents,
                      object.skin != scene::none ? glm::dmat4(1) : world);
        baked_bytes += vertices.bytes();
    } else {
        bake(vertices, mesh, world);
    }
    const bool mirrored = mirrors(world);
    describe(o, vertices, nullptr, mirrored);
    statistics.static_triangles += mesh.triangles.size();
    if (!state.object_visible(o)) return;
    const auto first = static_cast<unsigned>(still_records.size());
    attach_object(device.get(), embree_scene(still), *scene, o, vertices, mirrored, still_records);
    for (auto id = first; id < still_records.size(); ++id) still_ids[o].push_back(id);
}

void RayScene::Impl::add_still_instance(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    std::unique_ptr<Solid>& shared = shared_meshes[object.mesh];
    if (!shared) {
        shared = std::make_unique<Solid>();
        shared->tree = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
        bake(shared->vertices.emplace_back(), mesh, glm::dmat4(1));
        attach_object(device.get(), embree_scene(shared->tree), *scene, o, shared->vertices.front(), false,
                      shared->records);
        shared->box = box_of(shared->vertices.front().positions, mesh);
    }
    const glm::dmat4& world = state.world(object.node);
    const unsigned id = first_instance + static_cast<unsigned>(still_instances.size());
    Placed& placed = still_instances.emplace_back();
    placed = {o, false, shared.get(), glm::mat4(world), normal_matrix(glm::mat4(world))};
    describe(o, shared->vertices.front(), nullptr, mirrors(world));
    geometry[o].to_world = &placed.to_world;
    geometry[o].normal_to_world = &placed.normal_to_world;
    statistics.static_triangles += mesh.triangles.size();
    if (has_volume(placed.to_world) && state.object_visible(o)) still_ids[o].push_back(id);
}

// Builds the BLASes of shared meshes, whose margins depend on all instances, and adds the instances.
void RayScene::Impl::finish_shared()
{
    shared_reach = reach_of_shared();
    for (const auto& [mesh, shared] : shared_meshes) {
        shared->margin = shared_margin(*shared);
        shared->attach_margin(device.get());
        commit(*shared);
    }
    if (portable) return;
    for (const Placed& placed : still_instances)
        for (const unsigned id : still_ids[placed.object]) {
            const GeometryHandle instance(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
            rtcSetGeometryInstancedScene(instance.get(), placed.shared->tree.get());
            rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &placed.to_world);
            rtcSetGeometryMask(instance.get(), k_mask_all);
            rtcCommitGeometry(instance.get());
            rtcAttachGeometryByID(still.get(), instance.get(), id);
        }
}

// The objects of a rigid group share a BLAS, in the space of the group's anchor.
void RayScene::Impl::add_group(const scene::SceneState& state, scene::GroupId g)
{
    const scene::RigidGroup& group = scene->groups[g];
    solid_of_group[g] = new_solid();
    Solid& solid = solids[solid_of_group[g]];
    solid.anchor = group.anchor;
    solid.tree = new_scene(RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE);
    ToAnchor to_anchor(scene->nodes, group.anchor);
    for (const scene::ObjectId o : group.objects) {
        if (state.group_of(o) != g) continue;
        const glm::dmat4& relative = to_anchor.of(scene->objects[o].node);
        const scene::Mesh& mesh = scene->meshes[scene->objects[o].mesh];
        BakedVertices& vertices = solid.vertices.emplace_back();
        bake(vertices, mesh, relative);
        attach_object(device.get(), embree_scene(solid.tree), *scene, o, vertices, mirrors(relative), solid.records);
        describe(o, vertices, &solid, mirrors(relative));
        solid.box.add(box_of(vertices.positions, mesh));
        solid.objects.push_back(o);
    }
    solid.to_world = glm::mat4(state.world(solid.anchor));
    measure(solid, state);
}

// Deforming meshes are built in their rest shape and refitted, so that the tree does not depend on the first frame. (A
// geometry of quality `refit` is built when it is committed for the first time.)
void RayScene::Impl::add_alone(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    solid_of_object[o] = new_solid();
    Solid& solid = solids[solid_of_object[o]];
    solid.anchor = object.skin != scene::none ? scene::none : object.node;
    solid.deforming = object.deforming;
    solid.objects.push_back(o);
    BakedVertices& vertices = solid.vertices.emplace_back();
    bake(vertices, mesh, glm::dmat4(1));
    solid.has_points_at_rest = solid.sorted_anew = object.deforming && has_points(vertices.positions, mesh);
    make_tree_of_one(solid);
    describe(o, vertices, &solid, false);
    solid.box = box_of(object.deforming ? state.deformed(o).positions : vertices.positions, mesh);
    solid.to_world = solid.anchor == scene::none ? glm::mat4(1) : glm::mat4(state.world(solid.anchor));
    measure(solid, state);
}

// Makes the BLAS of a solid with one object; the caller commits it. If the object deforms, the BLAS is refitted from
// frame to frame, unless its shape forbids that (has_points()).
void RayScene::Impl::make_tree_of_one(Solid& solid)
{
    const bool refitted = solid.deforming && !solid.sorted_anew;
    solid.margin_geometry = {};
    solid.tree = new_scene(refitted ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM,
                           refitted ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE);
    solid.records.clear();
    attach_object(device.get(), embree_scene(solid.tree), *scene, solid.objects.front(), solid.vertices.front(), false,
                  solid.records, refitted ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_MEDIUM);
}

// Measures what the margins of other solids depend on.
void RayScene::Impl::measure(Solid& solid, const scene::SceneState& state)
{
    solid.visible = !solid.objects.empty() && state.object_visible(solid.objects.front());
    solid.meeting = meeting_by(solid.to_world);
    solid.has_volume = solid.meeting != Meeting::never;
    solid.reach = reach_of(solid.box, solid.to_world);
}

// Builds a solid's BLAS, whose margin depends on all solids, and places it.
void RayScene::Impl::finish(std::uint32_t s, const scene::SceneState& state)
{
    Solid& solid = solids[s];
    solid.attach_margin(device.get());
    commit(solid);
    if (solid.deforming) refit(solid, state);
    solid.instance = GeometryHandle(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(solid.instance.get(), solid.tree.get());
    rtcSetGeometryMask(solid.instance.get(), k_mask_all);
    place(solid, state);
    show(solid, solid.visible);
}

void RayScene::Impl::build_one_tree()
{
    if (portable) return build_portable_one();
    one = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    unsigned past_still = 0;
    for (const std::vector<unsigned>& ids : still_ids)
        for (const unsigned id : ids) {
            rtcAttachGeometryByID(one.get(), rtcGetGeometry(still.get(), id), id);
            past_still = std::max(past_still, id + 1);
        }
    for (unsigned id = 0; id < solid_of_instance.size(); ++id)
        rtcAttachGeometryByID(one.get(), solids[solid_of_instance[id]].instance.get(), past_still + id);
    device.commit(one.get());
    device.check();
}

}   // namespace gnomon::ray
