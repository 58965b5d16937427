// SPDX-License-Identifier: Apache-2.0
// Lists a scene's parts, finds them by name, and tells what they are like.
#include "api/convert.h"
#include "api/scene_access.h"
#include "gnomon/scene.h"
#include "scene/near_origin.h"

namespace gnomon {

namespace {

// The ids of all parts of a list that are there.
template <class Id>
std::vector<Id> ids_of(const api::StampList& list)
{
    std::vector<Id> ids;
    for (std::size_t i = 0; i < list.size(); ++i)
        if (list[i] != 0) ids.push_back(list.id<Id>(i));
    return ids;
}

template <class Id, class Parts>
Id find_by_name(const Parts& parts, const api::StampList& stamps, const std::string& name)
{
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (stamps[i] != 0 && parts[i].name == name) return stamps.id<Id>(i);
    return {};
}

bool is_instance(const scene::Scene& scene, const scene::Node& node)
{
    return node.mesh != scene::none && !scene.meshes[node.mesh].triangles.empty();
}

// A node's transform to its parent's space at the clip's start, in the coordinates of the file.
glm::dmat4 local_of(const Scene::Impl& impl, const scene::Node& node)
{
    const scene::Scene& scene = *impl.scene;
    const glm::dmat4 local = node.transform ? node.transform->evaluate(scene.timeline.start) : node.local;
    return node.parent == scene::none ? scene::translated(local, impl.stamps.origin) : local;
}

InstanceId instance_at(const Scene::Impl& impl, std::size_t node)
{
    return InstanceId(impl.stamps.nodes.id<NodeId>(node));
}

}   // namespace

Scene api::SceneAccess::make(std::shared_ptr<const scene::Scene> scene, SceneStamps stamps)
{
    auto impl = std::make_shared<Scene::Impl>();
    impl->scene = std::move(scene);
    impl->stamps = std::move(stamps);
    return Scene(std::move(impl));
}

Scene api::public_scene(std::shared_ptr<const scene::Scene> scene)
{
    GNOMON_CHECK(scene != nullptr);
    SceneStamps stamps(*scene);
    return SceneAccess::make(std::move(scene), std::move(stamps));
}

std::vector<NodeId> Scene::nodes() const
{
    return ids_of<NodeId>(impl_->stamps.nodes);
}

std::vector<InstanceId> Scene::instances() const
{
    std::vector<InstanceId> ids;
    for (const scene::Object& object : impl_->scene->objects) ids.push_back(instance_at(*impl_, object.node));
    return ids;
}

std::vector<LightId> Scene::lights() const
{
    return ids_of<LightId>(impl_->stamps.lights);
}

std::vector<CameraId> Scene::cameras() const
{
    return ids_of<CameraId>(impl_->stamps.cameras);
}

std::vector<MaterialId> Scene::materials() const
{
    return ids_of<MaterialId>(impl_->stamps.materials);
}

std::vector<MeshId> Scene::meshes() const
{
    return ids_of<MeshId>(impl_->stamps.meshes);
}

NodeId Scene::find_node(const std::string& name) const
{
    return find_by_name<NodeId>(impl_->scene->nodes, impl_->stamps.nodes, name);
}

InstanceId Scene::find_instance(const std::string& name) const
{
    for (const scene::Object& object : impl_->scene->objects)
        if (impl_->scene->nodes[object.node].name == name) return instance_at(*impl_, object.node);
    return {};
}

LightId Scene::find_light(const std::string& name) const
{
    return find_by_name<LightId>(impl_->scene->lights, impl_->stamps.lights, name);
}

CameraId Scene::find_camera(const std::string& name) const
{
    return find_by_name<CameraId>(impl_->scene->cameras, impl_->stamps.cameras, name);
}

MaterialId Scene::find_material(const std::string& name) const
{
    return find_by_name<MaterialId>(impl_->scene->materials, impl_->stamps.materials, name);
}

std::string Scene::name(const NodeId& id) const
{
    return impl_->scene->nodes[api::require(impl_->stamps.nodes, id, "the node")].name;
}

NodeId Scene::parent(const NodeId& id) const
{
    const scene::NodeId parent = impl_->scene->nodes[api::require(impl_->stamps.nodes, id, "the node")].parent;
    return parent == scene::none ? NodeId{} : impl_->stamps.nodes.id<NodeId>(parent);
}

Mobility Scene::mobility(const NodeId& id) const
{
    const scene::Scene& scene = *impl_->scene;
    const scene::NodeId node = api::require(impl_->stamps.nodes, id, "the node");
    if (scene.nodes[node].deforms) return Mobility::may_deform;
    for (const scene::Object& object : scene.objects)
        if (object.node == node && object.deforming && object.dynamic) return Mobility::may_deform;
    for (scene::NodeId n = node; n != scene::none; n = scene.nodes[n].parent)
        if (scene.nodes[n].may_move()) return Mobility::may_move;
    return Mobility::fixed;
}

NodeId Scene::moving_node(const NodeId& id) const
{
    const scene::Scene& scene = *impl_->scene;
    const scene::NodeId node = api::require(impl_->stamps.nodes, id, "the node");
    // The nearest animated node moves all below it together.
    for (scene::NodeId n = node; n != scene::none; n = scene.nodes[n].parent)
        if (scene.nodes[n].may_move()) return impl_->stamps.nodes.id<NodeId>(n);
    return id;
}

Transform Scene::transform(const NodeId& id) const
{
    const scene::Scene& scene = *impl_->scene;
    const scene::Node& node = scene.nodes[api::require(impl_->stamps.nodes, id, "the node")];
    return api::transform_of(local_of(*impl_, node));
}

MeshId Scene::mesh(const InstanceId& id) const
{
    const scene::NodeId node = api::require(impl_->stamps.nodes, id, "the instance");
    if (!is_instance(*impl_->scene, impl_->scene->nodes[node])) return {};
    const scene::MeshId mesh = impl_->scene->nodes[node].mesh;
    const auto base = impl_->stamps.mesh_variants.find(mesh);
    return impl_->stamps.meshes.id<MeshId>(base == impl_->stamps.mesh_variants.end() ? mesh : base->second.mesh);
}

NodeId Scene::node(const LightId& id) const
{
    return impl_->stamps.nodes.id<NodeId>(
        impl_->scene->lights[api::require(impl_->stamps.lights, id, "the light")].node);
}

NodeId Scene::node(const CameraId& id) const
{
    return impl_->stamps.nodes.id<NodeId>(
        impl_->scene->cameras[api::require(impl_->stamps.cameras, id, "the camera")].node);
}

Light Scene::light(const LightId& id) const
{
    return api::from_scene(impl_->scene->lights[api::require(impl_->stamps.lights, id, "the light")]);
}

Material Scene::material(const MaterialId& id) const
{
    return api::from_scene(impl_->scene->materials[api::require(impl_->stamps.materials, id, "the material")],
                           impl_->stamps);
}

Camera Scene::camera(const CameraId& id) const
{
    const scene::Camera& camera = impl_->scene->cameras[api::require(impl_->stamps.cameras, id, "the camera")];
    return api::from_scene(camera, local_of(*impl_, impl_->scene->nodes[camera.node]));
}

InstanceId Scene::instance_of(std::uint32_t value) const
{
    const scene::Scene& scene = *impl_->scene;
    if (value == 0 || value > scene.nodes.size() || !is_instance(scene, scene.nodes[value - 1])) return {};
    return instance_at(*impl_, value - 1);
}

MaterialId Scene::material_of(std::uint32_t value) const
{
    if (value == 0 || value > impl_->stamps.materials.size()) return {};
    return impl_->stamps.materials.id<MaterialId>(value - 1);
}

}   // namespace gnomon
