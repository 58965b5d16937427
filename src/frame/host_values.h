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
#include <optional>
#include <vector>

#include "scene/state.h"

namespace gnomon::frame {

/// The values of one kind: those in force, and those before the last changes.
template <class T>
class ValueList {
 public:
    /// Stores a value under a key, or removes the one that is there.
    /// @return whether that changed anything
    template <class Same>
    bool store(std::uint32_t key, const T* value, const Same& same)
    {
        const auto at = now_.find(key);
        if (!value && at == now_.end()) return false;
        if (value && at != now_.end() && same(at->second, *value)) return false;
        changed_.try_emplace(key, at == now_.end() ? std::optional<T>() : std::optional<T>(at->second));
        if (value)
            now_.insert_or_assign(key, *value);
        else
            now_.erase(at);
        return true;
    }
    /// The value in force; null: the scene's own.
    const T* now(std::uint32_t key) const
    {
        const auto at = now_.find(key);
        return at == now_.end() ? nullptr : &at->second;
    }
    /// The value that was in force before the changes.
    const T* before(std::uint32_t key) const
    {
        const auto at = changed_.find(key);
        if (at == changed_.end()) return now(key);
        return at->second ? &*at->second : nullptr;
    }
    const std::map<std::uint32_t, T>& all() const { return now_; }
    const std::map<std::uint32_t, std::optional<T>>& changed() const { return changed_; }
    const std::vector<std::uint32_t>& changed_last() const { return changed_last_; }
    /// Makes the values in force those before the changes to come.
    void settle()
    {
        changed_last_.clear();
        for (const auto& [key, value] : changed_) changed_last_.push_back(key);
        changed_.clear();
    }

 private:
    std::map<std::uint32_t, T> now_;
    std::map<std::uint32_t, std::optional<T>> changed_;   // the values before
    std::vector<std::uint32_t> changed_last_;             // the changes before those
};

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
    /// The values of a node when the shutter closes; those that were set above are then those of its opening. What is
    /// left out does not change meanwhile. Call after the others.
    struct Closing {
        std::optional<glm::dmat4> transform;
        std::vector<glm::vec3> positions;   // as many as those of the vertices, or none
        std::vector<float> weights;         // likewise
    };
    void set_closing(scene::NodeId node, const Closing* closing);
    /// The same for a light and a material; null: it does not change meanwhile. A material must be the same to rays
    /// (scene::same_to_rays) as that of the opening.
    void set_closing_light(scene::LightId light, const scene::Light* values);
    void set_closing_material(scene::MaterialId material, const scene::Material* values);
    /// The fraction of the shutter's opening at which a frame's image without blur is: 0 where it does not open.
    void show_at(double fraction) { shown_at_ = fraction; }
    /// Declares a node as one that moves or deforms: for promotions of an earlier scene.
    void promote(scene::NodeId node, bool deforms);
    /// Call after a frame's changes: makes another scene if they need one.
    void settle();

    /// Hands all values to a new state of scene(); it takes them at its next advance().
    void apply_all(scene::SceneState& state) const;
    /// The same to a state that has the values of an earlier scene (SceneState::continue_with()).
    void replace_all(scene::SceneState& state) const;
    /// Hands over those that changed since end_frame().
    void apply_changes(scene::SceneState& state) const;
    /// Hands the values at a fraction of the shutter's opening to a state that has the others.
    void apply_pose(scene::SceneState& state, double fraction) const;
    /// Call when a frame was rendered.
    void end_frame();
    /// Hands the transforms, visibility, vertices and weights of the frame before to a second state: to a new one all
    /// of them, else those that differ from the frame before that one.
    void apply_before(scene::SceneState& state, bool is_new) const;
    /// The same to a second state that has the values of an earlier scene.
    void replace_before(scene::SceneState& state) const;

    /// Copies the values of parts that another scene has as well; promoted nodes stay promoted.
    /// @param node, light, material  a part's index in the other scene; scene::none: it has none
    struct Mapping {
        std::function<std::uint32_t(std::uint32_t)> node, light, material;
    };
    void copy_to(HostValues& other, const Mapping& mapping) const;

    /// Nodes that were promoted: they may move, or deform.
    const std::map<scene::NodeId, bool>& promoted() const { return promoted_; }
    scene::ObjectId object_at(scene::NodeId node) const { return object_at_[node]; }

 private:
    bool must_promote_to_move(scene::NodeId node) const;
    bool must_promote_to_deform(scene::NodeId node) const;
    void find_objects();
    // Both call act(setter of a state, the values of one kind): for transforms, visibility, vertices and weights, and
    // for lights and materials, too.
    template <class Act>
    void each_kind_of_geometry(scene::SceneState& state, const Act& act) const;
    template <class Act>
    void each_kind(scene::SceneState& state, const Act& act) const;
    struct Closings {
        std::map<scene::NodeId, Closing> nodes;
        std::map<scene::LightId, scene::Light> lights;
        std::map<scene::MaterialId, scene::Material> materials;
    };
    template <class Value>
    void pose_nodes(scene::SceneState& state, const Closings& closings, double fraction, const Value& value_of) const;
    void pose_looks(scene::SceneState& state, const Closings& closings, double fraction) const;
    void hand_over(scene::SceneState& state, scene::LightId light, const scene::Light* values) const;
    void hand_over(scene::SceneState& state, scene::MaterialId material, const scene::Material* values) const;

    std::shared_ptr<const scene::Scene> given_, scene_;
    std::vector<scene::ObjectId> object_at_;   // by node
    std::map<scene::NodeId, bool> promoted_;   // true: deforms, too
    bool must_remake_ = false;

    ValueList<glm::dmat4> transforms_;   // by node, as the next three
    ValueList<bool> visible_;
    ValueList<std::shared_ptr<const scene::DeformedMesh>> vertices_;
    ValueList<std::vector<float>> weights_;
    ValueList<scene::Light> lights_;
    ValueList<scene::Material> materials_;
    Closings closings_, closings_before_, closings_earlier_;   // of this frame, the one before, and that before it
    double shown_at_ = 0;
};

}   // namespace gnomon::frame
