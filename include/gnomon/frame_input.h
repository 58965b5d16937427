// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a host hands over for a frame: time, camera, and the values that changed.
//
// Values stay in force until other ones are handed over, or until they are released. A host therefore hands over only
// what changed; what equals the value in force is found equal and costs no more than the comparison. Values of parts
// that are no longer in the scene are forgotten.
//
// With RenderOptions::shutter, a value is that of the shutter's opening, and `closing` the one when it closes; none: it
// does not change meanwhile. Between them, places, scales, numbers and colours change evenly and rotations take the
// shorter way. The layers that are not blurred are those of the shutter's middle. Without a shutter, `closing` has no
// effect.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnomon/ids.h"
#include "gnomon/math.h"
#include "gnomon/output.h"
#include "gnomon/scene_parts.h"

namespace gnomon {

/// A node's transform to its parent's space, instead of the scene's transform or track. Moves everything below it.
struct NodeTransform {
    NodeId node;
    Transform transform;
    std::optional<Transform> closing{};
};

/// Shows or hides a node and everything below it.
struct NodeVisibility {
    NodeId node;
    bool visible = true;
};

/// The vertices of one instance, instead of its mesh's; in object space, of a skinned instance in world space. The
/// arrays are copied.
struct InstanceVertices {
    InstanceId instance;
    std::span<const Vec3> positions;   // as many as the mesh has
    std::span<const Vec3> normals{};   // empty: computed from the positions if the mesh has normals
    std::span<const Vec3> closing_positions{};
};

/// The weights of a mesh's morph targets.
struct MorphWeights {
    InstanceId instance;
    std::vector<float> weights;   // one per target
    std::vector<float> closing{};
};

/// The values of a light; its position and direction are those of its node.
struct LightValues {
    LightId light;
    Light values;
    std::optional<Light> closing{};   // of the same type, falloff and profile
};

/// The values of a material. Another surface class (opaque, masked, transparent), other sidedness, or another texture
/// of a masked material costs as much as a new scene.
struct MaterialValues {
    MaterialId material;
    Material values;
    std::optional<Material> closing{};   // of the same class and sides; its textures do not count
};

/// What changed since the frame before. An empty input renders the first frame of the scene's clip with the values in
/// force.
struct FrameInput {
    std::optional<double> time{};   // seconds; none: that of `frame`
    int frame = 1;                  // of the scene's clip, from 1; ignored with a time
    /// None: the scene's camera that RenderOptions::camera names.
    std::optional<Camera> camera{};
    std::optional<Camera> camera_closing{};
    double turn = 0;   // radians by which the scene's camera has circled the scene

    std::vector<NodeTransform> transforms{};
    std::vector<NodeVisibility> visibility{};
    std::vector<InstanceVertices> vertices{};
    std::vector<MorphWeights> morph_weights{};
    std::vector<LightValues> lights{};
    std::vector<MaterialValues> materials{};
    /// Parts whose values handed over before end: what the scene says holds again.
    std::vector<NodeId> released_nodes{};   // transforms, visibility, vertices and weights
    std::vector<LightId> released_lights{};
    std::vector<MaterialId> released_materials{};

    /// Limits the rays of indirect light in this frame; the light that is missing comes with later frames of the same
    /// input, until Frame::complete. 0: no limit, every frame is complete.
    std::uint64_t indirect_ray_limit = 0;

    /// The image is one that another will replace, as in a window while the view moves: environment images light it by
    /// some 40 rays for each point, in the same directions for all, where otherwise some hundreds are traced, so that
    /// shadows have steps. Such a frame is not complete, and leaves the bytes of later ones as they are. Of traced
    /// frames; the rasteriser makes no difference.
    bool preview = false;

    /// Layers to be written into memory of the caller's once the frame is rendered. With another error, nothing is
    /// written.
    std::vector<Output> outputs{};
};

}   // namespace gnomon
