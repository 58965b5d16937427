// SPDX-License-Identifier: Apache-2.0
#pragma once
// Random clips with all that caches treat differently, and a user who overrides all that can be overridden.

#include <algorithm>
#include <functional>
#include <map>
#include <optional>

#include "light_script.h"
#include "scene/state.h"

namespace gnomon::test {

using scene::NodeId;
using scene::ObjectId;

inline constexpr int k_frames = 24;   // of a clip
inline constexpr double k_fps = 24;

// Regular, singular and regular again.
class CollapsingTrack final : public scene::TransformTrack {
 public:
    explicit CollapsingTrack(const glm::dmat4& place) : place_(place) {}
    glm::dmat4 evaluate(double time) const override
    {
        const int frame = static_cast<int>(time * k_fps + 0.5);
        return frame % 8 < 5 ? place_ : place_ * glm::scale(glm::dmat4(1), glm::dvec3(1, frame % 2 ? 0 : 1, 0));
    }
    std::vector<scene::Interval> changing() const override
    {
        std::vector<scene::Interval> intervals;
        for (int frame = 0; frame <= k_frames; ++frame) intervals.push_back({frame / k_fps - 0.03, frame / k_fps});
        return intervals;
    }

 private:
    glm::dmat4 place_;
};

struct RandomClip {
    std::shared_ptr<const scene::Scene> scene;
    std::vector<NodeId> movable;     // nodes that a user may take
    std::vector<ObjectId> shaped;    // objects that deform
    std::vector<ObjectId> morphed;   // those with morph targets
};

// Lights of all types, some of which move or blink, and a camera.
inline void add_lights_and_camera(scene::Scene& made, RandomClip& clip, Random& random)
{
    const auto add_light = [&](scene::LightType type, const glm::dvec3& at) {
        scene::Light light;
        light.type = type;
        light.color = glm::vec3(type == scene::LightType::directional ? 2.0f : 60.0f);
        light.outer_angle = 0.7f;
        light.node = made.add_node("", scene::none,
                                   glm::inverse(glm::lookAt(at, glm::dvec3(0.1, -0.3, 0.2), glm::dvec3(0.1, 1, 0.3))));
        made.lights.push_back(light);
        return light.node;
    };
    clip.movable.push_back(add_light(scene::LightType::spot, {2, 7, 4}));
    clip.movable.push_back(add_light(scene::LightType::point, {-2, 2, 2}));
    made.nodes[add_light(scene::LightType::directional, {1, 3, 2})].visibility = blinking(k_frames, k_fps, 9, random);
    const NodeId moving = add_light(scene::LightType::spot, {-4, 5, 3});
    const glm::dmat4 from = made.nodes[moving].local;
    made.nodes[moving].transform = std::make_shared<JumpTrack>(0.5, from, translation(0.5, 0.2, 0) * from);

    scene::Camera camera;
    camera.node = made.add_node("camera", scene::none, translation(0, 0.5, 9));
    made.cameras.push_back(camera);
}

/// @param declared  the scene declares what a user may take as animated, so that nothing is promoted or separated
inline RandomClip random_clip(std::uint64_t seed, bool declared = false)
{
    Random random(seed, 3);
    scene::Scene made;
    add_materials(made);
    for (scene::MaterialId m = 0; m < material_count; ++m) made.meshes.push_back(ball(m, 4, 6, seed + m));
    const std::uint32_t rigid = static_cast<std::uint32_t>(made.meshes.size());
    const auto add_mesh = [&](scene::Mesh mesh) {
        made.meshes.push_back(std::move(mesh));
        return static_cast<scene::MeshId>(made.meshes.size() - 1);
    };
    RandomClip clip;
    const auto add = [&](scene::MeshId mesh, NodeId parent, const glm::dmat4& local) {
        clip.movable.push_back(add_object(made, mesh, parent, local));
        return clip.movable.back();
    };
    const auto scripted = [&](std::uint64_t n, float reach) {
        std::vector<glm::dmat4> places;
        for (int i = 0; i < 3; ++i) places.push_back(random_placement(random, reach));
        return std::make_shared<ScriptTrack>(std::move(places), k_frames, k_fps, seed * 31 + n);
    };
    const glm::dmat4 flat = glm::scale(glm::dmat4(1), glm::dvec3(1, 0, 1));

    // Static: a floor and a wall, a shelf of balls, a flat one, and a morph that never changes.
    add(0, scene::none, translation(0, -3, 0) * glm::scale(glm::dmat4(1), glm::dvec3(6, 0.2, 6)));
    add(0, scene::none, translation(0, 0, -5) * glm::scale(glm::dmat4(1), glm::dvec3(6, 4, 0.3)));
    const NodeId shelf = made.add_node("shelf", scene::none, translation(0.3, 0.2, 0));
    clip.movable.push_back(shelf);
    for (int i = 0; i < 4; ++i) add(random.below(rigid), shelf, random_placement(random, 2.5f));
    add(0, shelf, random_placement(random, 2) * flat);
    scene::Mesh morph = ball(0, 4, 6, seed + 50);
    morph.normals.clear();
    morph.morph_targets.resize(1);
    morph.morph_targets[0].positions.assign(morph.positions.size(), glm::vec3(0.1f, 0.2f, 0));
    morph.morph_weights = {0.5f};
    made.nodes[add(add_mesh(std::move(morph)), scene::none, random_placement(random, 2))].deforms = declared;

    // Rigid groups of two, one of the members flat; a group inside a parent that collapses.
    for (std::uint64_t g = 0; g < 2; ++g) {
        const NodeId anchor = made.add_node("anchor", scene::none);
        made.nodes[anchor].transform = scripted(g, 2.5f);
        const NodeId arm = made.add_node("arm", anchor, random_placement(random, 0.5f));
        clip.movable.insert(clip.movable.end(), {anchor, arm});
        add(random.below(rigid), arm, glm::scale(glm::dmat4(1), glm::dvec3(0.6)));
        add(random.below(rigid), arm, random_placement(random, 1) * (g ? flat : glm::dmat4(1)));
    }
    const NodeId collapsing = made.add_node("collapsing", scene::none);
    made.nodes[collapsing].transform = std::make_shared<CollapsingTrack>(random_placement(random, 2));
    clip.movable.push_back(collapsing);
    add(random.below(rigid), collapsing, glm::dmat4(1));
    add(random.below(rigid), collapsing, translation(1, 0, 0) * flat);
    made.nodes[add(random.below(rigid), collapsing, glm::dmat4(1))].transform = scripted(7, 1);

    // What appears and vanishes, deforms, or follows a joint.
    made.nodes[add(random.below(rigid), scene::none, random_placement(random, 2))].visibility =
        blinking(k_frames, k_fps, 5, random);
    scene::Mesh deforming = patchwork(seed + 60);
    add_vertex_keys(deforming);
    deforming.vertex_keys->times = {0.2, 0.4, 0.8};
    made.nodes[add(add_mesh(std::move(deforming)), scene::none, random_placement(random, 2))].visibility =
        blinking(k_frames, k_fps, 9, random);
    scene::Mesh skinned = ball(0, 4, 6, seed + 70);
    skinned.skin.emplace();
    skinned.skin->joints[0].assign(skinned.positions.size(), glm::u16vec4(0));
    skinned.skin->weights[0].assign(skinned.positions.size(), glm::vec4(1, 0, 0, 0));
    const NodeId joint = made.add_node("joint", scene::none);
    made.nodes[joint].transform = scripted(8, 2);
    made.skins.push_back({"", {joint}, {glm::dmat4(1)}});
    made.nodes[add(add_mesh(std::move(skinned)), scene::none, glm::dmat4(1))].skin = 0;

    made.nodes[add(add_mesh(patchwork(seed + 80)), scene::none, random_placement(random, 2))].deforms = true;

    add_lights_and_camera(made, clip, random);

    // Some of what a user may take is declared; all that is not stays where it is.
    if (declared) {
        std::erase_if(clip.movable, [&](NodeId) { return random.below(3) == 0; });
        for (const NodeId node : clip.movable) made.nodes[node].animated = true;
    }
    clip.scene = finished(made);
    for (ObjectId o = 0; o < clip.scene->objects.size(); ++o) {
        const scene::Object& object = clip.scene->objects[o];
        if (!object.deforming) continue;
        clip.shaped.push_back(o);
        if (!clip.scene->meshes[object.mesh].morph_targets.empty()) clip.morphed.push_back(o);
    }
    return clip;
}

/// What a user overrides, and does next.
class User {
 public:
    /// @param may_emit  surfaces may begin to shine
    User(const RandomClip& clip, std::uint64_t seed, bool may_emit = true)
        : clip_(clip), may_emit_(may_emit), random_(seed, 4)
    {
    }

    /// The time of the next step, of a whole frame: between frames, tracks jump within rounding of their times.
    double next_time(double now)
    {
        const std::uint32_t kind = random_.below(8);
        if (kind < 2) return now;
        if (kind < 6) return std::min(std::round(now * k_fps) + 1, double{k_frames}) / k_fps;
        return random_.below(k_frames) / k_fps;
    }
    void act(scene::SceneState& state)
    {
        for (std::uint32_t n = random_.below(4); n > 0; --n) move_something(state);
        if (random_.below(3) == 0) hide_something(state);
        if (random_.below(3) == 0) morph_something(state);
        if (random_.below(3) == 0) shape_something(state);
        if (random_.below(3) == 0) relight_something(state);
        if (random_.below(4) == 0) recolour_something(state);
        if (random_.below(10) == 0) {
            for (const auto& [node, local] : transforms_) state.override_transform(node, nullptr);
            transforms_.clear();
        }
    }
    /// Sets all that is in force in another state of the same scene, which must advance afterwards.
    void apply(scene::SceneState& state) const
    {
        for (const auto& [node, local] : transforms_) state.override_transform(node, &local);
        for (const auto& [node, visible] : visibilities_) state.override_visibility(node, visible);
        for (const auto& [object, weights] : weights_) state.override_weights(object, weights);
        for (const auto& [object, shape] : shapes_) state.override_vertices(object, shape);
        for (const auto& [light, values] : lights_) state.set_light(light, values);
        for (const auto& [material, values] : materials_) state.set_material(material, values);
    }

 private:
    double shift() { return static_cast<double>(random_.uniform(-1, 1)); }
    template <class T>
    const T& one_of(const std::vector<T>& list)
    {
        return list[random_.below(static_cast<std::uint32_t>(list.size()))];
    }

    void move_something(scene::SceneState& state)
    {
        const NodeId node = one_of(clip_.movable);
        const scene::Node& of = clip_.scene->nodes[node];
        if (!transforms_.contains(node) && of.transform == nullptr && random_.below(8) == 0) {
            transforms_[node] = of.local;   // where it is
            state.override_transform(node, &of.local);
            return;
        }
        if (transforms_.contains(node) && random_.below(2)) {
            state.override_transform(node, nullptr);
            transforms_.erase(node);
            return;
        }
        glm::dmat4 local = of.transform ? of.transform->evaluate(0) : of.local;
        const double reach = random_.below(8) == 0 ? 30 : 1;   // far outside of the clip's bounds now and then
        local[3] += reach * glm::dvec4(shift(), shift(), shift(), 0);
        if (random_.below(4) == 0)
            local *= glm::scale(glm::dmat4(1), glm::dvec3(1, random_.below(2), random_.below(2)));
        transforms_[node] = local;
        state.override_transform(node, &local);
    }
    void hide_something(scene::SceneState& state)
    {
        const NodeId node = one_of(clip_.movable);
        const std::uint32_t kind = random_.below(3);
        if (kind == 0) {
            visibilities_.erase(node);
            state.override_visibility(node, {});
            return;
        }
        visibilities_[node] = kind == 1;
        state.override_visibility(node, kind == 1);
    }
    void morph_something(scene::SceneState& state)
    {
        const ObjectId object = one_of(clip_.morphed);
        if (random_.below(3) == 0) {
            weights_.erase(object);
            state.override_weights(object, {});
            return;
        }
        weights_[object] = {random_.uniform(-1, 2)};
        state.override_weights(object, weights_[object]);
    }
    void shape_something(scene::SceneState& state)
    {
        const ObjectId object = one_of(clip_.shaped);
        if (random_.below(3) == 0) {
            shapes_.erase(object);
            state.override_vertices(object, nullptr);
            return;
        }
        const scene::Mesh& mesh = clip_.scene->meshes[clip_.scene->objects[object].mesh];
        auto shape = std::make_shared<scene::DeformedMesh>();
        shape->positions = mesh.positions;
        const float size = random_.uniform(0.5f, 1.5f), far = random_.below(8) == 0 ? 20.0f : 0.0f;
        for (glm::vec3& p : shape->positions) p = size * p + glm::vec3(far, 0.1f * random_.uniform(-1, 1), 0);
        if (random_.below(2)) shape->normals = mesh.normals;
        shapes_[object] = shape;
        state.override_vertices(object, shape);
    }
    void relight_something(scene::SceneState& state)
    {
        const scene::LightId light = random_.below(static_cast<std::uint32_t>(clip_.scene->lights.size()));
        scene::Light values = clip_.scene->lights[light];
        if (random_.below(4) > 0) {
            values.color *= random_.below(4) == 0 ? 0.0f : random_.uniform(0.2f, 3);
            if (random_.below(2)) values.outer_angle = random_.below(2) ? 1.3f : random_.uniform(0.4f, 1);
            if (random_.below(4) == 0) values.range = random_.uniform(3, 12);
            if (random_.below(4) == 0) values.falloff = scene::Falloff::constant;
            if (random_.below(4) == 0) values.profile = scene::SpotProfile::cosine;
        }
        lights_[light] = values;
        state.set_light(light, values);
    }
    void recolour_something(scene::SceneState& state)
    {
        const scene::MaterialId material = random_.below(static_cast<std::uint32_t>(clip_.scene->materials.size()));
        scene::Material values = clip_.scene->materials[material];
        if (random_.below(4) > 0) {
            values.base_color = {random_.uniform(0, 1), random_.uniform(0, 1), random_.uniform(0, 1)};
            values.roughness = random_.uniform(0.1f, 1);
            if (random_.below(2)) values.metallic = random_.uniform(0, 1);
            if (random_.below(2))
                if (const float light = random_.uniform(0, 1); may_emit_) values.emissive = glm::vec3(light);
        }
        materials_[material] = values;
        state.set_material(material, values);
    }

    const RandomClip& clip_;
    bool may_emit_;
    Random random_;
    // In force.
    std::map<NodeId, glm::dmat4> transforms_;
    std::map<NodeId, bool> visibilities_;
    std::map<ObjectId, std::vector<float>> weights_;
    std::map<ObjectId, std::shared_ptr<const scene::DeformedMesh>> shapes_;
    std::map<scene::LightId, scene::Light> lights_;
    std::map<scene::MaterialId, scene::Material> materials_;
};

}   // namespace gnomon::test
