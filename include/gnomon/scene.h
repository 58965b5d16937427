// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes that are loaded from files or built in.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gnomon/error.h"
#include "gnomon/ids.h"
#include "gnomon/scene_parts.h"
#include "gnomon/types.h"

namespace gnomon {

namespace api {
class SceneAccess;
}

/// An animation of a file that may hold several (glTF).
struct AnimationInfo {
    std::string name;            // may be empty
    double start = 0, end = 0;   // of its keys, in seconds
    int frames = 1;              // at the scene's rate
    bool plays = false;          // see LoadOptions::animation
};

/// Statistics of a scene. 'Dynamic' means that it may move or deform at some time in the clip.
struct SceneInfo {
    std::string name;
    std::uint64_t triangles = 0, triangles_dynamic = 0;   // instances counted
    std::uint64_t objects = 0, objects_dynamic = 0;       // instances of meshes
    std::uint64_t meshes = 0, materials = 0, textures = 0;
    std::vector<std::string> lights, cameras;   // names; empty strings for unnamed ones
    int frames = 1;
    double fps = 24;
    double start = 0, end = 0;                 // seconds
    float bounds_low[3]{}, bounds_high[3]{};   // at the start of the clip
    Size resolution{};                         // given by the file; 0 x 0: none
    std::vector<AnimationInfo> animations;     // in the file's order
    std::vector<std::string> variants;         // names of the sets of materials that the file offers
    std::vector<std::string> warnings;
};

/// An immutable scene, loaded or made by a SceneBuilder. Copies are cheap because they share its data. It can be used
/// by several threads at once. Functions that take an id throw UsageError for parts that the scene does not have.
class Scene {
 public:
    // Moves copy as well, so that a moved-from scene remains valid.
    Scene(const Scene&) = default;
    Scene& operator=(const Scene&) = default;

    /// Number of frames in the whole clip, at least 1. Frames are numbered from 1.
    int frame_count() const;
    /// Time of a frame in seconds.
    double time_of(int frame) const;
    /// Video rate in frames a second.
    double fps() const;
    /// Statistics, names and warnings.
    SceneInfo info() const;

    /// Returns the scene sampled at another rate (glTF), or played at it (AFF, whose frames are fixed by the file).
    /// @throws UsageError  the rate is not a positive number, or the clip would have more than 10^9 frames
    Scene at_rate(double fps) const;
    /// Gives a scene without animation a clip of that length, for a turntable. Animated scenes are returned unchanged.
    Scene lasting(double seconds) const;
    /// Keeps the first `count` lights in file order.
    Scene with_lights(int count) const;
    /// Replaces all lights. Each spec is "spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B" or "point X Y Z R G B", in candela.
    /// @throws UsageError  a spec has another form
    Scene with_light_specs(const std::vector<std::string>& specs) const;

    /// Adds light from an environment map: OpenEXR, Radiance HDR, PNG or JPEG in longitude by latitude, with its upper
    /// edge towards +Y, its centre towards -Z and its right quarter towards +X; or "builtin:studio". It replaces the
    /// background and default light with its ground; the file's own lights stay.
    /// @param lights  number of directional lights that approximate it, a power of two from 1 to 1024
    /// @throws InputError  the file is missing or invalid
    /// @throws UsageError  the number of lights is not a power of two from 1 to 1024
    Scene with_environment(const std::filesystem::path& file, int lights = 16) const;

    // The scene's parts, in the order in which they were added or stand in the file.

    /// All nodes.
    std::vector<NodeId> nodes() const;
    /// All instances of meshes with triangles.
    std::vector<InstanceId> instances() const;
    /// All lights.
    std::vector<LightId> lights() const;
    /// All cameras.
    std::vector<CameraId> cameras() const;
    /// All materials.
    std::vector<MaterialId> materials() const;
    /// All meshes.
    std::vector<MeshId> meshes() const;

    /// The first node of that name; an id without a part if there is none.
    NodeId find_node(const std::string& name) const;
    /// The first instance of that name; an id without a part if there is none.
    InstanceId find_instance(const std::string& name) const;
    /// The first light of that name; an id without a part if there is none.
    LightId find_light(const std::string& name) const;
    /// The first camera of that name; an id without a part if there is none.
    CameraId find_camera(const std::string& name) const;
    /// The first material of that name; an id without a part if there is none.
    MaterialId find_material(const std::string& name) const;

    // What a part is like.

    /// The node's name; it may be empty, and need not be unique.
    std::string name(const NodeId& id) const;
    /// The node above; an id without a part for the world.
    NodeId parent(const NodeId& id) const;
    /// What may change at the node, as declared for it or for a node above, or by its tracks.
    Mobility mobility(const NodeId& id) const;
    /// The nearest node that may move, from this one up the hierarchy; it moves all below it as one. Itself if none
    /// may.
    NodeId moving_node(const NodeId& id) const;
    /// The node's transform to its parent's space, at the clip's start.
    Transform transform(const NodeId& id) const;
    /// The mesh that the instance shows.
    MeshId mesh(const InstanceId& id) const;
    /// The node that carries the light.
    NodeId node(const LightId& id) const;
    /// The node that carries the camera.
    NodeId node(const CameraId& id) const;
    /// The light's values.
    Light light(const LightId& id) const;
    /// The material's values.
    Material material(const MaterialId& id) const;
    /// The camera's values; its transform is the node's, at the clip's start.
    Camera camera(const CameraId& id) const;

    /// The instance that a value of the layer of ids stands for; an id without a part for 0, and for values that stand
    /// for nothing.
    InstanceId instance_of(std::uint32_t layer_value) const;
    /// The material that a value of the layer of ids stands for, likewise.
    MaterialId material_of(std::uint32_t layer_value) const;

    struct Impl;

 private:
    friend class api::SceneAccess;
    explicit Scene(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    std::shared_ptr<const Impl> impl_;
};

/// Options of load().
struct LoadOptions {
    Progress progress;   // optional
    int threads = 0;     // 0: all
    /// Refuses a file with any error. Otherwise harmless errors are repaired, with one warning for each cause.
    bool strict = false;
    /// The animation of a glTF file that plays, by name or by number from 0; "all": all of them. Empty: the first, and
    /// each further one that animates nothing that one before it animates already.
    std::string animation{};
    /// A ground under the scene that shows shadows and nothing else. Without a value: where the library adds a studio.
    std::optional<bool> ground{};
    /// The variant of a glTF file's materials, by name. Empty: the materials that the file gives without a variant.
    std::string variant{};
    /// MB that the file may ask for, all in all: textures, keys of animations, groups. Textures beyond it are halved,
    /// with a warning; for anything else, load() throws InputError before it takes the memory. It is a constant, so
    /// that a file looks the same on every machine. What decoding needs meanwhile does not count.
    int memory = 2048;
};

/// Loads a scene: a file by its extension (.gltf, .glb, .obj, .ply, .stl, .aff), or "builtin:NAME".
/// @throws InputError        a file is missing or invalid; the message names file, place and fault
/// @throws UsageError        unknown extension or built-in scene, or no such animation or variant
/// @throws InterruptedError  progress returned false
Scene load(const std::string& what, const LoadOptions& options = {});

}   // namespace gnomon
