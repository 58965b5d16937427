// SPDX-License-Identifier: Apache-2.0
#include "ray/ray_scene.h"

#include <algorithm>
#include <chrono>
#include <unordered_map>

#include "base/check.h"
#include "ray/packets.h"
#include "ray/solid.h"

namespace gnomon::ray {

namespace {

// A mesh that this many static objects share, with at least so many triangles in all, is kept once and instanced;
// below, flattened copies trace faster than instances.
constexpr std::size_t k_instancing_copies = 8;
constexpr std::size_t k_instancing_triangles = 1u << 20;

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

// A tree of its own, placed in one of the two scenes by an instance.
struct Solid {
    SceneHandle tree;
    GeometryHandle instance;
    std::deque<GeometryRecord> records;   // by geometry id
    std::deque<BakedVertices> vertices;
    std::vector<scene::ObjectId> objects;
    glm::mat4 to_world{1};
    glm::mat3 normal_to_world{1};
    bool shown = true;
    bool mirrored = false;                // by to_world
    scene::NodeId anchor = scene::none;   // whose world matrix places it; none: a skin, already in the world
    bool deforming = false;
};

}   // namespace

struct RayScene::Inside {
    EmbreeDevice device;
    std::shared_ptr<const scene::Scene> scene;
    int width = 8;

    // Everything static.
    SceneHandle still;
    std::deque<GeometryRecord> still_records;   // by geometry id
    std::deque<BakedVertices> still_vertices;
    std::unordered_map<scene::MeshId, std::unique_ptr<Solid>> shared_meshes;
    std::deque<glm::mat4> still_matrices;
    std::deque<glm::mat3> still_normal_matrices;
    std::deque<GeometryRecord> still_instances;   // by geometry id - first_instance: object of each instance
    unsigned first_instance = 0;
    std::vector<std::vector<unsigned>> still_ids;   // by object: its geometry ids in `still`

    // What moves.
    SceneHandle moving;
    std::deque<Solid> solids;   // by instance id in `moving`
    std::vector<std::uint32_t> solid_of_group, solid_of_object;

    SceneHandle one;                              // both, for comparison; mostly absent

    std::vector<ObjectGeometry> geometry;
    Box3 bounds;
    RaySceneStatistics statistics;

    void build(const scene::SceneState& state);
    void add_still(const scene::SceneState& state, scene::ObjectId object);
    void add_still_instance(const scene::SceneState& state, scene::ObjectId object);
    void add_group(const scene::SceneState& state, scene::GroupId group);
    void add_alone(const scene::SceneState& state, scene::ObjectId object);
    void place_new(Solid& solid, const scene::SceneState& state);
    void place(Solid& solid, const scene::SceneState& state);
    void show(Solid& solid, bool shown);
    void refit(Solid& solid, const scene::SceneState& state);
    void lift_out(const scene::SceneState& state, scene::ObjectId object);
    void describe(scene::ObjectId object, const BakedVertices& vertices, const Solid* solid, bool mirrored);
    SceneHandle new_scene(RTCBuildQuality quality, unsigned flags) const;
    const GeometryRecord& record(unsigned geometry_id, unsigned instance, bool in_moving) const;
};

RayScene::RayScene(const scene::SceneState& state) : inside_(std::make_unique<Inside>())
{
    const auto start = std::chrono::steady_clock::now();
    inside_->build(state);
    inside_->statistics.build_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

RayScene::~RayScene() = default;

SceneHandle RayScene::Inside::new_scene(RTCBuildQuality quality, unsigned flags) const
{
    SceneHandle handle(rtcNewScene(device.get()));
    rtcSetSceneFlags(handle.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));
    rtcSetSceneBuildQuality(handle.get(), quality);
    return handle;
}

void RayScene::Inside::build(const scene::SceneState& state)
{
    scene = state.shared_scene();
    width = packet_width();
    geometry.resize(scene->objects.size());
    still_ids.resize(scene->objects.size());
    solid_of_group.assign(scene->groups.size(), scene::none);
    solid_of_object.assign(scene->objects.size(), scene::none);
    still = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    moving = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);

    // Decide which static meshes are worth keeping once.
    std::vector<std::size_t> copies(scene->meshes.size(), 0);
    for (const scene::Object& object : scene->objects) copies[object.mesh] += !object.dynamic;
    const auto instanced = [&](const scene::Object& object) {
        const std::size_t n = copies[object.mesh];
        return !object.deforming && n >= k_instancing_copies &&
               n * scene->meshes[object.mesh].triangles.size() >= k_instancing_triangles;
    };

    // Flattened objects first: their geometry ids are the records' indices.
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
        if (!scene->objects[o].dynamic && !instanced(scene->objects[o])) add_still(state, o);
    first_instance = static_cast<unsigned>(still_records.size());
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
        if (!scene->objects[o].dynamic && instanced(scene->objects[o])) add_still_instance(state, o);
    device.commit(still.get());
    device.check();

    for (scene::GroupId g = 0; g < scene->groups.size(); ++g) add_group(state, g);
    for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
        if (scene->objects[o].dynamic && scene->objects[o].group == scene::none) add_alone(state, o);
    device.commit(moving.get());
    device.check();

    RTCBounds box;
    for (const SceneHandle* part : {&still, &moving}) {
        rtcGetSceneBounds(part->get(), &box);
        if (!(box.lower_x <= box.upper_x)) continue;
        bounds.add(glm::vec3(box.lower_x, box.lower_y, box.lower_z));
        bounds.add(glm::vec3(box.upper_x, box.upper_y, box.upper_z));
    }
    statistics.instances = solids.size();
}

// What shading needs to know about an object.
void RayScene::Inside::describe(scene::ObjectId object, const BakedVertices& vertices, const Solid* solid,
                                bool mirrored)
{
    ObjectGeometry& g = geometry[object];
    g.mesh = &scene->meshes[scene->objects[object].mesh];
    g.positions = vertices.positions.data();
    g.normals = vertices.normals.empty() ? nullptr : vertices.normals.data();
    g.tangents = vertices.tangents.empty() ? nullptr : vertices.tangents.data();
    g.to_world = solid ? &solid->to_world : nullptr;
    g.normal_to_world = solid ? &solid->normal_to_world : nullptr;
    g.mirrored = mirrored;
}

void RayScene::Inside::add_still(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    const glm::dmat4& world = state.world(object.node);
    BakedVertices& vertices = still_vertices.emplace_back();
    if (object.deforming) {   // a morph that stands still
        const scene::DeformedMesh& shape = state.deformed(o);
        vertices.bake(shape.positions, shape.normals, shape.tangents,
                      object.skin != scene::none ? glm::dmat4(1) : world);
    } else {
        vertices.bake(mesh.positions, mesh.normals, mesh.tangents, world);
    }
    const bool mirrored = mirrors(world);
    describe(o, vertices, nullptr, mirrored);
    statistics.static_triangles += mesh.triangles.size();
    if (!state.object_visible(o)) return;
    const auto first = static_cast<unsigned>(still_records.size());
    attach_object(device.get(), still.get(), *scene, o, vertices, mirrored, still_records);
    for (auto id = first; id < still_records.size(); ++id) still_ids[o].push_back(id);
}

void RayScene::Inside::add_still_instance(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    std::unique_ptr<Solid>& shared = shared_meshes[object.mesh];
    if (!shared) {
        shared = std::make_unique<Solid>();
        shared->tree = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
        shared->vertices.emplace_back().bake(mesh.positions, mesh.normals, mesh.tangents, glm::dmat4(1));
        attach_object(device.get(), shared->tree.get(), *scene, o, shared->vertices.front(), false, shared->records);
        device.commit(shared->tree.get());
    }
    const glm::dmat4& world = state.world(object.node);
    const glm::mat4& matrix = still_matrices.emplace_back(world);
    const glm::mat3& normals = still_normal_matrices.emplace_back(normal_matrix(matrix));
    describe(o, shared->vertices.front(), nullptr, mirrors(world));
    geometry[o].to_world = &matrix;
    geometry[o].normal_to_world = &normals;
    statistics.static_triangles += mesh.triangles.size();

    const unsigned id = first_instance + static_cast<unsigned>(still_instances.size());
    still_instances.push_back({scene.get(), &mesh, o, 0, false, false});
    if (!state.object_visible(o)) return;
    const GeometryHandle instance(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), shared->tree.get());
    rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &matrix);
    rtcSetGeometryMask(instance.get(), k_mask_seen | k_mask_blocks);
    rtcCommitGeometry(instance.get());
    rtcAttachGeometryByID(still.get(), instance.get(), id);
    still_ids[o].push_back(id);
}

// Objects that move as one share a tree, in the space of the node that moves them.
void RayScene::Inside::add_group(const scene::SceneState& state, scene::GroupId g)
{
    const scene::RigidGroup& group = scene->groups[g];
    solid_of_group[g] = static_cast<std::uint32_t>(solids.size());
    Solid& solid = solids.emplace_back();
    solid.anchor = group.anchor;
    solid.tree = new_scene(RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE);
    for (const scene::ObjectId o : group.objects) {
        glm::dmat4 relative(1);
        for (scene::NodeId n = scene->objects[o].node; n != group.anchor; n = scene->nodes[n].parent)
            relative = scene->nodes[n].local * relative;
        const scene::Mesh& mesh = scene->meshes[scene->objects[o].mesh];
        BakedVertices& vertices = solid.vertices.emplace_back();
        vertices.bake(mesh.positions, mesh.normals, mesh.tangents, relative);
        attach_object(device.get(), solid.tree.get(), *scene, o, vertices, mirrors(relative), solid.records);
        describe(o, vertices, &solid, mirrors(relative));
        solid.objects.push_back(o);
    }
    device.commit(solid.tree.get());
    place_new(solid, state);
}

// A deforming object, or a static one that somebody took out by hand. Deforming meshes are built in their rest shape
// and refitted, so that the tree does not depend on the frame in which it was first seen.
void RayScene::Inside::add_alone(const scene::SceneState& state, scene::ObjectId o)
{
    const scene::Object& object = scene->objects[o];
    const scene::Mesh& mesh = scene->meshes[object.mesh];
    solid_of_object[o] = static_cast<std::uint32_t>(solids.size());
    Solid& solid = solids.emplace_back();
    solid.anchor = object.skin != scene::none ? scene::none : object.node;
    solid.deforming = object.deforming;
    solid.tree = new_scene(object.deforming ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM,
                           object.deforming ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE);
    BakedVertices& vertices = solid.vertices.emplace_back();
    vertices.bake(mesh.positions, mesh.normals, mesh.tangents, glm::dmat4(1));
    attach_object(device.get(), solid.tree.get(), *scene, o, vertices, false, solid.records);
    describe(o, vertices, &solid, false);
    solid.objects.push_back(o);
    device.commit(solid.tree.get());
    if (solid.deforming) refit(solid, state);
    place_new(solid, state);
}

void RayScene::Inside::refit(Solid& solid, const scene::SceneState& state)
{
    const scene::DeformedMesh& shape = state.deformed(solid.objects.front());
    BakedVertices& vertices = solid.vertices.front();
    std::copy(shape.positions.begin(), shape.positions.end(), vertices.positions.begin());
    vertices.normals = shape.normals;
    vertices.tangents = shape.tangents;
    describe(solid.objects.front(), vertices, &solid, solid.mirrored);
    for (unsigned id = 0; id < solid.records.size(); ++id) {
        RTCGeometry part = rtcGetGeometry(solid.tree.get(), id);
        rtcSetGeometryBuildQuality(part, RTC_BUILD_QUALITY_REFIT);
        rtcUpdateGeometryBuffer(part, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(part);
    }
    device.commit(solid.tree.get());
    if (solid.instance.get()) rtcCommitGeometry(solid.instance.get());
}

void RayScene::Inside::place_new(Solid& solid, const scene::SceneState& state)
{
    solid.instance = GeometryHandle(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(solid.instance.get(), solid.tree.get());
    rtcSetGeometryMask(solid.instance.get(), k_mask_seen | k_mask_blocks);
    place(solid, state);
    rtcAttachGeometryByID(moving.get(), solid.instance.get(), static_cast<unsigned>(solids.size() - 1));
    show(solid, state.object_visible(solid.objects.front()));
}

void RayScene::Inside::place(Solid& solid, const scene::SceneState& state)
{
    solid.to_world = solid.anchor == scene::none ? glm::mat4(1) : glm::mat4(state.world(solid.anchor));
    solid.normal_to_world = normal_matrix(solid.to_world);
    const bool mirrored = glm::determinant(glm::mat3(solid.to_world)) < 0;
    if (mirrored != solid.mirrored) {
        solid.mirrored = mirrored;
        for (const scene::ObjectId o : solid.objects) geometry[o].mirrored = !geometry[o].mirrored;
    }
    rtcSetGeometryTransform(solid.instance.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &solid.to_world);
    rtcCommitGeometry(solid.instance.get());
}

void RayScene::Inside::show(Solid& solid, bool shown)
{
    if (shown == solid.shown) return;
    solid.shown = shown;
    if (shown)
        rtcEnableGeometry(solid.instance.get());
    else
        rtcDisableGeometry(solid.instance.get());
}

// Somebody moved a static object: it leaves the static scene for good.
void RayScene::Inside::lift_out(const scene::SceneState& state, scene::ObjectId o)
{
    for (const unsigned id : still_ids[o]) rtcDetachGeometry(still.get(), id);
    still_ids[o].clear();
    device.commit(still.get());
    add_alone(state, o);
}

void RayScene::update(const scene::SceneState& state)
{
    Inside& in = *inside_;
    const scene::FrameChanges& changes = state.changes();
    in.statistics.touched = 0;
    bool changed = false;
    const auto touch = [&](std::uint32_t solid) -> Solid& {
        ++in.statistics.touched;
        changed = true;
        return in.solids[solid];
    };

    for (const scene::GroupId g : changes.groups_moved) in.place(touch(in.solid_of_group[g]), state);
    for (const scene::ObjectId o : changes.moved) {
        if (in.scene->objects[o].group != scene::none) continue;   // its group's turn above
        if (in.solid_of_object[o] == scene::none) {
            in.lift_out(state, o);
            changed = true;
        } else {
            in.place(touch(in.solid_of_object[o]), state);
        }
    }
    for (const scene::ObjectId o : changes.deformed)
        if (in.solid_of_object[o] != scene::none) in.refit(touch(in.solid_of_object[o]), state);
    const auto solid_of = [&](scene::ObjectId o) {
        const scene::GroupId g = in.scene->objects[o].group;
        return g != scene::none ? in.solid_of_group[g] : in.solid_of_object[o];
    };
    for (const scene::ObjectId o : changes.vanished)
        if (const std::uint32_t s = solid_of(o); s != scene::none) in.show(touch(s), false);
    for (const scene::ObjectId o : changes.appeared)
        if (const std::uint32_t s = solid_of(o); s != scene::none) in.show(touch(s), true);

    // Rebuild the movers' small top level, and nothing else.
    if (changed) in.device.commit(in.moving.get());
    if (changed && in.one.get()) in.device.commit(in.one.get());
    in.device.check();
}

void RayScene::keep_one_tree()
{
    Inside& in = *inside_;
    in.one = in.new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    unsigned past_still = 0;
    for (const std::vector<unsigned>& ids : in.still_ids)
        for (const unsigned id : ids) {
            rtcAttachGeometryByID(in.one.get(), rtcGetGeometry(in.still.get(), id), id);
            past_still = std::max(past_still, id + 1);
        }
    for (unsigned s = 0; s < in.solids.size(); ++s)
        rtcAttachGeometryByID(in.one.get(), in.solids[s].instance.get(), past_still + s);
    in.device.commit(in.one.get());
    in.device.check();
}

const GeometryRecord& RayScene::Inside::record(unsigned geometry_id, unsigned instance, bool in_moving) const
{
    if (in_moving) return solids[instance].records[geometry_id];
    return still_records[geometry_id];
}

void RayScene::closest(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides) const
{
    const Inside& in = *inside_;
    TraceContext context(sides == Sides::front);
    const bool anything_moves = !in.solids.empty();
    RawHits still, moving;
    const auto step = static_cast<std::size_t>(in.width);
    for (std::size_t at = begin; at < end; at += step) {
        const int count = static_cast<int>(std::min(step, end - at));
        intersect_packet(in.width, in.still.get(), context, rays, at, count, nullptr, still);
        if (anything_moves) intersect_packet(in.width, in.moving.get(), context, rays, at, count, still.t, moving);
        for (int i = 0; i < count; ++i) {
            const std::size_t to = at + static_cast<std::size_t>(i);
            const bool in_moving = anything_moves && moving.geometry[i] != RTC_INVALID_GEOMETRY_ID;
            const RawHits& raw = in_moving ? moving : still;
            if (raw.geometry[i] == RTC_INVALID_GEOMETRY_ID) {
                hits.object[to] = scene::none;
                continue;
            }
            if (!in_moving && raw.instance[i] != RTC_INVALID_GEOMETRY_ID) {
                // A static instance: the object is the instance's, the triangle the shared mesh's.
                const GeometryRecord& placed = in.still_instances[raw.instance[i] - in.first_instance];
                const Solid& shared = *in.shared_meshes.at(in.scene->objects[placed.object].mesh);
                hits.object[to] = placed.object;
                hits.triangle[to] = shared.records[raw.geometry[i]].first_triangle + raw.triangle[i];
            } else {
                const GeometryRecord& record = in.record(raw.geometry[i], raw.instance[i], in_moving);
                hits.object[to] = record.object;
                hits.triangle[to] = record.first_triangle + raw.triangle[i];
            }
            hits.t[to] = raw.t[i], hits.u[to] = raw.u[i], hits.v[to] = raw.v[i];
        }
    }
}

void RayScene::blocked(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* blocked,
                       Against against) const
{
    const Inside& in = *inside_;
    TraceContext context;
    const auto step = static_cast<std::size_t>(in.width);
    alignas(64) int active[16];
    for (std::size_t at = begin; at < end; at += step) {
        const int count = static_cast<int>(std::min(step, end - at));
        for (int i = 0; i < 16; ++i) active[i] = i < count ? -1 : 0;
        if (against == Against::one_tree) {
            occlude_packet(in.width, in.one.get(), context, rays, at, count, active);
            for (int i = 0; i < count; ++i) blocked[at - begin + static_cast<std::size_t>(i)] = active[i] == 0;
            continue;
        }
        bool open = true;
        if (against != Against::dynamic_only)
            open = occlude_packet(in.width, in.still.get(), context, rays, at, count, active);
        if (open && against != Against::static_only && !in.solids.empty())
            occlude_packet(in.width, in.moving.get(), context, rays, at, count, active);
        for (int i = 0; i < count; ++i) blocked[at - begin + static_cast<std::size_t>(i)] = active[i] == 0;
    }
}

const ObjectGeometry& RayScene::geometry(scene::ObjectId object) const
{
    return inside_->geometry[object];
}

Box3 RayScene::bounds() const
{
    return inside_->bounds;
}

RaySceneStatistics RayScene::statistics() const
{
    RaySceneStatistics result = inside_->statistics;
    result.bytes = inside_->device.bytes();
    for (const BakedVertices& v : inside_->still_vertices) result.bytes += v.bytes();
    for (const Solid& solid : inside_->solids)
        for (const BakedVertices& v : solid.vertices) result.bytes += v.bytes();
    return result;
}

int RayScene::packet_width()
{
    static const int width = [] {
        const EmbreeDevice device;
        if (rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
        return rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8 : 4;
    }();
    return width;
}

// The packets' twins.

Hit RayScene::closest_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                             Sides sides) const
{
    const Inside& in = *inside_;
    TraceContext context(sides == Sides::front);
    Hit hit;
    hit.t = tfar;
    for (const bool in_moving : {false, true}) {
        RTCRayHit ray{};
        ray.ray.org_x = origin.x, ray.ray.org_y = origin.y, ray.ray.org_z = origin.z, ray.ray.tnear = tnear;
        ray.ray.dir_x = direction.x, ray.ray.dir_y = direction.y, ray.ray.dir_z = direction.z, ray.ray.tfar = hit.t;
        ray.ray.mask = k_mask_seen;
        ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1((in_moving ? in.moving : in.still).get(), &context.embree, &ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        hit.t = ray.ray.tfar, hit.u = ray.hit.u, hit.v = ray.hit.v;
        if (!in_moving && ray.hit.instID[0] != RTC_INVALID_GEOMETRY_ID) {
            const GeometryRecord& placed = in.still_instances[ray.hit.instID[0] - in.first_instance];
            const Solid& shared = *in.shared_meshes.at(in.scene->objects[placed.object].mesh);
            hit.object = placed.object;
            hit.triangle = shared.records[ray.hit.geomID].first_triangle + ray.hit.primID;
            continue;
        }
        const GeometryRecord& record = in.record(ray.hit.geomID, ray.hit.instID[0], in_moving);
        hit.object = record.object;
        hit.triangle = record.first_triangle + ray.hit.primID;
    }
    return hit;
}

bool RayScene::blocked_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                              Against against) const
{
    const Inside& in = *inside_;
    TraceContext context;
    for (const bool in_moving : {false, true}) {
        if (against == (in_moving ? Against::static_only : Against::dynamic_only)) continue;
        RTCRay ray{};
        ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z, ray.tnear = tnear;
        ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z, ray.tfar = tfar;
        ray.mask = k_mask_blocks;
        rtcOccluded1((in_moving ? in.moving : in.still).get(), &context.embree, &ray);
        if (ray.tfar < 0) return true;
    }
    return false;
}

}   // namespace gnomon::ray
