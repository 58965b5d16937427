// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a SceneBuilder holds: the scene so far, the stamps of its ids, and the indices that removed parts left free.

#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "api/stamps.h"
#include "gnomon/error.h"
#include "gnomon/scene_builder.h"
#include "scene/scene.h"

namespace gnomon {

namespace api {

/// Runs a function, and reports a lack of memory as the machine's.
template <class F>
auto with_memory(const F& run)
{
    try {
        return run();
    } catch (const std::bad_alloc&) {
        throw MissingError("not enough memory for the scene");
    } catch (const std::length_error&) {
        throw MissingError("not enough memory for the scene");
    }
}

}   // namespace api

struct SceneBuilder::Impl {
    scene::Scene scene;
    api::SceneStamps stamps;
    // Indices of parts that were removed.
    std::set<std::uint32_t> free_nodes, free_meshes, free_materials, free_textures, free_skins;
    std::vector<std::uint32_t> mesh_users;   // by mesh: the nodes that use it

    scene::NodeId add_node(const Transform& transform, const NodeOptions& options, std::string_view what);
    scene::MeshId add_mesh(scene::Mesh mesh);
    scene::MaterialId add_material(scene::Material material);
    scene::TextureId add_texture(scene::Texture texture);
    scene::SkinId add_skin(scene::Skin skin);
    /// Gives the parts that have no material the grey one, which is added first if there is none.
    void fill_materials(scene::Mesh& mesh);
    void set_mesh(scene::MeshId index, const Mesh& mesh);
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
    /// Gives a node a transform to its parent's space, in the coordinates of the file, instead of its track.
    void place(scene::NodeId node, const glm::dmat4& local);
    /// Makes a node an instance of a mesh, or of none; a variant that nobody uses any more is removed.
    void use_mesh(scene::NodeId node, scene::MeshId mesh);
    void free_mesh(scene::MeshId mesh);
    void remove_light(std::size_t light);
    void remove_camera(std::size_t camera);
    /// Removes nodes, and what they have.
    /// @param nodes  ascending; with all that is below them
    void remove_nodes(const std::vector<scene::NodeId>& nodes);
    /// Removes the lights with a mark, and those of their nodes that have nothing else.
    void remove_lights(bool scene::Light::*mark);
    bool is_joint(scene::NodeId node) const;
    std::vector<scene::NodeId> subtree(scene::NodeId root) const;
    void require_joints(const scene::Mesh& mesh, scene::SkinId skin, const std::string& owner) const;
};

}   // namespace gnomon
