// SPDX-License-Identifier: Apache-2.0
// Changes and removes parts of the scene that a SceneBuilder holds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "api/convert.h"
#include "api/scene_builder_impl.h"
#include "gnomon/error.h"
#include "scene/near_origin.h"

namespace gnomon {

// Takes a free index above the parent's, because parents come first; else a new one.
scene::NodeId SceneBuilder::Impl::add_node(const Transform& transform, const NodeOptions& options,
                                           std::string_view what)
{
    glm::dmat4 local = api::matrix_of(transform, what);
    api::require_known(options.mobility, Mobility::may_deform, what, "the mobility");
    const scene::NodeId parent =
        options.parent ? api::require(stamps.nodes, options.parent, fmt::format("{}: the parent", what)) : scene::none;
    if (parent == scene::none) local = scene::translated(local, -stamps.origin);
    const auto free = parent == scene::none ? free_nodes.begin() : free_nodes.upper_bound(parent);
    scene::NodeId node = scene::none;
    if (free != free_nodes.end()) {
        node = *free;
        free_nodes.erase(free);
        scene.nodes[node] = {};
        scene.nodes[node].name = options.name;
        scene.nodes[node].parent = parent;
        scene.nodes[node].local = local;
    } else {
        node = scene.add_node(options.name, parent, local);
    }
    stamps.nodes.renew(node);
    declare(node, options.mobility);
    return node;
}

scene::MeshId SceneBuilder::Impl::add_mesh(scene::Mesh mesh)
{
    if (free_meshes.empty()) {
        scene.meshes.push_back(std::move(mesh));
        stamps.meshes.renew(scene.meshes.size() - 1);
        mesh_users.push_back(0);
        return static_cast<scene::MeshId>(scene.meshes.size() - 1);
    }
    const scene::MeshId id = *free_meshes.begin();
    free_meshes.erase(free_meshes.begin());
    scene.meshes.replace(id, std::move(mesh));
    stamps.meshes.renew(id);
    return id;
}

scene::MaterialId SceneBuilder::Impl::add_material(scene::Material material)
{
    std::uint32_t id = static_cast<std::uint32_t>(scene.materials.size());
    if (free_materials.empty()) {
        scene.materials.push_back(std::move(material));
    } else {
        id = *free_materials.begin();
        free_materials.erase(free_materials.begin());
        scene.materials[id] = std::move(material);
    }
    stamps.materials.renew(id);
    return id;
}

scene::TextureId SceneBuilder::Impl::add_texture(scene::Texture texture)
{
    std::uint32_t id = static_cast<std::uint32_t>(scene.textures.size());
    if (free_textures.empty()) {
        scene.textures.push_back(std::move(texture));
    } else {
        id = *free_textures.begin();
        free_textures.erase(free_textures.begin());
        scene.textures.replace(id, std::move(texture));
    }
    stamps.textures.renew(id);
    return id;
}

scene::SkinId SceneBuilder::Impl::add_skin(scene::Skin skin)
{
    std::uint32_t id = static_cast<std::uint32_t>(scene.skins.size());
    if (free_skins.empty()) {
        scene.skins.push_back(std::move(skin));
    } else {
        id = *free_skins.begin();
        free_skins.erase(free_skins.begin());
        scene.skins[id] = std::move(skin);
    }
    stamps.skins.renew(id);
    return id;
}

void SceneBuilder::Impl::fill_materials(scene::Mesh& mesh)
{
    for (scene::MeshPart& part : mesh.parts) {
        if (part.material != scene::none) continue;
        if (stamps.grey == scene::none) stamps.grey = add_material({});
        part.material = stamps.grey;
    }
}

// A mesh with one material throughout: itself, or a copy that all instances with that material share.
scene::MeshId SceneBuilder::Impl::mesh_with(scene::MeshId mesh, scene::MaterialId material)
{
    const scene::Mesh& original = scene.meshes[mesh];
    if (!original.parts.empty() && std::all_of(original.parts.begin(), original.parts.end(),
                                               [&](const scene::MeshPart& part) { return part.material == material; }))
        return mesh;
    for (const auto& [id, variant] : stamps.mesh_variants)
        if (variant.mesh == mesh && variant.material == material) return id;
    scene::Mesh copy = original;
    copy.parts.clear();
    if (!copy.triangles.empty()) copy.parts = {{material, 0, static_cast<std::uint32_t>(copy.triangles.size())}};
    const scene::MeshId id = add_mesh(std::move(copy));
    stamps.meshes.clear(id);
    stamps.mesh_variants[id] = {mesh, material};
    return id;
}

SceneBuilder::Impl::Attachment SceneBuilder::Impl::check_attachment(const MeshId& mesh, const MaterialId& material,
                                                                    const InstanceOptions& options,
                                                                    const std::string& owner) const
{
    Attachment result;
    result.mesh = api::require(stamps.meshes, mesh, fmt::format("{}: the mesh", owner));
    if (material) result.material = api::require(stamps.materials, material, fmt::format("{}: the material", owner));
    const scene::Mesh& shape = scene.meshes[result.mesh];
    api::require_known(options.mobility, Mobility::may_deform, owner, "the mobility");
    if (options.skin) {
        result.skin = api::require(stamps.skins, options.skin, fmt::format("{}: the skin", owner));
        require_joints(shape, result.skin, owner);
    }
    if (!options.morph_weights.empty() && options.morph_weights.size() != shape.morph_targets.size())
        throw UsageError(fmt::format("{}: {} morph weights for {} targets", owner, options.morph_weights.size(),
                                     shape.morph_targets.size()));
    for (const float weight : options.morph_weights)
        if (!std::isfinite(weight)) throw UsageError(fmt::format("{}: a morph weight is not finite", owner));
    const Box& reach = options.reach;
    for (const float value : {reach.low.x, reach.low.y, reach.low.z, reach.high.x, reach.high.y, reach.high.z})
        if (!std::isfinite(value)) throw UsageError(fmt::format("{}: its reach is not finite", owner));
    return result;
}

void SceneBuilder::Impl::attach(scene::NodeId id, const Attachment& attachment, const InstanceOptions& options)
{
    use_mesh(id,
             attachment.material == scene::none ? attachment.mesh : mesh_with(attachment.mesh, attachment.material));
    scene::Node& node = scene.nodes[id];
    node.skin = attachment.skin;
    node.morph_weights = options.morph_weights;
    const glm::vec3 origin(stamps.origin);
    if (!options.reach.empty())
        node.reach = {api::vec(options.reach.low) - origin, api::vec(options.reach.high) - origin};
}

void SceneBuilder::Impl::declare(scene::NodeId node, Mobility mobility)
{
    scene.nodes[node].animated = mobility != Mobility::fixed;
    scene.nodes[node].deforms = mobility == Mobility::may_deform;
}

void SceneBuilder::Impl::free_mesh(scene::MeshId mesh)
{
    scene.meshes.replace(mesh, scene::Mesh());
    stamps.meshes.clear(mesh);
    stamps.mesh_variants.erase(mesh);
    free_meshes.insert(mesh);
}

void SceneBuilder::Impl::use_mesh(scene::NodeId node, scene::MeshId mesh)
{
    const scene::MeshId before = scene.nodes[node].mesh;
    if (mesh != scene::none) ++mesh_users[mesh];
    scene.nodes[node].mesh = mesh;
    if (before == scene::none || --mesh_users[before] > 0) return;
    if (stamps.mesh_variants.contains(before)) free_mesh(before);
}

void SceneBuilder::Impl::remove_light(std::size_t light)
{
    scene.lights.erase(scene.lights.begin() + static_cast<std::ptrdiff_t>(light));
    stamps.lights.erase(light);
}

void SceneBuilder::Impl::remove_camera(std::size_t camera)
{
    scene.cameras.erase(scene.cameras.begin() + static_cast<std::ptrdiff_t>(camera));
    stamps.cameras.erase(camera);
}

// The nodes of a subtree, parents first. Children come after their parents, so that one pass finds all.
std::vector<scene::NodeId> SceneBuilder::Impl::subtree(scene::NodeId root) const
{
    std::vector<scene::NodeId> nodes{root};
    std::vector<char> inside(scene.nodes.size(), 0);
    inside[root] = 1;
    for (std::size_t n = root + 1; n < scene.nodes.size(); ++n) {
        const scene::NodeId parent = scene.nodes[n].parent;
        if (parent == scene::none || !inside[parent]) continue;
        inside[n] = 1;
        nodes.push_back(static_cast<scene::NodeId>(n));
    }
    return nodes;
}

void SceneBuilder::Impl::require_joints(const scene::Mesh& mesh, scene::SkinId skin, const std::string& owner) const
{
    if (!mesh.skin) throw UsageError(fmt::format("{}: a skin, but its mesh has no joints", owner));
    const std::size_t joints = scene.skins[skin].joints.size();
    for (const auto& group : mesh.skin->joints)
        for (const glm::u16vec4& four : group)
            for (int k = 0; k < 4; ++k)
                if (four[k] >= joints)
                    throw UsageError(fmt::format("{}: joint {} of a skin with {}", owner, four[k], joints));
}

void SceneBuilder::set_mesh(const MeshId& id, const Mesh& mesh)
{
    api::with_memory([&] {
        Impl& in = impl();
        in.set_mesh(api::require(in.stamps.meshes, id, "the mesh"), mesh);
    });
}

void SceneBuilder::Impl::set_mesh(scene::MeshId index, const Mesh& mesh)
{
    scene::Mesh made = api::to_scene(mesh, stamps, scene::none);
    // Check that it suits all its instances.
    for (const scene::Node& node : scene.nodes) {
        const auto variant = stamps.mesh_variants.find(node.mesh);
        if ((variant == stamps.mesh_variants.end() ? node.mesh : variant->second.mesh) != index) continue;
        const std::string owner = api::titled("instance", node.name);
        if (node.skin != scene::none) require_joints(made, node.skin, owner);
        if (!node.morph_weights.empty() && node.morph_weights.size() != made.morph_targets.size())
            throw UsageError(fmt::format("{}: {} morph weights for {} targets", owner, node.morph_weights.size(),
                                         made.morph_targets.size()));
    }
    // Make the variants first, because that may need more memory than there is.
    std::vector<std::pair<scene::MeshId, scene::Mesh>> variants;
    for (const auto& [copy, variant] : stamps.mesh_variants) {
        if (variant.mesh != index) continue;
        scene::Mesh& same = variants.emplace_back(copy, made).second;
        same.parts.clear();
        if (!same.triangles.empty())
            same.parts = {{variant.material, 0, static_cast<std::uint32_t>(same.triangles.size())}};
    }
    fill_materials(made);
    for (auto& [copy, same] : variants) scene.meshes.replace(copy, std::move(same));
    scene.meshes.replace(index, std::move(made));
}

void SceneBuilder::set_material(const MaterialId& id, const Material& material)
{
    api::with_memory([&] {
        Impl& in = impl();
        const scene::MaterialId index = api::require(in.stamps.materials, id, "the material");
        in.scene.materials[index] = api::to_scene(material, in.stamps);
        if (index == in.stamps.grey) in.stamps.grey = scene::none;   // it is the host's now
    });
}

void SceneBuilder::set_material(const InstanceId& id, const MaterialId& material)
{
    api::with_memory([&] {
        Impl& in = impl();
        const scene::NodeId node = api::require(in.stamps.nodes, id, "the instance");
        const scene::MaterialId own = api::require(in.stamps.materials, material, "the material");
        const scene::MeshId used = in.scene.nodes[node].mesh;
        if (used == scene::none) throw UsageError("the node has no mesh: it takes no material");
        const auto variant = in.stamps.mesh_variants.find(used);
        in.use_mesh(node, in.mesh_with(variant == in.stamps.mesh_variants.end() ? used : variant->second.mesh, own));
    });
}

void SceneBuilder::set_light(const LightId& id, const Light& light)
{
    Impl& in = impl();
    const std::uint32_t index = api::require(in.stamps.lights, id, "the light");
    scene::Light made = api::to_scene(light);
    made.node = in.scene.lights[index].node;
    made.of_environment = in.scene.lights[index].of_environment;
    in.scene.lights[index] = std::move(made);
}

void SceneBuilder::set_camera(const CameraId& id, const Camera& camera)
{
    Impl& in = impl();
    const std::uint32_t index = api::require(in.stamps.cameras, id, "the camera");
    scene::Camera made = api::to_scene(camera);
    const glm::dmat4 local = api::matrix_of(camera.transform, "the camera");
    made.node = in.scene.cameras[index].node;
    in.place(made.node, local);
    in.scene.cameras[index] = std::move(made);
}

void SceneBuilder::set_transform(const NodeId& id, const Transform& transform)
{
    Impl& in = impl();
    const scene::NodeId node = api::require(in.stamps.nodes, id, "the node");
    in.place(node, api::matrix_of(transform, "the node"));
}

void SceneBuilder::Impl::place(scene::NodeId id, const glm::dmat4& local)
{
    scene::Node& node = scene.nodes[id];
    node.local = node.parent == scene::none ? scene::translated(local, -stamps.origin) : local;
    node.transform.reset();
}

void SceneBuilder::set_mobility(const NodeId& id, Mobility mobility)
{
    Impl& in = impl();
    const scene::NodeId node = api::require(in.stamps.nodes, id, "the node");
    api::require_known(mobility, Mobility::may_deform, "the node", "the mobility");
    in.declare(node, mobility);
}

bool SceneBuilder::Impl::is_joint(scene::NodeId node) const
{
    return std::any_of(scene.skins.begin(), scene.skins.end(), [&](const scene::Skin& skin) {
        return std::find(skin.joints.begin(), skin.joints.end(), node) != skin.joints.end();
    });
}

void SceneBuilder::Impl::remove_nodes(const std::vector<scene::NodeId>& nodes)
{
    const auto goes = [&](scene::NodeId n) { return std::binary_search(nodes.begin(), nodes.end(), n); };
    for (std::size_t l = scene.lights.size(); l-- > 0;)
        if (goes(scene.lights[l].node)) remove_light(l);
    for (std::size_t c = scene.cameras.size(); c-- > 0;)
        if (goes(scene.cameras[c].node)) remove_camera(c);
    for (const scene::NodeId n : nodes) {
        use_mesh(n, scene::none);
        scene.nodes[n] = {};
        stamps.nodes.clear(n);
        free_nodes.insert(n);
    }
}

void SceneBuilder::Impl::remove_lights(bool scene::Light::*mark)
{
    std::vector<scene::NodeId> nodes;
    for (std::size_t l = scene.lights.size(); l-- > 0;) {
        if (!(scene.lights[l].*mark)) continue;
        nodes.push_back(scene.lights[l].node);
        remove_light(l);
    }
    // Keep nodes that a host has given something else.
    std::sort(nodes.begin(), nodes.end());
    std::set<scene::NodeId> used;
    for (const scene::Node& node : scene.nodes)
        if (node.parent != scene::none) used.insert(node.parent);
    for (const scene::Light& light : scene.lights) used.insert(light.node);
    for (const scene::Camera& camera : scene.cameras) used.insert(camera.node);
    std::erase_if(
        nodes, [&](scene::NodeId n) { return scene.nodes[n].mesh != scene::none || used.contains(n) || is_joint(n); });
    remove_nodes(nodes);
}

void SceneBuilder::remove(const NodeId& id)
{
    api::with_memory([&] {
        Impl& in = impl();
        const std::vector<scene::NodeId> nodes = in.subtree(api::require(in.stamps.nodes, id, "the node"));
        const auto goes = [&](scene::NodeId n) { return std::binary_search(nodes.begin(), nodes.end(), n); };
        for (const scene::Skin& skin : in.scene.skins)
            if (std::any_of(skin.joints.begin(), skin.joints.end(), goes))
                throw UsageError("the node is the joint of a skin, or one is below it: it cannot be removed");
        in.remove_nodes(nodes);
    });
}

void SceneBuilder::remove(const LightId& id)
{
    Impl& in = impl();
    in.remove_light(api::require(in.stamps.lights, id, "the light"));
}

void SceneBuilder::remove(const CameraId& id)
{
    Impl& in = impl();
    in.remove_camera(api::require(in.stamps.cameras, id, "the camera"));
}

void SceneBuilder::remove(const MeshId& id)
{
    Impl& in = impl();
    const scene::MeshId mesh = api::require(in.stamps.meshes, id, "the mesh");
    const bool has_variants = std::any_of(in.stamps.mesh_variants.begin(), in.stamps.mesh_variants.end(),
                                          [&](const auto& variant) { return variant.second.mesh == mesh; });
    if (in.mesh_users[mesh] > 0 || has_variants)
        throw UsageError("the mesh has instances: it cannot be removed before them");
    in.free_mesh(mesh);
}

void SceneBuilder::remove(const SkinId& id)
{
    Impl& in = impl();
    const scene::SkinId skin = api::require(in.stamps.skins, id, "the skin");
    for (const scene::Node& node : in.scene.nodes)
        if (node.mesh != scene::none && node.skin == skin)
            throw UsageError("an instance uses the skin: it cannot be removed before the instance");
    for (scene::Node& node : in.scene.nodes)
        if (node.skin == skin) node.skin = scene::none;
    in.scene.skins[skin] = {};
    in.stamps.skins.clear(skin);
    in.free_skins.insert(skin);
}

void SceneBuilder::remove(const MaterialId& id)
{
    Impl& in = impl();
    const scene::MaterialId material = api::require(in.stamps.materials, id, "the material");
    for (const scene::Mesh& mesh : in.scene.meshes)
        for (const scene::MeshPart& part : mesh.parts)
            if (part.material == material)
                throw UsageError("a mesh uses the material: it cannot be removed before the mesh");
    // Meshes without triangles have no parts, but a variant keeps its material for later ones.
    for (const auto& [mesh, variant] : in.stamps.mesh_variants)
        if (variant.material == material)
            throw UsageError("an instance uses the material: it cannot be removed before the instance");
    in.scene.materials[material] = {};
    in.stamps.materials.clear(material);
    in.free_materials.insert(material);
    if (material == in.stamps.grey) in.stamps.grey = scene::none;
}

void SceneBuilder::remove(const TextureId& id)
{
    Impl& in = impl();
    const scene::TextureId texture = api::require(in.stamps.textures, id, "the texture");
    for (const scene::Material& m : in.scene.materials)
        for (const scene::TextureUse* use : scene::texture_uses(m))
            if (use->texture == texture)
                throw UsageError("a material uses the texture: it cannot be removed before the material");
    in.scene.textures.replace(texture, scene::Texture("", Image8(1, 1, 1), false, {}));
    in.stamps.textures.clear(texture);
    in.free_textures.insert(texture);
}

}   // namespace gnomon
