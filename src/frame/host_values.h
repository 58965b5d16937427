// SPDX-License-Identifier: Apache-2.0
#pragma once
// The values that a host has handed over instead of a scene's own, and the scene with the declarations that they need.
//
// Values are kept until others come or they are released. What a host declared fixed and changes all the same is
// promoted: scene() is then another scene, in which it is declared so, and stays declared. Values that no cache can
// follow (the surface class of a material, the type of a light) make another scene as well. So an engine that is given
// scene() and the values renders the same images as one made anew.
//
// Cost of a change: logarithmic in the number of values in force; of a promotion: the scene's lists.

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "scene/state.h"

namespace gnomon::frame {

class HostValues {
 public:
    /// Begins with a scene as it is, without values.
    explicit HostValues(std::shared_ptr<const scene::Scene> scene);

    /// The scene to render: the given one, or one that declares what was promoted.
    const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }

    // Each stores a value, or removes it where none is given. Nothing is noted where it equals the value in force.
    // Values must be valid for the scene: indices, lengths, finite numbers.
    void set_transform(scene::NodeId node, const glm::dmat4* local);
    void set_visible(scene::NodeId node, const bool* visible);
    /// @pre the node has a mesh with triangles; so for the next
    void set_vertices(scene::NodeId node, std::shared_ptr<const scene::DeformedMesh> vertices);
    void set_weights(scene::NodeId node, const std::vector<float>* weights);
    void set_light(scene::LightId light, const scene::Light* values);
    void set_material(scene::MaterialId material, const scene::Material* values);
    /// Declares a node as one that moves or deforms: for promotions of an earlier scene.
    void promote(scene::NodeId node, bool deforms);
    /// Call after a frame's changes: makes another scene if they need one.
    void settle();

    /// Hands all values to a new state of scene(); it takes them at its next advance().
    void apply_all(scene::SceneState& state) const;
    /// Hands over those that changed since the last call of this or of apply_all().
    void apply_changes(scene::SceneState& state) const;
    void forget_changes();

    /// Copies the values of parts that another scene has as well; promoted nodes stay promoted.
    /// @param node, light, material  a part's index in the other scene; scene::none: it has none
    struct Mapping {
        std::function<std::uint32_t(std::uint32_t)> node, light, material;
    };
    void copy_to(HostValues& other, const Mapping& mapping) const;

    const glm::dmat4* transform(scene::NodeId node) const;
    /// Nodes that were promoted: they may move, or deform.
    const std::map<scene::NodeId, bool>& promoted() const { return promoted_; }
    scene::ObjectId object_at(scene::NodeId node) const { return object_at_[node]; }

 private:
    bool must_promote_to_move(scene::NodeId node) const;
    void find_objects();
    void apply_transform(scene::SceneState& state, scene::NodeId node) const;
    void apply_visible(scene::SceneState& state, scene::NodeId node) const;
    void apply_vertices(scene::SceneState& state, scene::NodeId node) const;
    void apply_weights(scene::SceneState& state, scene::NodeId node) const;
    void apply_light(scene::SceneState& state, scene::LightId light) const;
    void apply_material(scene::SceneState& state, scene::MaterialId material) const;

    std::shared_ptr<const scene::Scene> given_, scene_;
    std::vector<scene::ObjectId> object_at_;   // by node
    std::map<scene::NodeId, bool> promoted_;   // true: deforms, too
    bool must_remake_ = false;

    std::map<scene::NodeId, glm::dmat4> transforms_;
    std::map<scene::NodeId, bool> visible_;
    std::map<scene::NodeId, std::shared_ptr<const scene::DeformedMesh>> vertices_;
    std::map<scene::NodeId, std::vector<float>> weights_;
    std::map<scene::LightId, scene::Light> lights_;
    std::map<scene::MaterialId, scene::Material> materials_;
    // Whose values changed since they were last handed to a state.
    std::set<std::uint32_t> changed_transforms_, changed_visible_, changed_vertices_, changed_weights_, changed_lights_,
        changed_materials_;
};

}   // namespace gnomon::frame
