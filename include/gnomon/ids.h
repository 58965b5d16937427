// SPDX-License-Identifier: Apache-2.0
#pragma once
// Typed ids of what a scene consists of.
//
// An id belongs to one part of one scene, and to all scenes that were made from it by a SceneBuilder as long as they
// still have that part. Ids of other scenes, and of parts that were removed, are recognised and rejected with
// UsageError. A default-constructed id refers to nothing.

#include <cstdint>

namespace gnomon {

namespace detail {
template <class Tag>
struct Id {
    std::uint32_t index = 0;
    std::uint32_t stamp = 0;   // unique among all parts of all scenes in the process; 0: no part

    explicit operator bool() const { return stamp != 0; }
    friend bool operator==(const Id&, const Id&) = default;
};
}   // namespace detail

using MeshId = detail::Id<struct MeshTag>;
using MaterialId = detail::Id<struct MaterialTag>;
using TextureId = detail::Id<struct TextureTag>;
using SkinId = detail::Id<struct SkinTag>;
using LightId = detail::Id<struct LightTag>;
using CameraId = detail::Id<struct CameraTag>;
/// A node of the hierarchy: a transform relative to the parent's.
using NodeId = detail::Id<struct NodeTag>;

/// A node with a mesh: an object.
struct InstanceId : NodeId {
    InstanceId() = default;
    explicit InstanceId(const NodeId& node) : NodeId(node) {}
};

}   // namespace gnomon
