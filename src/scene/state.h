// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene at a time, and mobility: what changed since the time before.
//
// advance() costs what moves: the tracks that change between the two times, and the nodes below those that moved. What
// stands still is not looked at, not even to find that it stands still (`touched_nodes` counts and proves it).

#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "scene/deform.h"
#include "scene/scene.h"

namespace gnomon::scene {

/// What changed between the last two times. Ids ascend within a list. Valid until the next advance().
struct FrameChanges {
    std::vector<ObjectId> moved;         // world matrix differs (in bits) and the object is visible
    std::vector<ObjectId> deformed;      // vertices differ
    std::vector<ObjectId> appeared;      // visible now, not before
    std::vector<ObjectId> vanished;      // the reverse
    std::vector<ObjectId> started;       // moved or deformed now, not in the step before
    std::vector<ObjectId> stopped;       // the reverse
    std::vector<GroupId> groups_moved;   // rigid groups whose anchor moved, or that appeared
    std::vector<LightId> lights_moved;   // position, direction or visibility differ
    std::vector<LightId> lights_started;
    std::vector<LightId> lights_stopped;
    bool camera_moved = false;         // any camera's
    std::uint64_t touched_nodes = 0;   // tracks evaluated + nodes visited

    bool anything() const
    {
        return !moved.empty() || !deformed.empty() || !appeared.empty() || !vanished.empty() || !lights_moved.empty();
    }
};

class SceneState {
 public:
    SceneState(std::shared_ptr<const Scene> scene, double time);
    ~SceneState();

    const Scene& scene() const { return *scene_; }
    std::shared_ptr<const Scene> shared_scene() const { return scene_; }
    double time() const { return time_; }

    /// Moves to another time, earlier or later, and says what differs.
    const FrameChanges& advance(double time);
    const FrameChanges& changes() const { return changes_; }

    const glm::dmat4& world(NodeId node) const { return world_[node]; }
    bool visible(NodeId node) const { return node_visible_[node]; }
    glm::mat4 object_matrix(ObjectId object) const;
    bool object_visible(ObjectId object) const { return node_visible_[scene_->objects[object].node]; }
    /// Visible, and not squeezed flat by what moves it: such things meet no ray, and so are not drawn either and cast
    /// no shadow. What cannot move may be flat.
    bool object_there(ObjectId object) const;
    bool group_visible(GroupId group) const { return node_visible_[scene_->groups[group].anchor]; }
    const LightState& light(LightId light) const { return lights_[light]; }
    /// For deforming objects only.
    const DeformedMesh& deformed(ObjectId object) const;

    /// Moves one object by hand (the viewer): its node's transform is `local` from now on, whatever its track says.
    /// Takes effect at the next advance(). nullptr gives it back to its track.
    void override_transform(NodeId node, const glm::dmat4* local);

 private:
    struct Index;
    void evaluate_node(NodeId node);
    void visit_below(NodeId root);
    void note_lists();
    LightState light_at(LightId light) const;
    void deform(ObjectId object);
    const std::vector<glm::mat4>& joints_of(SkinId skin);

    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Index> index_;   // which tracks change when; which lights, cameras, objects hang on a node
    double time_ = 0;
    std::vector<glm::dmat4> local_, world_;
    std::vector<char> node_visible_;
    std::vector<LightState> lights_;
    std::vector<DeformedMesh> deformed_;         // by slot
    std::vector<std::uint32_t> deformed_slot_;   // by object; none for rigid ones
    struct Joints {
        std::vector<glm::mat4> matrices;   // world times inverse bind, of all that the skin bends
        std::uint32_t step = none;         // that they are of
    };
    std::vector<Joints> joints_;   // by skin
    std::unordered_map<NodeId, glm::dmat4> overrides_;
    std::vector<NodeId> overrides_changed_;
    FrameChanges changes_;
    std::vector<ObjectId> active_before_, active_now_;   // moved or deformed, last step and this
    std::vector<LightId> lights_active_before_;
    std::vector<std::uint32_t> visited_;   // by node: the step that last visited it
    std::uint32_t step_ = 0;
    std::vector<std::uint32_t> due_, stack_;   // scratch, kept for its memory
    std::vector<ObjectId> to_deform_;
    std::vector<SkinId> skins_due_;
    std::vector<std::uint32_t> skin_due_;   // by skin: the step that last listed it
};

}   // namespace gnomon::scene
