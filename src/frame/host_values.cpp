// SPDX-License-Identifier: Apache-2.0
#include "frame/host_values.h"

#include "base/bits.h"
#include "base/check.h"

namespace gnomon::frame {

namespace {

// Stores a value under a key, or removes what is there.
// @return whether that changed anything
template <class Map, class Value, class Same>
bool store(Map& map, typename Map::key_type key, const Value* value, const Same& same)
{
    const auto at = map.find(key);
    if (!value) {
        if (at == map.end()) return false;
        map.erase(at);
        return true;
    }
    if (at != map.end() && same(at->second, *value)) return false;
    map.insert_or_assign(key, *value);
    return true;
}

bool same_vertices(const std::shared_ptr<const scene::DeformedMesh>& a,
                   const std::shared_ptr<const scene::DeformedMesh>& b)
{
    return a == b || (same_bits(a->positions, b->positions) && same_bits(a->normals, b->normals) &&
                      same_bits(a->tangents, b->tangents));
}

bool same_light(const scene::Light& a, const scene::Light& b)
{
    return a.type == b.type && same_bits(a.color, b.color) && scene::same_reach(a, b);
}

}   // namespace

HostValues::HostValues(std::shared_ptr<const scene::Scene> scene) : given_(std::move(scene)), scene_(given_)
{
    find_objects();
}

void HostValues::find_objects()
{
    object_at_.assign(scene_->nodes.size(), scene::none);
    for (std::size_t o = 0; o < scene_->objects.size(); ++o)
        object_at_[scene_->objects[o].node] = static_cast<scene::ObjectId>(o);
}

// Whether a part of what the node moves is stored as static, or as a part of a body that the node is inside of. Nodes
// that are declared to move carry what is below them.
bool HostValues::must_promote_to_move(scene::NodeId root) const
{
    if (scene_->nodes[root].may_move()) return false;
    std::vector<scene::NodeId> stack{root};
    while (!stack.empty()) {
        const scene::NodeId n = stack.back();
        stack.pop_back();
        if (n != root && scene_->nodes[n].may_move()) continue;
        if (object_at_[n] != scene::none) {
            const scene::Object& object = scene_->objects[object_at_[n]];
            if (!object.dynamic || object.group != scene::none) return true;
        }
        stack.insert(stack.end(), scene_->child_list.begin() + scene_->child_begin[n],
                     scene_->child_list.begin() + scene_->child_begin[n + 1]);
    }
    return false;
}

void HostValues::promote(scene::NodeId node, bool deforms)
{
    bool& before = promoted_.try_emplace(node, false).first->second;
    before = before || deforms;
    must_remake_ = true;
}

void HostValues::set_transform(scene::NodeId node, const glm::dmat4* local)
{
    const scene::Node& described = scene_->nodes[node];
    const bool had_value = transforms_.contains(node);
    const auto same = [](const glm::dmat4& a, const glm::dmat4& b) { return same_bits(a, b); };
    if (!store(transforms_, node, local, same)) return;
    changed_transforms_.insert(node);
    // A first value that the node has anyway moves nothing.
    const bool moves = !local || had_value || described.transform || !same_bits(described.local, *local);
    if (moves && must_promote_to_move(node)) promote(node, false);
}

void HostValues::set_visible(scene::NodeId node, const bool* visible)
{
    const bool had_value = visible_.contains(node);
    if (!store(visible_, node, visible, std::equal_to<>())) return;
    changed_visible_.insert(node);
    const bool changes = !visible || had_value || scene_->nodes[node].visibility || !*visible;
    if (changes && must_promote_to_move(node)) promote(node, false);
}

void HostValues::set_vertices(scene::NodeId node, std::shared_ptr<const scene::DeformedMesh> vertices)
{
    if (!store(vertices_, node, vertices ? &vertices : nullptr, same_vertices)) return;
    changed_vertices_.insert(node);
    const scene::Object& object = scene_->objects[object_at_[node]];
    if (!object.deforming || !object.dynamic) promote(node, true);
}

void HostValues::set_weights(scene::NodeId node, const std::vector<float>* weights)
{
    const auto same = [](const std::vector<float>& a, const std::vector<float>& b) { return same_bits(a, b); };
    if (!store(weights_, node, weights, same)) return;
    changed_weights_.insert(node);
    const scene::Object& object = scene_->objects[object_at_[node]];
    if (!object.deforming || !object.dynamic) promote(node, true);
}

void HostValues::set_light(scene::LightId light, const scene::Light* values)
{
    if (!store(lights_, light, values, same_light)) return;
    changed_lights_.insert(light);
    if ((values ? *values : given_->lights[light]).type != scene_->lights[light].type) must_remake_ = true;
}

void HostValues::set_material(scene::MaterialId material, const scene::Material* values)
{
    if (!store(materials_, material, values, scene::same_values)) return;
    changed_materials_.insert(material);
    if (!scene::same_to_rays(values ? *values : given_->materials[material], scene_->materials[material]))
        must_remake_ = true;
}

void HostValues::settle()
{
    if (!must_remake_) return;
    must_remake_ = false;
    auto remade = std::make_shared<scene::Scene>(*given_);
    for (const auto& [node, deforms] : promoted_) {
        remade->nodes[node].animated = true;
        remade->nodes[node].deforms = remade->nodes[node].deforms || deforms;
    }
    for (const auto& [light, values] : lights_) remade->lights[light].type = values.type;
    for (const auto& [material, values] : materials_) {
        std::string name = std::move(remade->materials[material].name);
        remade->materials[material] = values;
        remade->materials[material].name = std::move(name);
    }
    remade->finish();
    scene_ = std::move(remade);
    find_objects();
}

void HostValues::copy_to(HostValues& other, const Mapping& mapping) const
{
    const scene::Scene& there = *other.given_;
    const auto each = [](const auto& values, const auto& index_of, const auto& copy) {
        for (const auto& [key, value] : values)
            if (const std::uint32_t index = index_of(key); index != scene::none) copy(index, value);
    };
    each(promoted_, mapping.node, [&](std::uint32_t n, bool deforms) { other.promote(n, deforms); });
    each(transforms_, mapping.node, [&](std::uint32_t n, const glm::dmat4& m) { other.set_transform(n, &m); });
    each(visible_, mapping.node, [&](std::uint32_t n, bool visible) { other.set_visible(n, &visible); });
    // Vertices and weights fit as long as the mesh has as many.
    const auto mesh_at = [&](std::uint32_t n) {
        return other.object_at_[n] == scene::none ? nullptr : &there.meshes[there.nodes[n].mesh];
    };
    each(vertices_, mapping.node, [&](std::uint32_t n, const auto& shape) {
        const scene::Mesh* mesh = mesh_at(n);
        if (mesh && mesh->positions.size() == shape->positions.size()) other.set_vertices(n, shape);
    });
    each(weights_, mapping.node, [&](std::uint32_t n, const std::vector<float>& weights) {
        const scene::Mesh* mesh = mesh_at(n);
        if (mesh && mesh->morph_targets.size() == weights.size()) other.set_weights(n, &weights);
    });
    each(lights_, mapping.light, [&](std::uint32_t l, const scene::Light& light) { other.set_light(l, &light); });
    each(materials_, mapping.material,
         [&](std::uint32_t m, const scene::Material& material) { other.set_material(m, &material); });
}

const glm::dmat4* HostValues::transform(scene::NodeId node) const
{
    const auto at = transforms_.find(node);
    return at == transforms_.end() ? nullptr : &at->second;
}

void HostValues::apply_transform(scene::SceneState& state, scene::NodeId node) const
{
    state.override_transform(node, transform(node));
}

void HostValues::apply_visible(scene::SceneState& state, scene::NodeId node) const
{
    const auto at = visible_.find(node);
    state.override_visibility(node, at == visible_.end() ? std::optional<bool>() : at->second);
}

void HostValues::apply_vertices(scene::SceneState& state, scene::NodeId node) const
{
    const auto at = vertices_.find(node);
    state.override_vertices(object_at_[node], at == vertices_.end() ? nullptr : at->second);
}

void HostValues::apply_weights(scene::SceneState& state, scene::NodeId node) const
{
    const auto at = weights_.find(node);
    state.override_weights(object_at_[node], at == weights_.end() ? std::optional<std::vector<float>>() : at->second);
}

void HostValues::apply_light(scene::SceneState& state, scene::LightId light) const
{
    const auto at = lights_.find(light);
    state.set_light(light, at == lights_.end() ? given_->lights[light] : at->second);
}

void HostValues::apply_material(scene::SceneState& state, scene::MaterialId material) const
{
    const auto at = materials_.find(material);
    state.set_material(material, at == materials_.end() ? given_->materials[material] : at->second);
}

void HostValues::apply_all(scene::SceneState& state) const
{
    for (const auto& [node, value] : transforms_) apply_transform(state, node);
    for (const auto& [node, value] : visible_) apply_visible(state, node);
    for (const auto& [node, value] : vertices_) apply_vertices(state, node);
    for (const auto& [node, value] : weights_) apply_weights(state, node);
    for (const auto& [light, value] : lights_) apply_light(state, light);
    for (const auto& [material, value] : materials_) apply_material(state, material);
}

void HostValues::apply_changes(scene::SceneState& state) const
{
    for (const std::uint32_t node : changed_transforms_) apply_transform(state, node);
    for (const std::uint32_t node : changed_visible_) apply_visible(state, node);
    for (const std::uint32_t node : changed_vertices_) apply_vertices(state, node);
    for (const std::uint32_t node : changed_weights_) apply_weights(state, node);
    for (const std::uint32_t light : changed_lights_) apply_light(state, light);
    for (const std::uint32_t material : changed_materials_) apply_material(state, material);
}

void HostValues::forget_changes()
{
    for (auto* set : {&changed_transforms_, &changed_visible_, &changed_vertices_, &changed_weights_, &changed_lights_,
                      &changed_materials_})
        set->clear();
}

}   // namespace gnomon::frame
