// SPDX-License-Identifier: Apache-2.0
#pragma once
// The state of a scene at a time: transforms, visibility, lights and deformed vertices; which objects are dynamic; and
// what changed since the previous time.
//
// This is the only place that decides what is dynamic. Caches read is_dynamic(), dynamic_objects() and the lists of
// FrameChanges, and keep no bookkeeping of their own about it.
//
// Cost of advance(): the tracks that change between the two times and the nodes below those that moved. Objects at rest
// are not visited; `touched_nodes` counts the visits.

#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "scene/deform.h"
#include "scene/scene.h"

namespace gnomon::scene {

/// What changed between the last two times. Ids ascend within each list. Valid until the next advance().
///
/// The vertices, world matrix and presence (SceneState::object_there) of a visible object, and its visibility, differ
/// between two steps only if it is in `changed`.
struct FrameChanges {
    std::vector<ObjectId> moved;       // visible, and the world matrix differs in bits, or its group's became singular
                                       // or regular again
    std::vector<ObjectId> deformed;    // visible, and the vertices differ
    std::vector<ObjectId> appeared;    // visible now, not in the step before
    std::vector<ObjectId> vanished;    // the reverse
    std::vector<ObjectId> changed;     // in one or more of the four lists above; each object once
    std::vector<ObjectId> promoted;    // static objects that a user override moved in this step: dynamic from now on
    std::vector<ObjectId> separated;   // objects that a user override moved against their rigid group in this step: no
                                       // members of it from now on
    std::vector<ObjectId> started;     // moved or deformed now, not in the step before
    std::vector<ObjectId> stopped;     // the reverse
    std::vector<GroupId> groups_moved;   // rigid groups whose anchor moved, or that appeared
    std::vector<LightId> lights_moved;   // position, direction or visibility differ
    std::vector<LightId> lights_started;
    std::vector<LightId> lights_stopped;
    bool camera_moved = false;         // any camera
    std::uint64_t touched_nodes = 0;   // tracks evaluated and nodes visited

    bool anything() const { return !changed.empty() || !lights_moved.empty(); }
};

class SceneState {
 public:
    SceneState(std::shared_ptr<const Scene> scene, double time);
    ~SceneState();

    const Scene& scene() const { return *scene_; }
    std::shared_ptr<const Scene> shared_scene() const { return scene_; }
    double time() const { return time_; }

    /// Moves to another time, earlier or later, and returns what differs.
    const FrameChanges& advance(double time);
    const FrameChanges& changes() const { return changes_; }

    const glm::dmat4& world(NodeId node) const { return world_[node]; }
    bool visible(NodeId node) const { return node_visible_[node]; }
    glm::mat4 object_matrix(ObjectId object) const;
    bool object_visible(ObjectId object) const { return node_visible_[scene_->objects[object].node]; }
    /// Whether rays can hit the object, and images and shadows show it: it is visible, and no singular transform
    /// applies to it. A static object is there whatever its transform (its vertices are transformed as they are), and
    /// so is a flat member of a rigid group whose anchor is regular.
    bool object_there(ObjectId object) const;
    bool group_visible(GroupId group) const { return node_visible_[scene_->groups[group].anchor]; }
    const LightState& light(LightId light) const { return lights_[light]; }
    /// For deforming objects only.
    const DeformedMesh& deformed(ObjectId object) const;

    /// Whether an object may move or deform in the clip, or was ever promoted by a user override.
    bool is_dynamic(ObjectId object) const { return dynamic_index_[object] != none; }
    /// All dynamic objects: those of the clip, ascending; then promoted ones in order of promotion. It only grows, and
    /// only in steps with FrameChanges::promoted.
    const std::vector<ObjectId>& dynamic_objects() const { return dynamic_objects_; }
    /// The object's index in dynamic_objects(), which never changes; `none` for static objects.
    std::uint32_t dynamic_index(ObjectId object) const { return dynamic_index_[object]; }
    /// The rigid group with which a dynamic object moves; `none` for deforming, promoted, separated and static ones.
    GroupId group_of(ObjectId object) const { return group_of_[object]; }

    /// Objects that a user override promoted or separated from their group, in order; ascending within a step.
    const std::vector<ObjectId>& taken_objects() const { return taken_objects_; }

    /// User override: the node's transform is `local` from now on instead of its track's. nullptr removes the override.
    /// Takes effect at the next advance(). A static object that moves by it is promoted, and stays dynamic even after
    /// the override is removed; an override with the present matrix changes nothing.
    void override_transform(NodeId node, const glm::dmat4* local);

 private:
    struct Index;
    void evaluate_node(NodeId node);
    void visit_below(NodeId root);
    void note_lists();
    void note_overridden();
    bool rides_along(ObjectId object) const;
    LightState light_at(LightId light) const;
    void deform(ObjectId object);
    const std::vector<glm::mat4>& joints_of(SkinId skin);

    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Index> index_;   // when tracks change; which lights, cameras and objects belong to a node
    double time_ = 0;
    std::vector<glm::dmat4> local_, world_;
    std::vector<char> node_visible_;
    std::vector<LightState> lights_;
    std::vector<DeformedMesh> deformed_;         // by slot
    std::vector<std::uint32_t> deformed_slot_;   // by object; none for those that do not deform
    struct Joints {
        std::vector<glm::mat4> matrices;   // world times inverse bind matrix, for all objects with this skin
        std::uint32_t step = none;         // in which they were computed
    };
    std::vector<Joints> joints_;   // by skin
    std::unordered_map<NodeId, glm::dmat4> overrides_;
    std::vector<NodeId> overrides_changed_;
    std::vector<ObjectId> dynamic_objects_;
    std::vector<std::uint32_t> dynamic_index_;   // by object
    std::vector<GroupId> group_of_;              // by object
    FrameChanges changes_;
    std::vector<GroupId> groups_toggled_;                // whose anchor became singular or regular again in this step
    std::vector<ObjectId> active_before_, active_now_;   // moved or deformed in the last step, and in this one
    std::vector<LightId> lights_active_before_;
    std::vector<std::uint32_t> visited_;   // by node: the step that last visited it
    std::uint32_t step_ = 0;
    std::vector<std::uint32_t> due_, stack_;   // scratch
    std::vector<ObjectId> to_deform_;
    std::vector<SkinId> skins_due_;
    std::vector<std::uint32_t> skin_due_;   // by skin: the step that last listed it
    std::vector<ObjectId> taken_objects_;
};

}   // namespace gnomon::scene
