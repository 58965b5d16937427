// SPDX-License-Identifier: Apache-2.0
#include "frame/host_values.h"

#include "base/bits.h"
#include "base/check.h"
#include "scene/pose_between.h"

namespace gnomon::frame {

namespace {

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

bool HostValues::must_promote_to_deform(scene::NodeId id) const
{
    const scene::Node& node = scene_->nodes[id];
    const bool deforms = node.deforms || node.weights || scene_->meshes[node.mesh].vertex_keys ||
                         scene_->objects[object_at_[id]].skin != scene::none;
    return !deforms;
}

void HostValues::promote(scene::NodeId node, bool deforms)
{
    bool& before = promoted_.try_emplace(node, false).first->second;
    before = before || deforms;
    must_remake_ = true;
}

void HostValues::set_transform(scene::NodeId node, const glm::dmat4* local)
{
    const auto in_force = [&] {
        const glm::dmat4* value = transforms_.now(node);
        return value ? *value : scene_->nodes[node].local;   // a node with a track needs no promotion
    };
    const glm::dmat4 before = in_force();
    const auto same = [](const glm::dmat4& a, const glm::dmat4& b) { return same_bits(a, b); };
    if (!transforms_.store(node, local, same)) return;
    if (!same_bits(before, in_force()) && must_promote_to_move(node)) promote(node, false);
}

void HostValues::set_visible(scene::NodeId node, const bool* visible)
{
    const auto in_force = [&] {
        const bool* value = visible_.now(node);
        return !value || *value;
    };
    const bool before = in_force();
    if (!visible_.store(node, visible, std::equal_to<>())) return;
    if (before != in_force() && must_promote_to_move(node)) promote(node, false);
}

void HostValues::set_vertices(scene::NodeId node, std::shared_ptr<const scene::DeformedMesh> vertices)
{
    if (!vertices_.store(node, vertices ? &vertices : nullptr, same_vertices)) return;
    if (must_promote_to_deform(node)) promote(node, true);
}

void HostValues::set_weights(scene::NodeId node, const std::vector<float>* weights)
{
    const auto same = [](const std::vector<float>& a, const std::vector<float>& b) { return same_bits(a, b); };
    if (!weights_.store(node, weights, same)) return;
    if (must_promote_to_deform(node)) promote(node, true);
}

void HostValues::set_light(scene::LightId light, const scene::Light* values)
{
    if (!lights_.store(light, values, same_light)) return;
    if ((values ? *values : given_->lights[light]).type != scene_->lights[light].type) must_remake_ = true;
}

void HostValues::set_material(scene::MaterialId material, const scene::Material* values)
{
    if (!materials_.store(material, values, scene::same_values)) return;
    if (!scene::same_to_rays(values ? *values : given_->materials[material], scene_->materials[material]))
        must_remake_ = true;
}

void HostValues::set_closing(scene::NodeId node, const Closing* closing)
{
    if (!closing || (!closing->transform && closing->positions.empty() && closing->weights.empty())) {
        closings_.nodes.erase(node);
        return;
    }
    closings_.nodes.insert_or_assign(node, *closing);
    if (closing->transform && must_promote_to_move(node)) promote(node, false);
}

void HostValues::set_closing_light(scene::LightId light, const scene::Light* values)
{
    if (values)
        closings_.lights.insert_or_assign(light, *values);
    else
        closings_.lights.erase(light);
}

void HostValues::set_closing_material(scene::MaterialId material, const scene::Material* values)
{
    if (values)
        closings_.materials.insert_or_assign(material, *values);
    else
        closings_.materials.erase(material);
}

void HostValues::settle()
{
    if (!must_remake_) return;
    auto remade = std::make_shared<scene::Scene>(*given_);
    for (const auto& [node, deforms] : promoted_) {
        remade->nodes[node].animated = true;
        remade->nodes[node].deforms = remade->nodes[node].deforms || deforms;
    }
    for (const auto& [light, values] : lights_.all()) remade->lights[light].type = values.type;
    for (const auto& [material, values] : materials_.all()) {
        std::string name = std::move(remade->materials[material].name);
        auto track = std::move(remade->materials[material].track);
        remade->materials[material] = values;
        remade->materials[material].name = std::move(name);
        remade->materials[material].track = std::move(track);
    }
    remade->finish();
    scene_ = std::move(remade);
    must_remake_ = false;
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
    each(transforms_.all(), mapping.node, [&](std::uint32_t n, const glm::dmat4& m) { other.set_transform(n, &m); });
    each(visible_.all(), mapping.node, [&](std::uint32_t n, bool visible) { other.set_visible(n, &visible); });
    // Vertices and weights fit as long as the mesh has as many.
    const auto mesh_at = [&](std::uint32_t n) {
        return other.object_at_[n] == scene::none ? nullptr : &there.meshes[there.nodes[n].mesh];
    };
    each(vertices_.all(), mapping.node, [&](std::uint32_t n, const auto& shape) {
        const scene::Mesh* mesh = mesh_at(n);
        if (mesh && mesh->positions.size() == shape->positions.size()) other.set_vertices(n, shape);
    });
    each(weights_.all(), mapping.node, [&](std::uint32_t n, const std::vector<float>& weights) {
        const scene::Mesh* mesh = mesh_at(n);
        if (mesh && mesh->morph_targets.size() == weights.size()) other.set_weights(n, &weights);
    });
    each(closings_.nodes, mapping.node, [&](std::uint32_t n, const Closing& closing) {
        const std::shared_ptr<const scene::DeformedMesh>* shape = other.vertices_.now(n);
        const std::vector<float>* weights = other.weights_.now(n);
        Closing copy{closing.transform, {}, {}};
        if (shape && (*shape)->positions.size() == closing.positions.size()) copy.positions = closing.positions;
        if (weights && weights->size() == closing.weights.size()) copy.weights = closing.weights;
        other.set_closing(n, &copy);
    });
    each(lights_.all(), mapping.light, [&](std::uint32_t l, const scene::Light& light) { other.set_light(l, &light); });
    each(materials_.all(), mapping.material,
         [&](std::uint32_t m, const scene::Material& material) { other.set_material(m, &material); });
    each(closings_.lights, mapping.light,
         [&](std::uint32_t l, const scene::Light& light) { other.set_closing_light(l, &light); });
    each(closings_.materials, mapping.material,
         [&](std::uint32_t m, const scene::Material& material) { other.set_closing_material(m, &material); });
}

template <class Act>
void HostValues::each_kind_of_geometry(scene::SceneState& state, const Act& act) const
{
    act([&](scene::NodeId n, const glm::dmat4* local) { state.override_transform(n, local); }, transforms_);
    act(
        [&](scene::NodeId n, const bool* visible) {
            state.override_visibility(n, visible ? std::optional<bool>(*visible) : std::nullopt);
        },
        visible_);
    act(
        [&](scene::NodeId n, const std::shared_ptr<const scene::DeformedMesh>* vertices) {
            state.override_vertices(state.object_at(n), vertices ? *vertices : nullptr);
        },
        vertices_);
    act(
        [&](scene::NodeId n, const std::vector<float>* weights) {
            state.override_weights(state.object_at(n),
                                   weights ? std::optional<std::vector<float>>(*weights) : std::nullopt);
        },
        weights_);
}

template <class Act>
void HostValues::each_kind(scene::SceneState& state, const Act& act) const
{
    each_kind_of_geometry(state, act);
    act([&](scene::LightId l, const scene::Light* values) { hand_over(state, l, values); }, lights_);
    act([&](scene::MaterialId m, const scene::Material* values) { hand_over(state, m, values); }, materials_);
}

// Hands over the values of a light or a material, or lets the scene's own hold again.
void HostValues::hand_over(scene::SceneState& state, scene::LightId light, const scene::Light* values) const
{
    values ? state.set_light(light, *values) : state.release_light(light, given_->lights[light]);
}

void HostValues::hand_over(scene::SceneState& state, scene::MaterialId material, const scene::Material* values) const
{
    values ? state.set_material(material, *values) : state.release_material(material, given_->materials[material]);
}

void HostValues::apply_all(scene::SceneState& state) const
{
    each_kind(state, [](const auto& set, const auto& values) {
        for (const auto& [key, value] : values.all()) set(key, &value);
    });
    apply_pose(state, shown_at_);
}

// Hands over the values of nodes at a fraction between those of a list and the closing ones; without any closing value
// of a kind, those of the list.
// @param value_of  of a list of values and a node, a pointer
template <class Value>
void HostValues::pose_nodes(scene::SceneState& state, const Closings& closings, double fraction,
                            const Value& value_of) const
{
    for (const auto& [node, closing] : closings.nodes) {
        const glm::dmat4* local = value_of(transforms_, node);
        if (local && closing.transform) {
            const glm::dmat4 posed = scene::pose_between(*local, *closing.transform, fraction);
            state.override_transform(node, &posed);
        } else {
            state.override_transform(node, local);
        }
        if (object_at_[node] == scene::none) continue;
        const scene::ObjectId object = state.object_at(node);
        const std::shared_ptr<const scene::DeformedMesh>* shape = value_of(vertices_, node);
        if (shape && closing.positions.size() == (*shape)->positions.size())
            state.override_vertices(object, std::make_shared<const scene::DeformedMesh>(
                                                scene::pose_between(**shape, closing.positions, fraction)));
        else if (shape)
            state.override_vertices(object, *shape);
        if (const std::vector<float>* weights = value_of(weights_, node))
            state.override_weights(object, closing.weights.size() == weights->size()
                                               ? scene::pose_between(*weights, closing.weights, fraction)
                                               : *weights);
    }
}

// The same for the values of lights and materials.
void HostValues::pose_looks(scene::SceneState& state, const Closings& closings, double fraction) const
{
    const auto pose = [&](const auto& values, const auto& closing) {
        for (const auto& [key, second] : closing) {
            const auto* const first = values.now(key);
            if (!first) {
                hand_over(state, key, first);
                continue;
            }
            const auto posed = scene::pose_between(*first, second, fraction);
            hand_over(state, key, &posed);
        }
    };
    pose(lights_, closings.lights);
    pose(materials_, closings.materials);
}

void HostValues::apply_pose(scene::SceneState& state, double fraction) const
{
    pose_nodes(state, closings_, fraction, [](const auto& values, scene::NodeId n) { return values.now(n); });
    pose_looks(state, closings_, fraction);
}

void HostValues::replace_all(scene::SceneState& state) const
{
    const auto has = [](const auto& values) {
        return [&values](std::uint32_t key) { return values.now(key) != nullptr; };
    };
    state.keep_overrides(
        {has(transforms_), has(visible_), has(vertices_), has(weights_), has(lights_), has(materials_)});
    apply_all(state);
}

void HostValues::apply_changes(scene::SceneState& state) const
{
    each_kind(state, [](const auto& set, const auto& values) {
        for (const auto& [key, before] : values.changed()) set(key, values.now(key));
    });
    // What moved while the shutter of the frame before was open is left at some place of its way.
    pose_nodes(state, closings_before_, 0, [](const auto& values, scene::NodeId n) { return values.now(n); });
    pose_looks(state, closings_before_, 0);
    apply_pose(state, shown_at_);
}

void HostValues::apply_before(scene::SceneState& state, bool is_new) const
{
    each_kind_of_geometry(state, [is_new](const auto& set, const auto& values) {
        if (is_new)
            for (const auto& [key, value] : values.all()) set(key, values.before(key));
        else
            for (const std::uint32_t key : values.changed_last()) set(key, values.before(key));
        for (const auto& [key, before] : values.changed()) set(key, values.before(key));
    });
    const auto before = [](const auto& values, scene::NodeId n) { return values.before(n); };
    pose_nodes(state, closings_earlier_, 0, before);
    pose_nodes(state, closings_before_, shown_at_, before);
}

void HostValues::replace_before(scene::SceneState& state) const
{
    const auto had = [](const auto& values) {
        return [&values](std::uint32_t key) { return values.before(key) != nullptr; };
    };
    const auto any = [](std::uint32_t) { return true; };
    state.keep_overrides({had(transforms_), had(visible_), had(vertices_), had(weights_), any, any});
    apply_before(state, true);
}

void HostValues::end_frame()
{
    transforms_.settle(), visible_.settle(), vertices_.settle();
    weights_.settle(), lights_.settle(), materials_.settle();
    closings_earlier_ = std::move(closings_before_);
    closings_before_ = closings_;
}

}   // namespace gnomon::frame
