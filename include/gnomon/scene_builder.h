// SPDX-License-Identifier: Apache-2.0
#pragma once
// Makes scenes from a host's data, and changes scenes that exist.
//
// A builder can be finished as often as needed. The scenes share what they have in common, so that adding an object to
// a finished scene and finishing again copies no geometry. Ids stay valid from scene to scene until their part is
// removed; a part that is added later may take its place in memory, but has another id. Values that change from frame
// to frame (transforms, vertices, visibility, lights, materials, cameras) need no builder: hand them to
// Renderer::render().
//
// Nothing is added by default: a scene without lights is dark, and one without cameras needs one in FrameInput.
// Cost: adding copies what is passed; finish() visits each node, not its geometry.

#include <memory>
#include <string>

#include "gnomon/scene.h"
#include "gnomon/scene_parts.h"

namespace gnomon {

/// Options of a node, or of the node that carries a light or a camera.
struct NodeOptions {
    Mobility mobility = Mobility::fixed;   // of everything below, too
    NodeId parent{};                       // none: the world
    std::string name{};
};

/// Options of an instance.
struct InstanceOptions {
    Mobility mobility = Mobility::fixed;
    NodeId parent{};
    std::string name{};
    SkinId skin{};                        // of a mesh with joints
    std::vector<float> morph_weights{};   // empty: the mesh's own
    /// The part of the world that it is expected to move in. Light views are laid out for it from the start; beyond,
    /// they are laid out anew.
    Box reach{};
};

/// The parts that make a light with size: an instance, and its material, whose emission is the light's.
struct AreaLightParts {
    InstanceId instance{};
    MaterialId material{};
};

/// Options of SceneBuilder::finish(): what it adds to the parts.
struct FinishOptions {
    /// Add light to a scene without lights whose emission reaches less than a quarter of it, with a warning: a sky and
    /// a sun, or a light below the ceiling of a room. load() adds a studio to objects instead.
    bool default_light = false;
    /// Add the camera that load() adds to files without any: it shows the whole scene.
    bool default_camera = false;
};

/// Makes scenes of parts. A function that takes ids or values throws UsageError for ids that the builder does not have,
/// for numbers that are not finite or out of range, for arrays whose lengths disagree, and for sizes beyond the limits
/// (gnomon/ranges.h). It throws MissingError if memory does not suffice. The builder is then as before.
class SceneBuilder {
 public:
    /// Begins with nothing.
    SceneBuilder();
    /// Continues a scene: its parts keep their ids.
    explicit SceneBuilder(const Scene& scene);
    ~SceneBuilder();
    SceneBuilder(SceneBuilder&&) noexcept;
    SceneBuilder& operator=(SceneBuilder&&) noexcept;

    /// Adds a mesh, which instance() places in the scene.
    MeshId mesh(const Mesh& mesh);
    /// Adds a material.
    MaterialId material(const Material& material);
    /// Adds a texture of pixels in memory.
    TextureId texture(const Texture& texture);
    /// Adds a texture: a PNG or JPEG file in memory, which is decoded; size, channels and pixels of `as` are not read.
    /// @throws InputError  the bytes are not such a file
    TextureId texture(std::span<const std::byte> file, const Texture& as = {});
    /// Adds a skin.
    SkinId skin(const Skin& skin);
    /// Adds a node without a mesh.
    /// @param transform  to the parent's space; affine
    NodeId node(const Transform& transform = {}, const NodeOptions& options = {});
    /// Places a mesh in the scene.
    /// @param material   of the whole mesh; none: the mesh's parts have materials of their own, or a grey one
    /// @param transform  to the parent's space; affine
    InstanceId instance(const MeshId& mesh, const MaterialId& material = {}, const Transform& transform = {},
                        const InstanceOptions& options = {});
    /// Gives a node that has none a mesh, as a joint's or a light's node may have one, too.
    /// @param options  name and parent are not read
    InstanceId attach(const NodeId& node, const MeshId& mesh, const MaterialId& material = {},
                      const InstanceOptions& options = {});
    /// Adds a light and the node that carries it.
    /// @param transform  of its node to the parent's space
    LightId light(const Light& light, const Transform& transform = {}, const NodeOptions& options = {});
    /// Adds a light with size, as a mesh with an emissive material and an instance of it. A disc is a polygon of 32
    /// corners, a sphere a mesh of 320 triangles, both of the exact shape's area. To dim the light, change the
    /// material: by set_material(), or frame by frame in FrameInput.
    /// @param transform  of its node to the parent's space
    AreaLightParts area_light(const AreaLight& light, const Transform& transform = {},
                              const InstanceOptions& options = {});
    /// Adds a camera and the node that carries it. Camera::transform becomes its node's.
    CameraId camera(const Camera& camera, const NodeOptions& options = {});

    /// Surrounds the scene with light. It replaces the background. A renderer of the scene before goes on if both have
    /// images with as many lights.
    /// @param lights  number of directional lights that approximate it, a power of two from 1 to 1024
    void environment(const EnvironmentImage& image, int lights = 16);
    /// The colour where rays leave the scene; it gives no light. It replaces an environment and its light.
    void background(const Vec3& color);
    /// Uniform light without shadows, used only without indirect light.
    void ambient(const Vec3& color);
    /// The clip whose frames are numbered from 1. A scene without it has one frame, at time 0.
    void clip(double start, double end, double fps);

    /// Replaces a mesh in all its instances.
    void set_mesh(const MeshId& id, const Mesh& mesh);
    /// Replaces the values of a material wherever it is used.
    void set_material(const MaterialId& id, const Material& material);
    /// Gives an instance another material, for its whole mesh.
    void set_material(const InstanceId& id, const MaterialId& material);
    /// Replaces the values of a light; its node stays.
    void set_light(const LightId& id, const Light& light);
    /// Replaces the values of a camera, and its node's transform by Camera::transform.
    void set_camera(const CameraId& id, const Camera& camera);
    /// Replaces a node's transform to its parent's space, and its track if it has one.
    void set_transform(const NodeId& id, const Transform& transform);
    /// Declares what may change at a node and at everything below it.
    void set_mobility(const NodeId& id, Mobility mobility);
    /// Removes a node and everything below it: instances, lights and cameras.
    /// @throws UsageError  a skin has a joint there
    void remove(const NodeId& id);
    /// Removes a light; its node stays.
    void remove(const LightId& id);
    /// Removes a camera; its node stays.
    void remove(const CameraId& id);
    /// Removes a mesh.
    /// @throws UsageError  an instance uses it
    void remove(const MeshId& id);
    /// Removes a skin.
    /// @throws UsageError  an instance uses it
    void remove(const SkinId& id);
    /// Removes a material.
    /// @throws UsageError  an instance or a mesh uses it
    void remove(const MaterialId& id);
    /// Removes a texture.
    /// @throws UsageError  a material uses it
    void remove(const TextureId& id);

    /// Makes a scene of what there is now. The builder can go on.
    Scene finish(const FinishOptions& options = {});

 private:
    struct Impl;
    Impl& impl();
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon
