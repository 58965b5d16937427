// SPDX-License-Identifier: Apache-2.0
#pragma once
// The state of a scene at a time: transforms, visibility, lights and deformed vertices; which objects are dynamic; and
// what changed since the previous time.
//
// This is the only place that decides what is dynamic. Caches read is_dynamic(), dynamic_objects() and the lists of
// FrameChanges, and keep no bookkeeping of their own about it.
//
// A user or a host may override what tracks and the scene's description give: transforms, visibility, morph weights,
// vertices, and the values of lights and materials. The state owns a copy of the scene (which shares meshes and
// textures); only the values of lights, materials and cameras in it ever change: by tracks and overrides, and only in
// advance().
//
// Cost of advance(): the tracks that change between the two times, what was overridden with other values, and the nodes
// below those that moved. Objects at rest are not visited; `touched_nodes` counts the visits.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "scene/deform.h"
#include "scene/scene.h"
#include "scene/scene_bounds.h"

namespace gnomon::scene {

struct Continuation;

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
    std::vector<ObjectId> added;       // by continue_with() before this step: their numbers are new, or those of
                                       // objects that were removed earlier and had nothing in common with them
    std::vector<ObjectId> removed;     // likewise; those that were visible are in `vanished`, too
    std::vector<ObjectId> promoted;    // static objects that a user override moved in this step: dynamic from now on
    std::vector<ObjectId> separated;   // objects that a user override moved against their rigid group in this step: no
                                       // members of it from now on
    std::vector<ObjectId> started;     // moved or deformed now, not in the step before
    std::vector<ObjectId> stopped;     // the reverse
    std::vector<GroupId> groups_moved;   // rigid groups whose anchor moved, or that appeared
    std::vector<LightId> lights_moved;   // position, direction or visibility differ, or cone, range, falloff or profile
    std::vector<LightId> lights_relit;   // the colour differs; some may be in lights_moved, too
    std::vector<MaterialId> materials_changed;   // any value differs
    std::vector<LightId> lights_started;
    std::vector<LightId> lights_stopped;
    bool camera_moved = false;         // any camera, or its field of view differs
    std::uint64_t touched_nodes = 0;   // tracks evaluated and nodes visited

    bool anything() const
    {
        return !changed.empty() || !lights_moved.empty() || !lights_relit.empty() || !materials_changed.empty();
    }
    /// Nothing differs from the step before, and nothing came to rest in this one.
    bool is_still() const
    {
        return !anything() && added.empty() && removed.empty() && promoted.empty() && separated.empty() &&
               groups_moved.empty() && stopped.empty() && lights_stopped.empty();
    }
    /// Whether the light moved or was relit: what it illuminates must be computed anew.
    bool light_changed(LightId light) const;
};

class SceneState {
 public:
    /// Copies the scene; meshes and textures stay shared. @pre not null
    SceneState(const std::shared_ptr<const Scene>& scene, double time);
    ~SceneState();

    /// The state's own copy of the scene, with the present values of lights, materials and cameras. It stays in place.
    const Scene& scene() const { return *scene_; }
    std::shared_ptr<const Scene> shared_scene() const { return scene_; }
    double time() const { return time_; }

    /// Replaces the scene by one with other parts. The next advance() lists what was added and removed. Overrides of
    /// nodes that were replaced are gone; others stay in force.
    /// @param next  made from base()
    /// @pre nothing was promoted or separated
    void continue_with(const Continuation& next);
    /// The scene of the constructor or of continue_with(), with the values of lights and materials that it came with.
    const std::shared_ptr<const Scene>& base() const { return base_; }
    /// The object at a node; `none` if there is none.
    ObjectId object_at(NodeId node) const;

    /// Moves to another time, earlier or later, and returns what differs.
    const FrameChanges& advance(double time);
    const FrameChanges& changes() const { return changes_; }

    const glm::dmat4& world(NodeId node) const { return world_[node]; }
    const glm::dmat4& local(NodeId node) const { return local_[node]; }   // to the parent's space
    bool visible(NodeId node) const { return node_visible_[node]; }
    glm::mat4 object_matrix(ObjectId object) const;
    bool object_visible(ObjectId object) const
    {
        const Object& o = scene_->objects[object];
        return !o.removed && node_visible_[o.node];
    }
    /// Whether rays can hit the object, and images and shadows show it: it is visible, and no singular transform
    /// applies to it. A static object is there whatever its transform (its vertices are transformed as they are), and
    /// so is a flat member of a rigid group whose anchor is regular.
    bool object_there(ObjectId object) const;
    bool group_visible(GroupId group) const
    {
        const RigidGroup& g = scene_->groups[group];
        return !g.objects.empty() && node_visible_[g.anchor];
    }
    const LightState& light(LightId light) const { return lights_[light]; }
    /// For deforming objects only.
    const DeformedMesh& deformed(ObjectId object) const;

    /// Whether an object may move or deform in the clip, or was ever promoted by a user override.
    bool is_dynamic(ObjectId object) const { return dynamic_index_[object] != none; }
    /// All dynamic objects: those of the clip, ascending; then promoted and added ones, as they came. It only grows,
    /// and only in steps with FrameChanges::promoted or added. Removed ones stay in it.
    const std::vector<ObjectId>& dynamic_objects() const { return dynamic_objects_; }
    /// The object's index in dynamic_objects(), which never changes; `none` for static objects.
    std::uint32_t dynamic_index(ObjectId object) const { return dynamic_index_[object]; }
    /// The rigid group with which a dynamic object moves; `none` for deforming, promoted, separated and static ones.
    GroupId group_of(ObjectId object) const { return group_of_[object]; }

    /// Objects that a user override promoted or separated from their group, in order; ascending within a step.
    const std::vector<ObjectId>& taken_objects() const { return taken_objects_; }

    /// What light views and light maps cover: the bounds over the clip; where overrides take objects that cast shadows
    /// outside of these, larger ones, in steps. A function of the scene and the present state alone. Computed when it
    /// is first asked for, then followed by advance(): O(what changed + objects outside). Not thread-safe.
    const SceneBounds& present_bounds() const;

    // Overrides by a user or a host. Each takes effect at the next advance(). One that equals what is in force, bit for
    // bit, changes nothing and costs nothing there.

    /// The node's transform is `local` from now on instead of its track's. nullptr removes the override. A static
    /// object that moves by it is promoted, and stays dynamic even after the override is removed.
    void override_transform(NodeId node, const glm::dmat4* local);
    /// Shows or hides the node, and with it everything below, instead of its track. nullopt removes the override. A
    /// static object that vanishes by it is promoted.
    void override_visibility(NodeId node, std::optional<bool> visible);
    /// The morph weights of a deforming object instead of those of its track or file; as many as its mesh has targets.
    /// nullopt removes the override. A static morph that changes by it is promoted.
    void override_weights(ObjectId object, std::optional<std::vector<float>> weights);
    /// The vertices of a deforming object instead of those that its mesh's keys, targets and skin give; in object
    /// space, but in world space if it is skinned. nullptr removes the override. Normals and tangents may be left out:
    /// see complete_vertices(). The mesh must not be written to afterwards.
    void override_vertices(ObjectId object, std::shared_ptr<const DeformedMesh> vertices);
    /// The values of a light from now on, instead of those of its track. Its name, node, type, track, of_environment,
    /// by_default and of_surface stay as they are.
    void set_light(LightId light, const Light& values);
    /// The values of a material from now on, instead of those of its track; its name and track stay.
    /// @pre same_to_rays() to the present one
    void set_material(MaterialId material, const Material& values);
    /// The light has its own values again: those of its track, and `rest` where that gives none.
    void release_light(LightId light, const Light& rest);
    /// The same for a material. @pre `rest` is same_to_rays() to the present one
    void release_material(MaterialId material, const Material& rest);

    /// Which overrides a host has, by node, light and material.
    struct Overridden {
        std::function<bool(std::uint32_t)> transform, visibility, weights, vertices, light, material;
    };
    /// Removes the overrides that a host does not have; lights and materials get the values of base() or their tracks.
    void keep_overrides(const Overridden& kept);

    /// Whether an override gives the object another place or shape than its tracks and its description do now.
    bool displaced(ObjectId object) const;
    /// Whether any override of transforms, weights or vertices is in force.
    bool any_displaced() const { return !transforms_.empty() || !weights_.empty() || !vertices_.empty(); }

 private:
    struct Index;
    void collect_roots(double before, std::vector<NodeId>& roots);
    void collect_shapes(double before);
    void collect_values(double before);
    void apply_values();
    void apply_camera_tracks();
    void note_light(LightId light, const Light& values);
    void note_material(MaterialId material, const Material& values);
    bool node_displaced(NodeId node) const;
    std::vector<float> tracked_weights(ObjectId object) const;
    void evaluate_node(NodeId node);
    void visit_below(NodeId root);
    void note_lists();
    void note_overridden();
    bool rides_along(ObjectId object) const;
    LightState light_at(LightId light) const;
    void deform(ObjectId object);
    void deform_first(ObjectId object);
    const std::vector<glm::mat4>& joints_of(SkinId skin);

    std::shared_ptr<const Scene> base_;
    std::shared_ptr<Scene> scene_;
    std::unique_ptr<Index> index_;   // when tracks change; which lights, cameras and objects belong to a node
    double time_ = 0;
    std::vector<glm::dmat4> local_, world_;
    std::vector<char> shown_;          // by node: its own visibility
    std::vector<char> node_visible_;   // and that of its ancestors
    std::vector<LightState> lights_;
    std::vector<DeformedMesh> deformed_;         // by slot
    std::vector<std::uint32_t> deformed_slot_;   // by object; none for those that do not deform
    struct Joints {
        std::vector<glm::mat4> matrices;   // world times inverse bind matrix, for all objects with this skin
        std::uint32_t step = none;         // in which they were computed
    };
    std::vector<Joints> joints_;   // by skin
    // Overrides in force, and those that the next advance() applies.
    std::unordered_map<NodeId, glm::dmat4> transforms_;
    std::unordered_map<NodeId, bool> visibilities_;
    std::unordered_map<ObjectId, std::vector<float>> weights_;
    std::unordered_map<ObjectId, std::shared_ptr<const DeformedMesh>> vertices_;
    std::vector<NodeId> transforms_due_, visibilities_due_;
    std::vector<ObjectId> shapes_due_;
    std::set<LightId> lights_held_;   // overridden, so that their tracks do not count; so for the next
    std::set<MaterialId> materials_held_;
    std::map<LightId, Light> lights_due_;
    std::map<MaterialId, Material> materials_due_;
    std::vector<ObjectId> strays_;                    // members whose visibility differs from their group's
    mutable std::unique_ptr<PresentBounds> bounds_;   // null until asked for
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
    // By continue_with(), for the next advance().
    std::vector<NodeId> replaced_;
    std::vector<ObjectId> added_, removed_, vanished_;
};

}   // namespace gnomon::scene
