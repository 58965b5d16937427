// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene as a file describes it: never changed after `finish`. What it looks like at a time is SceneState's to say.

#include <memory>
#include <string>
#include <vector>

#include "base/math.h"
#include "gnomon/types.h"
#include "scene/light.h"
#include "scene/material.h"
#include "scene/mesh.h"
#include "scene/track.h"

namespace gnomon::scene {

struct Node {
    std::string name;
    NodeId parent = none;   // always a smaller index than the node's own
    glm::dmat4 local{1};    // used where there is no track
    std::shared_ptr<const TransformTrack> transform;
    std::shared_ptr<const VisibilityTrack> visibility;   // hides everything below, too
    std::shared_ptr<const WeightsTrack> weights;         // of the mesh on this node
    bool animated = false;   // the file says it can move (AFF `x`, a target of a glTF channel)
    MeshId mesh = none;
    SkinId skin = none;
    std::vector<float> morph_weights;   // instead of the mesh's own defaults; empty: those
};

struct Skin {
    std::string name;
    std::vector<NodeId> joints;
    std::vector<glm::dmat4> inverse_bind;   // one a joint
};

/// Looks along its node's -Z, +Y up.
struct Camera {
    std::string name;
    NodeId node = none;
    double vertical_fov = 0.8;        // whole angle, radians; perspective
    double orthographic_height = 0;   // whole height of the view in scene units; > 0: orthographic instead
    double near = 0.01;
    double far = 0;      // 0: unlimited
    Size resolution{};   // the file's own, if it has one
};

/// Of a clip; what comes after them is left out.
constexpr int k_most_frames = 1'000'000'001;

/// Frame i (from 1) of a clip.
struct Timeline {
    double start = 0;   // seconds
    double end = 0;
    int frames = 1;            // of the whole clip, at `fps`
    double fps = 24;           // video rate
    bool own_frames = false;   // AFF: the file numbers its frames itself; --fps then changes the video's rate alone

    double time_of(int frame) const;
    /// The same clip sampled at another rate (glTF); AFF keeps its frames and takes the rate for the video.
    Timeline at_rate(double new_fps) const;
};

/// An instance of a mesh.
struct Object {
    NodeId node = none;
    MeshId mesh = none;
    SkinId skin = none;
    GroupId group = none;     // none: static, or deforming
    bool dynamic = false;     // below an animated node, skinned, or morphing: may change during the clip
    bool deforming = false;   // its vertices may change
};

/// Dynamic rigid objects below one animated node and no deeper one: they share every movement.
struct RigidGroup {
    NodeId anchor = none;
    std::vector<ObjectId> objects;
};

struct Statistics {
    std::uint64_t triangles = 0, triangles_dynamic = 0;   // instanced
    std::uint64_t objects = 0, objects_dynamic = 0;
};

class Scene {
 public:
    std::string name;
    std::vector<Node> nodes;
    std::vector<Mesh> meshes;
    std::vector<Skin> skins;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    Background background;
    glm::vec3 ambient{0};   // AFF `am`, or the fill of a closed room; with indirect light off alone
    Timeline timeline;
    std::vector<std::string> warnings;

    // Made by finish():
    std::vector<Object> objects;   // in node order
    std::vector<RigidGroup> groups;
    std::vector<std::uint32_t> child_begin;   // children of node n: child_list[child_begin[n] ... child_begin[n + 1])
    std::vector<NodeId> child_list;
    std::vector<std::uint32_t> track_nodes;   // nodes with a transform, visibility or weights track

    /// Adds a node and returns its index.
    NodeId add_node(std::string node_name, NodeId parent, const glm::dmat4& local = glm::dmat4(1));

    /// Call once, when all is in place: checks, sorts triangles by surface class, finds objects and rigid groups.
    /// Does not add default light or camera: see add_defaults.
    void finish();

    Statistics statistics() const;
    /// Around everything visible at a time (rest shape for deforming meshes).
    Box3 bounds(double time) const;

    /// World matrices of all nodes, and of one by walking up: for tests and set-up, not for every frame.
    std::vector<glm::dmat4> world_matrices(double time) const;
    glm::dmat4 world_matrix(NodeId node, double time) const;
};

/// Gives a scene without lights a sky and a sun, and one without cameras a camera that frames it from a pleasant angle;
/// each adds a warning. Functions of the scene alone. Call after finish().
void add_default_light(Scene& scene);
void add_default_camera(Scene& scene);

}   // namespace gnomon::scene
