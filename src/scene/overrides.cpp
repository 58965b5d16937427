// SPDX-License-Identifier: Apache-2.0
// What a user or a host sets in a SceneState: each setter compares with what is in force, and notes what differs for
// the next advance().
#include <algorithm>

#include "base/bits.h"
#include "base/check.h"
#include "scene/state.h"
#include "scene/value_tracks.h"

namespace gnomon::scene {

namespace {

bool same_vertices(const DeformedMesh& a, const DeformedMesh& b)
{
    return same_bits(a.positions, b.positions) && same_bits(a.normals, b.normals) && same_bits(a.tangents, b.tangents);
}

}   // namespace

void SceneState::override_transform(NodeId node, const glm::dmat4* local)
{
    GNOMON_CHECK_LT(node, scene_->nodes.size());
    const auto now = transforms_.find(node);
    if (local ? now != transforms_.end() && same_bits(now->second, *local) : now == transforms_.end()) return;
    if (local)
        transforms_[node] = *local;
    else
        transforms_.erase(now);
    transforms_due_.push_back(node);
}

void SceneState::override_visibility(NodeId node, std::optional<bool> visible)
{
    GNOMON_CHECK_LT(node, scene_->nodes.size());
    const auto now = visibilities_.find(node);
    if (visible ? now != visibilities_.end() && now->second == *visible : now == visibilities_.end()) return;
    if (visible)
        visibilities_[node] = *visible;
    else
        visibilities_.erase(now);
    visibilities_due_.push_back(node);
}

void SceneState::override_weights(ObjectId object, std::optional<std::vector<float>> weights)
{
    GNOMON_CHECK_LT(object, scene_->objects.size());
    GNOMON_CHECK(scene_->objects[object].deforming);
    if (weights) GNOMON_CHECK_EQ(weights->size(), scene_->meshes[scene_->objects[object].mesh].morph_targets.size());
    const auto now = weights_.find(object);
    if (weights ? now != weights_.end() && same_bits(now->second, *weights) : now == weights_.end()) return;
    if (weights)
        weights_[object] = std::move(*weights);
    else
        weights_.erase(now);
    // Vertices that are handed over take the place of the weights.
    if (!vertices_.contains(object)) shapes_due_.push_back(object);
}

void SceneState::override_vertices(ObjectId object, std::shared_ptr<const DeformedMesh> vertices)
{
    GNOMON_CHECK_LT(object, scene_->objects.size());
    GNOMON_CHECK(scene_->objects[object].deforming);
    if (vertices) {
        const std::size_t count = scene_->meshes[scene_->objects[object].mesh].positions.size();
        GNOMON_CHECK_EQ(vertices->positions.size(), count);
        GNOMON_CHECK(vertices->normals.empty() || vertices->normals.size() == count);
        GNOMON_CHECK(vertices->tangents.empty() || vertices->tangents.size() == count);
    }
    const auto now = vertices_.find(object);
    if (vertices ? now != vertices_.end() && (now->second == vertices || same_vertices(*now->second, *vertices))
                 : now == vertices_.end())
        return;
    if (vertices)
        vertices_[object] = std::move(vertices);
    else
        vertices_.erase(now);
    shapes_due_.push_back(object);
}

void SceneState::set_light(LightId light, const Light& values)
{
    lights_held_.insert(light);
    note_light(light, values);
}

void SceneState::release_light(LightId light, const Light& rest)
{
    lights_held_.erase(light);
    note_light(light, rest);
}

// Notes a light's values for the next advance(), which compares those of one with a track.
void SceneState::note_light(LightId light, const Light& values)
{
    GNOMON_CHECK_LT(light, scene_->lights.size());
    const Light& now = scene_->lights[light];
    Light wanted = values;
    wanted.name = now.name;
    wanted.type = now.type;
    wanted.node = now.node;
    wanted.track = now.track;
    wanted.of_environment = now.of_environment;
    wanted.by_default = now.by_default;
    wanted.of_surface = now.of_surface;
    if (!now.track && same_reach(wanted, now) && same_bits(wanted.color, now.color))
        lights_due_.erase(light);
    else
        lights_due_[light] = std::move(wanted);
}

void SceneState::set_material(MaterialId material, const Material& values)
{
    materials_held_.insert(material);
    note_material(material, values);
}

void SceneState::release_material(MaterialId material, const Material& rest)
{
    materials_held_.erase(material);
    note_material(material, rest);
}

// Notes a material's values for the next advance(), which compares those of one with a track.
void SceneState::note_material(MaterialId material, const Material& values)
{
    GNOMON_CHECK_LT(material, scene_->materials.size());
    const Material& now = scene_->materials[material];
    GNOMON_CHECK(same_to_rays(values, now));
    if (!now.track && same_values(values, now)) {
        materials_due_.erase(material);
        return;
    }
    Material& wanted = materials_due_[material];
    wanted = values;
    wanted.name = now.name;
    wanted.track = now.track;
}

void SceneState::keep_overrides(const Overridden& kept)
{
    const auto release = [](const auto& overrides, const auto& keeps, const auto& remove) {
        std::vector<std::uint32_t> gone;
        for (const auto& [key, value] : overrides)
            if (!keeps(key)) gone.push_back(key);
        for (const std::uint32_t key : gone) remove(key);
    };
    const auto by_node = [&](const std::function<bool(std::uint32_t)>& keeps) {
        return [this, &keeps](ObjectId object) { return keeps(scene_->objects[object].node); };
    };
    release(transforms_, kept.transform, [&](NodeId n) { override_transform(n, nullptr); });
    release(visibilities_, kept.visibility, [&](NodeId n) { override_visibility(n, {}); });
    release(vertices_, by_node(kept.vertices), [&](ObjectId o) { override_vertices(o, nullptr); });
    release(weights_, by_node(kept.weights), [&](ObjectId o) { override_weights(o, {}); });
    for (LightId l = 0; l < base_->lights.size(); ++l)
        if (!kept.light(l)) release_light(l, base_->lights[l]);
    for (MaterialId m = 0; m < base_->materials.size(); ++m)
        if (!kept.material(m)) release_material(m, base_->materials[m]);
}

// Writes the values of lights and materials that were set, or that tracks may have changed, into the scene, and lists
// what differs.
void SceneState::apply_values()
{
    for (auto& [id, wanted] : lights_due_) {
        Light& light = scene_->lights[id];
        if (light.track && !lights_held_.contains(id)) light.track->apply(time_, wanted);
        if (!same_reach(wanted, light)) changes_.lights_moved.push_back(id);
        if (!same_bits(wanted.color, light.color)) changes_.lights_relit.push_back(id);
        light = std::move(wanted);
    }
    for (auto& [id, wanted] : materials_due_) {
        Material& material = scene_->materials[id];
        if (material.track && !materials_held_.contains(id)) material.track->apply(time_, wanted);
        if (!same_values(wanted, material)) changes_.materials_changed.push_back(id);
        material = std::move(wanted);
    }
    changes_.touched_nodes += lights_due_.size() + materials_due_.size();
    lights_due_.clear();
    materials_due_.clear();
}

// Whether an override gives a node, or an ancestor, another transform than its track or its description.
bool SceneState::node_displaced(NodeId n) const
{
    for (; n != none; n = scene_->nodes[n].parent) {
        if (!transforms_.contains(n)) continue;
        const Node& node = scene_->nodes[n];
        if (!same_bits(local_[n], node.transform ? node.transform->evaluate(time_) : node.local)) return true;
    }
    return false;
}

bool SceneState::displaced(ObjectId id) const
{
    const Object& object = scene_->objects[id];
    const Mesh& mesh = scene_->meshes[object.mesh];

    // Is the place another one?
    std::vector<glm::mat4> joints;
    if (object.skin == none) {
        if (node_displaced(object.node)) return true;
    } else {
        const Skin& skin = scene_->skins[object.skin];
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
            if (node_displaced(skin.joints[j])) return true;
            joints.emplace_back(world_[skin.joints[j]] * skin.inverse_bind[j]);
        }
    }

    // Is the shape another one?
    if (vertices_.contains(id)) {
        DeformedMesh tracked;
        deform_mesh(mesh, time_, tracked_weights(id), joints, tracked);
        return !same_bits(tracked.positions, deformed(id).positions);
    }
    const auto weights = weights_.find(id);
    return weights != weights_.end() && !same_bits(weights->second, tracked_weights(id));
}

const SceneBounds& SceneState::present_bounds() const
{
    if (!bounds_) bounds_ = std::make_unique<PresentBounds>(*this);
    return bounds_->present();
}

}   // namespace gnomon::scene
