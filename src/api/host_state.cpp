// SPDX-License-Identifier: Apache-2.0
#include "api/host_state.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <map>

#include "api/convert.h"
#include "gnomon/error.h"
#include "scene/near_origin.h"

namespace gnomon::api {

namespace {

// A frame's input by the scene's indices.
struct Checked {
    std::vector<std::pair<scene::NodeId, glm::dmat4>> transforms;
    std::vector<std::pair<scene::NodeId, bool>> visibility;
    std::vector<std::pair<scene::NodeId, std::shared_ptr<const scene::DeformedMesh>>> vertices;
    std::vector<std::pair<scene::NodeId, std::vector<float>>> weights;
    std::vector<std::pair<scene::LightId, scene::Light>> lights;
    std::vector<std::pair<scene::MaterialId, scene::Material>> materials;
    std::map<scene::NodeId, frame::HostValues::Closing> closings;
    std::map<scene::LightId, scene::Light> closing_lights;
    std::map<scene::MaterialId, scene::Material> closing_materials;
    std::vector<std::uint32_t> released_nodes, released_lights, released_materials;
};

std::string titled(const char* kind, const std::string& name, std::uint32_t index)
{
    return name.empty() ? fmt::format("{} {}", kind, index) : api::titled(kind, name);
}

std::vector<glm::vec3> copied(std::span<const Vec3> from, std::size_t expected, const std::string& owner,
                              const char* what)
{
    if (from.size() != expected)
        throw UsageError(fmt::format("{}: {} {} for {} vertices", owner, from.size(), what, expected));
    std::vector<glm::vec3> to(from.size());
    if (!from.empty()) std::memcpy(to.data(), from.data(), from.size_bytes());
    for (std::size_t i = 0; i < to.size(); ++i)
        if (!is_finite(to[i])) throw UsageError(fmt::format("{}: {} {} is not finite", owner, what, i));
    return to;
}

// Checks the parts of an input one by one.
class Checker {
 public:
    explicit Checker(const Scene::Impl& impl) : scene_(*impl.scene), stamps_(impl.stamps) {}

    std::map<scene::NodeId, frame::HostValues::Closing> closings;   // of what was checked; so the next two
    std::map<scene::LightId, scene::Light> closing_lights;
    std::map<scene::MaterialId, scene::Material> closing_materials;

    std::pair<scene::NodeId, glm::dmat4> transform(const NodeTransform& t)
    {
        const scene::NodeId node = require(stamps_.nodes, t.node, "the node of a transform");
        const std::string owner = titled("node", scene_.nodes[node].name, node);
        const glm::dvec3 offset = scene_.nodes[node].parent == scene::none ? -stamps_.origin : glm::dvec3(0);
        if (t.closing) closings[node].transform = scene::translated(matrix_of(*t.closing, owner), offset);
        return {node, scene::translated(matrix_of(t.transform, owner), offset)};
    }
    std::pair<scene::NodeId, std::shared_ptr<const scene::DeformedMesh>> vertices(const InstanceVertices& v)
    {
        const scene::NodeId node = instance(v.instance, "the instance of vertices");
        const std::string owner = titled("instance", scene_.nodes[node].name, node);
        const std::size_t expected = scene_.meshes[scene_.nodes[node].mesh].positions.size();
        auto shape = std::make_shared<scene::DeformedMesh>();
        shape->positions = copied(v.positions, expected, owner, "positions");
        if (!v.normals.empty()) shape->normals = copied(v.normals, expected, owner, "normals");
        if (!v.closing_positions.empty())
            closings[node].positions = copied(v.closing_positions, expected, owner, "closing positions");
        // Those of a skinned instance are in world space.
        if (scene_.nodes[node].skin != scene::none && stamps_.origin != glm::dvec3(0))
            for (auto* positions : {&shape->positions, &closings[node].positions})
                for (glm::vec3& p : *positions) p -= glm::vec3(stamps_.origin);
        return {node, std::move(shape)};
    }
    std::pair<scene::NodeId, std::vector<float>> weights(const MorphWeights& w)
    {
        const scene::NodeId node = instance(w.instance, "the instance of morph weights");
        const std::string owner = titled("instance", scene_.nodes[node].name, node);
        const std::size_t expected = scene_.meshes[scene_.nodes[node].mesh].morph_targets.size();
        for (const std::vector<float>* list : {&w.weights, &w.closing}) {
            if (list->size() != expected && !(list == &w.closing && list->empty()))
                throw UsageError(fmt::format("{}: {} morph weights for {} targets", owner, list->size(), expected));
            for (const float weight : *list)
                if (!std::isfinite(weight)) throw UsageError(fmt::format("{}: a morph weight is not finite", owner));
        }
        if (!w.closing.empty()) closings[node].weights = w.closing;
        return {node, w.weights};
    }
    std::pair<scene::LightId, scene::Light> light(const LightValues& l)
    {
        const scene::LightId id = require(stamps_.lights, l.light, "the light of values");
        scene::Light values = to_scene(l.values);
        if (l.closing) {
            const scene::Light closing = to_scene(*l.closing);
            if (closing.type != values.type || closing.falloff != values.falloff || closing.profile != values.profile)
                throw UsageError(titled("light", scene_.lights[id].name, id) +
                                 ": its type, falloff and profile cannot change while the shutter is open");
            closing_lights.insert_or_assign(id, closing);
        }
        return {id, std::move(values)};
    }
    std::pair<scene::MaterialId, scene::Material> material(const MaterialValues& m)
    {
        const scene::MaterialId id = require(stamps_.materials, m.material, "the material of values");
        scene::Material values = to_scene(m.values, stamps_);
        if (m.closing) {
            const scene::Material closing = to_scene(*m.closing, stamps_);
            if (closing.model != values.model || !scene::same_to_rays(closing, values))
                throw UsageError(titled("material", scene_.materials[id].name, id) +
                                 ": its model, what it lets through and its sides cannot change while the shutter is "
                                 "open");
            closing_materials.insert_or_assign(id, closing);
        }
        return {id, std::move(values)};
    }
    scene::NodeId instance(const InstanceId& id, std::string_view what) const
    {
        const scene::NodeId node = require(stamps_.nodes, id, what);
        const scene::MeshId mesh = scene_.nodes[node].mesh;
        if (mesh == scene::none || scene_.meshes[mesh].triangles.empty())
            throw UsageError(fmt::format("{}: the node has no mesh with triangles", what));
        return node;
    }

 private:
    const scene::Scene& scene_;
    const SceneStamps& stamps_;
};

Checked checked(const Scene::Impl& impl, const FrameInput& input)
{
    Checker check(impl);
    const SceneStamps& stamps = impl.stamps;
    Checked result;
    for (const NodeTransform& t : input.transforms) result.transforms.push_back(check.transform(t));
    for (const NodeVisibility& v : input.visibility)
        result.visibility.emplace_back(require(stamps.nodes, v.node, "the node of a visibility"), v.visible);
    for (const InstanceVertices& v : input.vertices) result.vertices.push_back(check.vertices(v));
    for (const MorphWeights& w : input.morph_weights) result.weights.push_back(check.weights(w));
    for (const LightValues& l : input.lights) result.lights.push_back(check.light(l));
    for (const MaterialValues& m : input.materials) result.materials.push_back(check.material(m));
    for (const NodeId& id : input.released_nodes)
        result.released_nodes.push_back(require(stamps.nodes, id, "a released node"));
    for (const LightId& id : input.released_lights)
        result.released_lights.push_back(require(stamps.lights, id, "a released light"));
    for (const MaterialId& id : input.released_materials)
        result.released_materials.push_back(require(stamps.materials, id, "a released material"));
    result.closings = std::move(check.closings);
    result.closing_lights = std::move(check.closing_lights);
    result.closing_materials = std::move(check.closing_materials);
    return result;
}

}   // namespace

bool HostState::follows(const Scene& scene) const
{
    if (!scene_) return false;
    const StampList &before = SceneAccess::impl(*scene_).stamps.nodes, &now = SceneAccess::impl(scene).stamps.nodes;
    if (&before == &now) return true;
    for (std::size_t n = 0; n < std::min(before.size(), now.size()); ++n)
        if (before[n] != 0 && before[n] == now[n]) return true;
    return false;
}

void HostState::follow(const Scene& scene)
{
    const Scene::Impl& to = SceneAccess::impl(scene);
    auto values = std::make_unique<frame::HostValues>(to.scene);
    if (scene_) {
        const SceneStamps& before = SceneAccess::impl(*scene_).stamps;
        const auto finder = [](const StampList& from, const StampList& into) {
            return [&](std::uint32_t index) { return into.search(index, from[index]); };
        };
        values_->copy_to(*values, {finder(before.nodes, to.stamps.nodes), finder(before.lights, to.stamps.lights),
                                   finder(before.materials, to.stamps.materials)});
    }
    values->end_frame();   // these are the values of the frame before
    scene_ = scene;
    values_ = std::move(values);
}

void HostState::apply(const Scene& scene, const FrameInput& input)
{
    const Checked in = checked(SceneAccess::impl(scene), input);
    if (!scene_ || &SceneAccess::impl(*scene_) != &SceneAccess::impl(scene)) follow(scene);

    frame::HostValues& values = *values_;
    for (const std::uint32_t node : in.released_nodes) {
        values.set_transform(node, nullptr);
        values.set_visible(node, nullptr);
        values.set_closing(node, nullptr);
        if (values.object_at(node) == scene::none) continue;
        values.set_vertices(node, nullptr);
        values.set_weights(node, nullptr);
    }
    for (const std::uint32_t light : in.released_lights)
        values.set_light(light, nullptr), values.set_closing_light(light, nullptr);
    for (const std::uint32_t material : in.released_materials)
        values.set_material(material, nullptr), values.set_closing_material(material, nullptr);
    for (const auto& [node, transform] : in.transforms) values.set_transform(node, &transform);
    for (const auto& [node, visible] : in.visibility) values.set_visible(node, &visible);
    for (const auto& [node, shape] : in.vertices) values.set_vertices(node, shape);
    for (const auto& [node, weights] : in.weights) values.set_weights(node, &weights);
    for (const auto& [light, light_values] : in.lights) values.set_light(light, &light_values);
    for (const auto& [material, material_values] : in.materials) values.set_material(material, &material_values);
    // What is handed over with another value, or without one of the shutter's closing, stands still again.
    const auto value_in = [](const auto& list, std::uint32_t key) {
        const auto at = list.find(key);
        return at == list.end() ? nullptr : &at->second;
    };
    const auto closing_of = [&](scene::NodeId node) { values.set_closing(node, value_in(in.closings, node)); };
    for (const auto& [node, transform] : in.transforms) closing_of(node);
    for (const auto& [node, shape] : in.vertices) closing_of(node);
    for (const auto& [node, weights] : in.weights) closing_of(node);
    for (const auto& [light, of_light] : in.lights) values.set_closing_light(light, value_in(in.closing_lights, light));
    for (const auto& [material, of_material] : in.materials)
        values.set_closing_material(material, value_in(in.closing_materials, material));
    values.settle();
}

}   // namespace gnomon::api
