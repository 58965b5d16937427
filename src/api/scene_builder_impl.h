// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a SceneBuilder holds: the scene so far, the stamps of its ids, and the indices that removed parts left free.

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "api/stamps.h"
#include "gnomon/scene_builder.h"
#include "scene/scene.h"

namespace gnomon {

struct SceneBuilder::Impl {
    scene::Scene scene;
    api::SceneStamps stamps;
    std::set<std::uint32_t> free_nodes, free_meshes;   // indices of parts that were removed
    std::vector<std::uint32_t> mesh_users;             // by mesh: the nodes that use it
    scene::MaterialId grey = scene::none;              // where none was given

    scene::NodeId add_node(const Transform& transform, const NodeOptions& options, std::string_view what);
    scene::MeshId add_mesh(scene::Mesh mesh);
    scene::MaterialId grey_material();
    scene::MeshId mesh_with(scene::MeshId mesh, scene::MaterialId material);
    // What a node gets with a mesh, by the scene's indices.
    struct Attachment {
        scene::MeshId mesh = scene::none;
        scene::MaterialId material = scene::none;
        scene::SkinId skin = scene::none;
    };
    Attachment check_attachment(const MeshId& mesh, const MaterialId& material, const InstanceOptions& options,
                                const std::string& owner) const;
    void attach(scene::NodeId node, const Attachment& attachment, const InstanceOptions& options);
    void declare(scene::NodeId node, Mobility mobility);
    /// Makes a node an instance of a mesh, or of none; a variant that nobody uses any more is removed.
    void use_mesh(scene::NodeId node, scene::MeshId mesh);
    void free_mesh(scene::MeshId mesh);
    void remove_light(std::size_t light);
    void remove_camera(std::size_t camera);
    std::vector<scene::NodeId> subtree(scene::NodeId root) const;
    void require_joints(const scene::Mesh& mesh, scene::SkinId skin, const std::string& owner) const;
};

}   // namespace gnomon
