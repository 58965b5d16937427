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
/// An id of one kind of part. It converts to true if it refers to a part, and can be compared.
template <class Tag>
struct Id {
    std::uint32_t index = 0;
    std::uint32_t stamp = 0;   // unique among all parts of all scenes in the process; 0: no part

    /// Whether the id refers to a part.
    explicit operator bool() const { return stamp != 0; }
    friend bool operator==(const Id&, const Id&) = default;
};
}   // namespace detail

/// A mesh, which any number of instances may show.
using MeshId = detail::Id<struct MeshTag>;
/// A material.
using MaterialId = detail::Id<struct MaterialTag>;
/// A texture, which any number of materials may use.
using TextureId = detail::Id<struct TextureTag>;
/// A skin: the joints that deform a mesh.
using SkinId = detail::Id<struct SkinTag>;
/// A light; the node that carries it is Scene::node().
using LightId = detail::Id<struct LightTag>;
/// A camera; the node that carries it is Scene::node().
using CameraId = detail::Id<struct CameraTag>;
/// A node of the hierarchy: a transform relative to the parent's.
using NodeId = detail::Id<struct NodeTag>;

/// A node with a mesh: an object.
struct InstanceId : NodeId {
    InstanceId() = default;
    /// The instance that a node is. A node without a mesh gives an id that is rejected wherever an instance is
    /// expected.
    explicit InstanceId(const NodeId& node) : NodeId(node) {}
};

}   // namespace gnomon
