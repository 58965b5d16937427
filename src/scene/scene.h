// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene as a file or a host describes it, immutable after `finish`. SceneState evaluates it at a time. Copies share
// meshes and textures.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/math.h"
#include "gnomon/scene_parts.h"
#include "gnomon/types.h"
#include "scene/camera_fit.h"
#include "scene/light.h"
#include "scene/material.h"
#include "scene/mesh.h"
#include "scene/shared_list.h"
#include "scene/track.h"

namespace gnomon::scene {

struct Node {
    std::string name;
    NodeId parent = none;   // always a smaller index than the node's own
    glm::dmat4 local{1};    // used where there is no track
    std::shared_ptr<const TransformTrack> transform;
    std::shared_ptr<const VisibilityTrack> visibility;   // hides everything below it, too
    std::shared_ptr<const WeightsTrack> weights;         // of the mesh on this node
    bool animated = false;   // may move or be hidden: the file or the host declares it so (AFF `x`, a target of a glTF
                             // channel)
    bool deforms = false;    // a host hands over the vertices or the morph weights of its mesh
    MeshId mesh = none;
    SkinId skin = none;
    std::vector<float> morph_weights;   // replace the mesh's defaults if not empty
    bool by_default = false;            // added by the library, not by the file
    Box3 reach;   // the part of the world that its mesh is expected to move in, beside where tracks take it

    /// Whether it may move or be hidden: what is below moves with it as one body.
    bool may_move() const { return animated || transform || visibility; }
};

struct CameraTrack;

struct Skin {
    std::string name;
    std::vector<NodeId> joints;
    std::vector<glm::dmat4> inverse_bind;   // one per joint
};

/// A camera looks along its node's -Z, with +Y up.
struct Camera {
    std::string name;
    NodeId node = none;
    double vertical_fov = 0.8;        // whole angle, radians; perspective
    double orthographic_height = 0;   // whole height of the view in scene units; > 0: orthographic instead
    double near = 0.01;
    double far = 0;                             // 0: infinite
    Size resolution{};                          // the file's own, if given
    std::shared_ptr<const CameraTrack> track;   // value_tracks.h; null: the values do not change by themselves
    glm::dvec2 shift{0};                        // of the image plane, right and up, in heights of the image
    // These replace the projection above; the first that is given counts.
    std::optional<glm::dmat4> projection;   // is_projection(); with near and far of its own
    std::optional<Intrinsics> intrinsics;
    /// Of a camera that the library added: its node stands where it shows the scene whole at CameraFit::k_node_aspect,
    /// and images of other aspects are seen from elsewhere along the same direction.
    std::shared_ptr<const CameraFit> fit;
};

/// Whether a matrix from camera to clip space (OpenGL's) is a perspective or an orthographic projection, without skew.
bool is_projection(const glm::dmat4& matrix);

/// An animation of a file. Files may hold several, of which some play.
struct Clip {
    std::string name;
    double start = 0, end = 0;   // of its keys, in seconds
    bool plays = false;
};

/// The limit on the frames of a clip; later frames are dropped.
constexpr int k_most_frames = 1'000'000'001;

/// Frame i (from 1) of a clip.
struct Timeline {
    double start = 0;   // seconds
    double end = 0;
    int frames = 1;            // of the whole clip, at `fps`
    double fps = 24;           // video rate
    bool own_frames = false;   // AFF: frames are fixed by the file; --fps then changes only the rate of the video

    double time_of(int frame) const;
    /// The same clip sampled at another rate (glTF). AFF keeps its frames and uses the rate for the video.
    Timeline at_rate(double new_fps) const;
    /// The number of frames, at a rate, of a clip that lasts so many seconds: the last one is not beyond its end. Times
    /// that were rounded to single precision count as the frames that they stand for.
    static int frames_in(double seconds, double rate);
};

/// An instance of a mesh.
struct Object {
    NodeId node = none;
    MeshId mesh = none;
    SkinId skin = none;
    GroupId group = none;      // none: static, or deforming
    bool dynamic = false;      // below an animated node, skinned, morphing, or declared so: may change during the clip
    bool deforming = false;    // its vertices may change
    bool by_default = false;   // its node is: it does not count, and bounds leave it out
    bool removed = false;      // a host removed it; see scene/continuation.h. It is never visible, its node is any
};

/// Dynamic rigid objects with the same nearest animated ancestor; they always move together.
struct RigidGroup {
    NodeId anchor = none;
    std::vector<ObjectId> objects;
};

struct Statistics {
    std::uint64_t triangles = 0, triangles_dynamic = 0;   // instances counted
    std::uint64_t objects = 0, objects_dynamic = 0;
};

class Scene {
 public:
    std::string name;
    std::vector<Node> nodes;
    SharedList<Mesh> meshes;
    std::vector<Skin> skins;
    std::vector<Material> materials;
    SharedList<Texture> textures;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    Background background;
    glm::vec3 ambient{0};   // AFF `am`, or the fill light of a closed room; used only with indirect light off
    Timeline timeline;
    std::vector<Clip> clips;             // in the file's order
    std::vector<std::string> variants;   // names of the sets of materials that the file offers
    std::vector<std::string> warnings;

    // Computed by finish():
    std::vector<Object> objects;   // in node order
    std::vector<RigidGroup> groups;
    std::vector<std::uint32_t> child_begin;   // children of node n: child_list[child_begin[n] ... child_begin[n + 1])
    std::vector<NodeId> child_list;
    std::vector<std::uint32_t> track_nodes;   // nodes with a transform, visibility or weights track

    /// Adds a node and returns its index.
    NodeId add_node(std::string node_name, NodeId parent, const glm::dmat4& local = glm::dmat4(1));

    /// Completes the scene: checks it, sorts triangles by surface class, finds objects and rigid groups. Call after
    /// everything was added, and again after a finished scene or a copy of it was edited: everything computed is
    /// computed anew. Meshes whose triangles are sorted already stay shared. Does not add a default light or camera:
    /// see add_defaults.
    void finish();

    Statistics statistics() const;
    /// Bounding box of everything visible at a time (rest shape for deforming meshes).
    Box3 bounds(double time) const;

    /// World matrices of all nodes, and of one by walking up its ancestors: for tests and set-up, too slow for every
    /// frame.
    std::vector<glm::dmat4> world_matrices(double time) const;
    glm::dmat4 world_matrix(NodeId node, double time) const;
};

/// Adds a sky and a sun, or the light of a room, to a scene without lights whose emission shines on less than a quarter
/// of its surfaces, and a camera that frames the scene to a scene without cameras; each adds a warning. The result
/// depends on the scene only. Call after finish().
void add_default_light(Scene& scene);
void add_default_camera(Scene& scene);

}   // namespace gnomon::scene
