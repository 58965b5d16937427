// SPDX-License-Identifier: Apache-2.0
#include "scene/state.h"

#include <algorithm>
#include <utility>

#include "base/bits.h"
#include "base/check.h"
#include "base/volume.h"
#include "scene/change_index.h"
#include "scene/continuation.h"
#include "scene/value_tracks.h"

namespace gnomon::scene {

// The objects, lights, cameras, groups and skins of each node, and when tracks change. Built once.
struct SceneState::Index {
    ChangeIndex transforms, visibilities, deformations;   // ids: nodes, nodes, objects
    ChangeIndex lights, materials, cameras;               // with tracks of values
    std::vector<ObjectId> object_at;                      // by node
    std::unordered_map<NodeId, std::vector<LightId>> lights_at;
    std::unordered_map<NodeId, bool> cameras_at;
    std::unordered_map<NodeId, GroupId> group_at;
    // A joint may belong to many skins, and a skin to many objects, so there is no table of joints against objects.
    std::unordered_map<NodeId, std::vector<SkinId>> skins_at;   // by joint; skins that objects use
    std::vector<std::vector<ObjectId>> skinned_by;              // by skin

    explicit Index(const Scene& scene);
    /// Finds the parts of each node, without tracks and skins.
    void find_parts(const Scene& scene);
};

namespace {

template <class T>
void sort_unique(std::vector<T>& v)
{
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
}

// When the tracks of lights, materials or cameras change.
template <class T>
ChangeIndex index_of(const std::vector<T>& parts)
{
    ChangeIndex index;
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i].track)
            for (const Interval& interval : parts[i].track->changing())
                index.add(static_cast<std::uint32_t>(i), interval);
    index.build();
    return index;
}

}   // namespace

void SceneState::Index::find_parts(const Scene& scene)
{
    object_at.assign(scene.nodes.size(), none);
    for (std::size_t o = 0; o < scene.objects.size(); ++o)
        if (!scene.objects[o].removed) object_at[scene.objects[o].node] = static_cast<ObjectId>(o);
    lights_at.clear();
    for (std::size_t l = 0; l < scene.lights.size(); ++l)
        lights_at[scene.lights[l].node].push_back(static_cast<LightId>(l));
    cameras_at.clear();
    for (const Camera& camera : scene.cameras) cameras_at[camera.node] = true;
    group_at.clear();
    for (std::size_t g = 0; g < scene.groups.size(); ++g)
        if (!scene.groups[g].objects.empty()) group_at[scene.groups[g].anchor] = static_cast<GroupId>(g);
    cameras = index_of(scene.cameras);   // a continuation may have others
}

SceneState::Index::Index(const Scene& scene) : skinned_by(scene.skins.size())
{
    find_parts(scene);
    for (const std::uint32_t n : scene.track_nodes) {
        const Node& node = scene.nodes[n];
        if (node.transform)
            for (const Interval& interval : node.transform->changing()) transforms.add(n, interval);
        if (node.visibility)
            for (const double time : node.visibility->times) visibilities.add(n, {time, time});
        if (node.weights && object_at[n] != none)
            for (const Interval& interval : node.weights->changing()) deformations.add(object_at[n], interval);
    }
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (const auto& keys = scene.meshes[object.mesh].vertex_keys)
            deformations.add(static_cast<ObjectId>(o), {keys->times.front(), keys->times.back()});
        if (object.skin != none) skinned_by[object.skin].push_back(static_cast<ObjectId>(o));
    }
    for (std::size_t s = 0; s < scene.skins.size(); ++s)
        if (!skinned_by[s].empty())
            for (const NodeId joint : scene.skins[s].joints) skins_at[joint].push_back(static_cast<SkinId>(s));
    lights = index_of(scene.lights);
    materials = index_of(scene.materials);
    transforms.build();
    visibilities.build();
    deformations.build();
}

bool FrameChanges::light_changed(LightId light) const
{
    return std::binary_search(lights_moved.begin(), lights_moved.end(), light) ||
           std::binary_search(lights_relit.begin(), lights_relit.end(), light);
}

SceneState::SceneState(const std::shared_ptr<const Scene>& scene, double time)
    : base_(scene), scene_(std::make_shared<Scene>(*scene)), index_(std::make_unique<Index>(*scene_)), time_(time)
{
    const std::size_t nodes = scene_->nodes.size();
    local_.resize(nodes);
    world_.resize(nodes);
    shown_.resize(nodes);
    node_visible_.resize(nodes);
    visited_.assign(nodes, 0);
    joints_.resize(scene_->skins.size());
    for (Light& light : scene_->lights)
        if (light.track) light.track->apply(time_, light);
    for (Material& material : scene_->materials)
        if (material.track) material.track->apply(time_, material);
    apply_camera_tracks();
    skin_due_.assign(scene_->skins.size(), 0);
    for (std::size_t n = 0; n < nodes; ++n) {
        const Node& node = scene_->nodes[n];
        local_[n] = node.transform ? node.transform->evaluate(time_) : node.local;
        shown_[n] = !node.visibility || node.visibility->evaluate(time_);
        evaluate_node(static_cast<NodeId>(n));
    }
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) lights_.push_back(light_at(static_cast<LightId>(l)));

    dynamic_index_.assign(scene_->objects.size(), none);
    for (ObjectId o = 0; o < scene_->objects.size(); ++o) {
        group_of_.push_back(scene_->objects[o].group);
        if (!scene_->objects[o].dynamic) continue;
        dynamic_index_[o] = static_cast<std::uint32_t>(dynamic_objects_.size());
        dynamic_objects_.push_back(o);
    }
    deformed_slot_.assign(scene_->objects.size(), none);
    for (ObjectId o = 0; o < scene_->objects.size(); ++o)
        if (scene_->objects[o].deforming) deform_first(o);
}

// Deforms an object that has had no shape yet.
void SceneState::deform_first(ObjectId object)
{
    if (deformed_slot_[object] == none) {
        deformed_slot_[object] = static_cast<std::uint32_t>(deformed_.size());
        deformed_.emplace_back();
    }
    deform(object);
}

void SceneState::apply_camera_tracks()
{
    for (Camera& camera : scene_->cameras)
        if (camera.track) camera.track->apply(time_, camera);
}

void SceneState::continue_with(const Continuation& next)
{
    GNOMON_CHECK(taken_objects_.empty());
    // Note what disappears, while it is still known.
    for (const ObjectId object : next.removed) {
        if (object_visible(object)) vanished_.push_back(object);
        weights_.erase(object);
        vertices_.erase(object);
    }
    removed_.insert(removed_.end(), next.removed.begin(), next.removed.end());
    added_.insert(added_.end(), next.added.begin(), next.added.end());

    // Take over the scene, and keep the present values of lights and materials.
    Scene scene = *next.scene;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        Light light = scene_->lights[l];
        light.node = scene.lights[l].node;
        scene.lights[l] = std::move(light);
    }
    for (std::size_t m = 0; m < base_->materials.size(); ++m)
        if (same_values(base_->materials[m], scene.materials[m]) ||
            std::binary_search(next.edited.begin(), next.edited.end(), static_cast<MaterialId>(m)))
            scene.materials[m] = scene_->materials[m];
        else if (scene.materials[m].track)
            scene.materials[m].track->apply(time_, scene.materials[m]);
    *scene_ = std::move(scene);
    base_ = next.scene;
    index_->find_parts(*scene_);
    apply_camera_tracks();
    bounds_.reset();

    // Begin with replaced nodes as if they had been hidden; the next advance() evaluates them.
    const std::size_t nodes = scene_->nodes.size();
    local_.resize(nodes), world_.resize(nodes);
    shown_.resize(nodes), node_visible_.resize(nodes);
    visited_.resize(nodes, 0);
    const auto is_gone = [&](NodeId n) {
        return n >= nodes || std::binary_search(next.replaced.begin(), next.replaced.end(), n);
    };
    std::erase_if(transforms_, [&](const auto& entry) { return is_gone(entry.first); });
    std::erase_if(visibilities_, [&](const auto& entry) { return is_gone(entry.first); });
    std::erase_if(transforms_due_, is_gone);
    std::erase_if(visibilities_due_, is_gone);
    std::erase_if(replaced_, is_gone);
    for (const NodeId n : next.replaced) {
        local_[n] = scene_->nodes[n].local;
        world_[n] = glm::dmat4(1);
        shown_[n] = true;
        node_visible_[n] = false;
        replaced_.push_back(n);
    }

    // Make room for new objects.
    const std::size_t objects = scene_->objects.size();
    dynamic_index_.resize(objects, none);
    deformed_slot_.resize(objects, none);
    group_of_.resize(objects, none);
    for (const ObjectId object : next.added) {
        group_of_[object] = scene_->objects[object].group;
        if (dynamic_index_[object] == none) {
            dynamic_index_[object] = static_cast<std::uint32_t>(dynamic_objects_.size());
            dynamic_objects_.push_back(object);
        }
        if (scene_->objects[object].deforming) deform_first(object);
    }
}

ObjectId SceneState::object_at(NodeId node) const
{
    return index_->object_at[node];
}

SceneState::~SceneState() = default;

// Computes a node's world matrix and visibility from its parent's, which must be up to date.
void SceneState::evaluate_node(NodeId n)
{
    const Node& node = scene_->nodes[n];
    world_[n] = node.parent == none ? local_[n] : world_[node.parent] * local_[n];
    node_visible_[n] = shown_[n] && (node.parent == none || node_visible_[node.parent]);
}

const FrameChanges& SceneState::advance(double time)
{
    const double before = time_;
    time_ = time;
    ++step_;
    std::swap(active_before_, active_now_);
    std::swap(lights_active_before_, changes_.lights_moved);
    changes_ = FrameChanges{};
    changes_.added = std::exchange(added_, {});
    changes_.removed = std::exchange(removed_, {});
    changes_.vanished = std::exchange(vanished_, {});
    for (auto* list : {&changes_.added, &changes_.removed}) sort_unique(*list);
    to_deform_.clear();
    skins_due_.clear();
    groups_toggled_.clear();
    strays_.clear();

    // Apply the values of lights and materials.
    collect_values(before);
    apply_values();

    // Update the nodes that differ and those below, parents first.
    std::vector<NodeId> roots = std::exchange(replaced_, {});
    collect_roots(before, roots);
    sort_unique(roots);
    for (const NodeId root : roots) visit_below(root);

    // Deform the objects whose shapes may differ.
    collect_shapes(before);
    sort_unique(to_deform_);
    for (const ObjectId object : to_deform_) {
        // A hidden object is deformed when it appears.
        if (!object_visible(object)) continue;
        deform(object);
        changes_.deformed.push_back(object);
    }
    note_lists();
    if (bounds_) bounds_->follow(*this);
    return changes_;
}

// Collects the lights and materials whose tracks change between the two times, unless an override takes their place,
// and evaluates the tracks of cameras.
void SceneState::collect_values(double before)
{
    index_->lights.query(before, time_, due_);
    for (const LightId id : due_)
        if (!lights_held_.contains(id)) lights_due_.try_emplace(id, scene_->lights[id]);
    index_->materials.query(before, time_, due_);
    for (const MaterialId id : due_)
        if (!materials_held_.contains(id)) materials_due_.try_emplace(id, scene_->materials[id]);
    index_->cameras.query(before, time_, due_);
    changes_.touched_nodes += due_.size();
    for (const CameraId id : due_) {
        const Camera old = scene_->cameras[id];
        Camera& camera = scene_->cameras[id];
        camera.track->apply(time_, camera);
        if (camera.vertical_fov != old.vertical_fov || camera.orthographic_height != old.orthographic_height)
            changes_.camera_moved = true;
    }
}

// Evaluates the tracks that change between the two times and the overrides that were set; collects the nodes that may
// differ.
void SceneState::collect_roots(double before, std::vector<NodeId>& roots)
{
    index_->transforms.query(before, time_, due_);
    changes_.touched_nodes += due_.size();
    for (const NodeId n : due_) {
        if (transforms_.contains(n)) continue;
        const glm::dmat4 local = scene_->nodes[n].transform->evaluate(time_);
        if (same_bits(local, local_[n])) continue;
        local_[n] = local;
        roots.push_back(n);
    }
    index_->visibilities.query(before, time_, due_);
    changes_.touched_nodes += due_.size();
    for (const NodeId n : due_) {
        if (visibilities_.contains(n)) continue;
        shown_[n] = scene_->nodes[n].visibility->evaluate(time_);
        roots.push_back(n);
    }
    for (const NodeId n : transforms_due_) {
        const Node& node = scene_->nodes[n];
        const auto overridden = transforms_.find(n);
        local_[n] = overridden != transforms_.end() ? overridden->second
                    : node.transform                ? node.transform->evaluate(time_)
                                                    : node.local;
        roots.push_back(n);
    }
    transforms_due_.clear();
    for (const NodeId n : visibilities_due_) {
        const Node& node = scene_->nodes[n];
        const auto overridden = visibilities_.find(n);
        shown_[n] = overridden != visibilities_.end() ? overridden->second
                                                      : !node.visibility || node.visibility->evaluate(time_);
        roots.push_back(n);
    }
    visibilities_due_.clear();
}

// Collects the objects whose joints moved, whose keys or weights change between the two times, and whose overrides were
// set; unless an override takes the place of what differs.
void SceneState::collect_shapes(double before)
{
    for (const SkinId skin : skins_due_)
        for (const ObjectId object : index_->skinned_by[skin])
            if (!vertices_.contains(object)) to_deform_.push_back(object);
    index_->deformations.query(before, time_, due_);
    changes_.touched_nodes += due_.size();
    for (const ObjectId object : due_) {
        if (vertices_.contains(object)) continue;
        if (weights_.contains(object) && !scene_->meshes[scene_->objects[object].mesh].vertex_keys) continue;
        to_deform_.push_back(object);
    }
    to_deform_.insert(to_deform_.end(), shapes_due_.begin(), shapes_due_.end());
    changes_.touched_nodes += shapes_due_.size();
    shapes_due_.clear();
}

void SceneState::visit_below(NodeId root)
{
    stack_.assign(1, root);
    while (!stack_.empty()) {
        const NodeId n = stack_.back();
        stack_.pop_back();
        if (visited_[n] == step_) continue;
        visited_[n] = step_;
        ++changes_.touched_nodes;

        const glm::dmat4 old_world = world_[n];
        const bool old_visible = node_visible_[n];
        evaluate_node(n);
        const bool moved = !same_bits(old_world, world_[n]);
        const bool toggled = old_visible != static_cast<bool>(node_visible_[n]);
        if (!visibilities_.empty())
            if (const ObjectId object = index_->object_at[n];
                object != none && group_of_[object] != none && node_visible_[n] != group_visible(group_of_[object]))
                strays_.push_back(object);
        if (!moved && !toggled) continue;   // so nothing below changed

        if (const ObjectId object = index_->object_at[n]; object != none) {
            if (toggled) (old_visible ? changes_.vanished : changes_.appeared).push_back(object);
            const bool follows_node = scene_->objects[object].skin == none;
            if (moved && node_visible_[n] && follows_node) changes_.moved.push_back(object);
            if (toggled && !old_visible && scene_->objects[object].deforming) to_deform_.push_back(object);
        }
        if (const auto group = index_->group_at.find(n); group != index_->group_at.end() && node_visible_[n]) {
            changes_.groups_moved.push_back(group->second);
            if (has_volume(glm::mat4(old_world)) != has_volume(glm::mat4(world_[n])))
                groups_toggled_.push_back(group->second);
        }
        if (const auto at = index_->lights_at.find(n); at != index_->lights_at.end())
            for (const LightId l : at->second) {
                const LightState now = light_at(l);
                if (now == lights_[l]) continue;
                lights_[l] = now;
                changes_.lights_moved.push_back(l);
            }
        if (index_->cameras_at.contains(n)) changes_.camera_moved = true;
        if (const auto at = index_->skins_at.find(n); moved && at != index_->skins_at.end())
            for (const SkinId skin : at->second)
                if (std::exchange(skin_due_[skin], step_) != step_) skins_due_.push_back(skin);

        const auto begin = scene_->child_begin[n], end = scene_->child_begin[n + 1];
        stack_.insert(stack_.end(), scene_->child_list.begin() + begin, scene_->child_list.begin() + end);
    }
}

// Completes and sorts the lists, and compares with the step before.
void SceneState::note_lists()
{
    // A flat member of a group may keep its world matrix while the anchor's becomes singular.
    for (const GroupId group : groups_toggled_)
        for (const ObjectId object : scene_->groups[group].objects)
            if (group_of_[object] == group && object_visible(object)) changes_.moved.push_back(object);
    // An object that was added appears, even where the same node had another object.
    for (const ObjectId object : changes_.added) {
        if (!object_visible(object)) continue;
        changes_.appeared.push_back(object);
        if (group_of_[object] != none) changes_.groups_moved.push_back(group_of_[object]);
    }
    if (!changes_.added.empty())
        std::erase_if(changes_.moved, [&](ObjectId object) {
            return std::binary_search(changes_.added.begin(), changes_.added.end(), object);
        });
    sort_unique(changes_.moved);
    sort_unique(changes_.appeared);
    sort_unique(changes_.vanished);
    sort_unique(changes_.groups_moved);
    sort_unique(changes_.lights_moved);

    changes_.changed = changes_.moved;
    for (const auto* list : {&changes_.deformed, &changes_.appeared, &changes_.vanished})
        changes_.changed.insert(changes_.changed.end(), list->begin(), list->end());
    sort_unique(changes_.changed);
    note_overridden();

    active_now_.clear();
    std::set_union(changes_.moved.begin(), changes_.moved.end(), changes_.deformed.begin(), changes_.deformed.end(),
                   std::back_inserter(active_now_));
    const auto difference = [](const auto& a, const auto& b, auto& out) {
        std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    };
    difference(active_now_, active_before_, changes_.started);
    difference(active_before_, active_now_, changes_.stopped);
    difference(changes_.lights_moved, lights_active_before_, changes_.lights_started);
    difference(lights_active_before_, changes_.lights_moved, changes_.lights_stopped);
}

// Promotes the static objects that changed, which only an override can do, and separates from their groups the members
// that no longer move, or are no longer shown, with them.
void SceneState::note_overridden()
{
    for (const ObjectId object : changes_.changed) {
        if (!is_dynamic(object)) {
            dynamic_index_[object] = static_cast<std::uint32_t>(dynamic_objects_.size());
            dynamic_objects_.push_back(object);
            changes_.promoted.push_back(object);
        } else if (!transforms_.empty() && group_of_[object] != none && object_visible(object) &&
                   !rides_along(object)) {
            changes_.separated.push_back(object);
        }
    }
    changes_.separated.insert(changes_.separated.end(), strays_.begin(), strays_.end());
    sort_unique(changes_.separated);
    for (const ObjectId object : changes_.separated) group_of_[object] = none;
    std::merge(changes_.promoted.begin(), changes_.promoted.end(), changes_.separated.begin(), changes_.separated.end(),
               std::back_inserter(taken_objects_));
}

// Whether an object is where its group takes it. evaluate_node() multiplies the same matrices in the same order, so the
// bits are equal.
bool SceneState::rides_along(ObjectId object) const
{
    const NodeId anchor = scene_->groups[group_of_[object]].anchor;
    const NodeId node = scene_->objects[object].node;
    std::vector<NodeId> chain;
    for (NodeId n = node; n != anchor; n = scene_->nodes[n].parent) chain.push_back(n);
    glm::dmat4 by_group = world_[anchor];
    for (auto below = chain.rbegin(); below != chain.rend(); ++below) by_group = by_group * scene_->nodes[*below].local;
    return same_bits(by_group, world_[node]);
}

LightState SceneState::light_at(LightId light) const
{
    const NodeId n = scene_->lights[light].node;
    LightState state;
    state.position = glm::vec3(world_[n][3]);
    const glm::dvec3 z(world_[n][2]);
    const double length = glm::length(z);
    state.direction = length > 0 ? glm::vec3(-z / length) : glm::vec3(0, -1, 0);
    state.visible = node_visible_[n];
    return state;
}

void SceneState::deform(ObjectId id)
{
    const Object& object = scene_->objects[id];
    const Mesh& mesh = scene_->meshes[object.mesh];
    DeformedMesh& out = deformed_[deformed_slot_[id]];
    if (const auto handed = vertices_.find(id); handed != vertices_.end())
        return complete_vertices(mesh, *handed->second, out);

    const auto overridden = weights_.find(id);
    const std::vector<float> weights = overridden != weights_.end() ? overridden->second : tracked_weights(id);
    std::span<const glm::mat4> joints;
    if (object.skin != none) joints = joints_of(object.skin);
    deform_mesh(mesh, time_, weights, joints, out);
}

// The morph weights that the track, else the node, else the mesh gives.
std::vector<float> SceneState::tracked_weights(ObjectId id) const
{
    const Object& object = scene_->objects[id];
    const Node& node = scene_->nodes[object.node];
    const Mesh& mesh = scene_->meshes[object.mesh];
    std::vector<float> weights = node.morph_weights.empty() ? mesh.morph_weights : node.morph_weights;
    weights.resize(mesh.morph_targets.size());
    if (node.weights) node.weights->evaluate(time_, weights);
    return weights;
}

// Computes a skin's matrices once per step, for all its objects.
const std::vector<glm::mat4>& SceneState::joints_of(SkinId id)
{
    Joints& joints = joints_[id];
    if (joints.step == step_) return joints.matrices;
    const Skin& skin = scene_->skins[id];
    joints.matrices.clear();
    joints.matrices.reserve(skin.joints.size());
    for (std::size_t j = 0; j < skin.joints.size(); ++j)
        joints.matrices.emplace_back(world_[skin.joints[j]] * skin.inverse_bind[j]);
    joints.step = step_;
    return joints.matrices;
}

bool SceneState::object_there(ObjectId object) const
{
    if (!object_visible(object)) return false;
    const Object& o = scene_->objects[object];
    if (!is_dynamic(object) || o.skin != none) return true;
    const GroupId group = group_of_[object];
    return has_volume(glm::mat4(world_[group != none ? scene_->groups[group].anchor : o.node]));
}

glm::mat4 SceneState::object_matrix(ObjectId object) const
{
    const Object& o = scene_->objects[object];
    return o.skin != none ? glm::mat4(1) : glm::mat4(world_[o.node]);
}

const DeformedMesh& SceneState::deformed(ObjectId object) const
{
    GNOMON_CHECK(deformed_slot_[object] != none);
    return deformed_[deformed_slot_[object]];
}

}   // namespace gnomon::scene
