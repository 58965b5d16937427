// SPDX-License-Identifier: Apache-2.0
#include "gnomon/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "api/area_light_shape.h"
#include "api/convert.h"
#include "api/environment.h"
#include "api/scene_access.h"
#include "api/scene_builder_impl.h"
#include "base/one_line.h"
#include "gnomon/error.h"
#include "gnomon/ranges.h"
#include "io/image/image_file.h"
#include "scene/defaults/emissive_lights.h"
#include "scene/near_origin.h"

namespace gnomon {

using api::with_memory;

namespace {

constexpr double k_highest_fps = 1000;

scene::Sampler sampler_of(const Texture& texture)
{
    const std::string owner = api::titled("texture", texture.name);
    for (const Wrap wrap : {texture.wrap_u, texture.wrap_v})
        api::require_known(wrap, Wrap::clamp, owner, "the wrapping");
    for (const Filter filter : {texture.magnify, texture.minify})
        api::require_known(filter, Filter::linear, owner, "the filter");
    return {static_cast<scene::Wrap>(texture.wrap_u), static_cast<scene::Wrap>(texture.wrap_v),
            static_cast<scene::Filter>(texture.magnify), static_cast<scene::Filter>(texture.minify), texture.mipmaps};
}

Image8 image_of(const Texture& texture)
{
    const std::string owner = api::titled("texture", texture.name);
    if (!ranges::image_side.contains(texture.width) || !ranges::image_side.contains(texture.height) ||
        std::int64_t{texture.width} * texture.height > ranges::k_max_pixels)
        throw UsageError(fmt::format("{}: size {} x {} is out of range", owner, texture.width, texture.height));
    if (texture.channels < 1 || texture.channels > 4)
        throw UsageError(fmt::format("{}: {} channels: expected 1 to 4", owner, texture.channels));
    const std::ptrdiff_t row = std::ptrdiff_t{texture.width} * texture.channels;
    const std::ptrdiff_t step = texture.row_bytes == 0 ? row : texture.row_bytes;
    if (step < row) throw UsageError(fmt::format("{}: rows of {} bytes, {} apart, overlap", owner, row, step));
    // Divide instead of multiplying, because the product may overflow.
    const std::ptrdiff_t bytes = std::ssize(texture.pixels);
    if (bytes < row || (texture.height > 1 && step > (bytes - row) / (texture.height - 1)))
        throw UsageError(fmt::format("{}: {} bytes of pixels are too few for {} x {} pixels in rows {} bytes apart",
                                     owner, bytes, texture.width, texture.height, step));
    Image8 image(texture.width, texture.height, texture.channels);
    for (int y = 0; y < texture.height; ++y)
        std::memcpy(image.pixel(0, y), texture.pixels.data() + y * step, static_cast<std::size_t>(row));
    return image;
}

}   // namespace

SceneBuilder::SceneBuilder() : impl_(std::make_unique<Impl>()) {}

SceneBuilder::SceneBuilder(const Scene& scene) : impl_(std::make_unique<Impl>())
{
    const Scene::Impl& from = api::SceneAccess::impl(scene);
    impl_->scene = *from.scene;
    impl_->stamps = from.stamps;
    const auto note_free = [](const api::StampList& stamps, std::set<std::uint32_t>& free) {
        for (std::size_t i = 0; i < stamps.size(); ++i)
            if (stamps[i] == 0) free.insert(static_cast<std::uint32_t>(i));
    };
    note_free(from.stamps.nodes, impl_->free_nodes);
    note_free(from.stamps.materials, impl_->free_materials);
    note_free(from.stamps.textures, impl_->free_textures);
    note_free(from.stamps.skins, impl_->free_skins);
    for (std::size_t m = 0; m < from.stamps.meshes.size(); ++m)
        if (from.stamps.meshes[m] == 0 && !from.stamps.mesh_variants.contains(static_cast<scene::MeshId>(m)))
            impl_->free_meshes.insert(static_cast<std::uint32_t>(m));
    impl_->mesh_users.assign(from.stamps.meshes.size(), 0);
    for (const scene::Node& node : from.scene->nodes)
        if (node.mesh != scene::none) ++impl_->mesh_users[node.mesh];
    // finish() makes the lights anew that approximate emissive surfaces.
    impl_->remove_lights(&scene::Light::of_surface);
}

SceneBuilder::~SceneBuilder() = default;
SceneBuilder::SceneBuilder(SceneBuilder&&) noexcept = default;
SceneBuilder& SceneBuilder::operator=(SceneBuilder&&) noexcept = default;

SceneBuilder::Impl& SceneBuilder::impl()
{
    if (!impl_) throw UsageError("a scene builder that was moved from builds nothing");
    return *impl_;
}

MeshId SceneBuilder::mesh(const Mesh& mesh)
{
    return with_memory([&] {
        Impl& in = impl();
        scene::Mesh made = api::to_scene(mesh, in.stamps, scene::none);
        in.fill_materials(made);
        return in.stamps.meshes.id<MeshId>(in.add_mesh(std::move(made)));
    });
}

MaterialId SceneBuilder::material(const Material& material)
{
    return with_memory([&] {
        Impl& in = impl();
        return in.stamps.materials.id<MaterialId>(in.add_material(api::to_scene(material, in.stamps)));
    });
}

TextureId SceneBuilder::texture(const Texture& texture)
{
    return with_memory([&] {
        Impl& in = impl();
        const scene::Sampler sampler = sampler_of(texture);
        return in.stamps.textures.id<TextureId>(
            in.add_texture(scene::Texture(texture.name, image_of(texture), texture.srgb, sampler)));
    });
}

TextureId SceneBuilder::texture(std::span<const std::byte> file, const Texture& as)
{
    return with_memory([&] {
        Impl& in = impl();
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
        const scene::Sampler sampler = sampler_of(as);
        const Image8 image =
            io::decode_image({bytes, file.size()}, as.name.empty() ? "texture in memory" : shown_name(as.name));
        return in.stamps.textures.id<TextureId>(in.add_texture(scene::Texture(as.name, image, as.srgb, sampler)));
    });
}

SkinId SceneBuilder::skin(const Skin& skin)
{
    return with_memory([&] {
        Impl& in = impl();
        const std::string owner = api::titled("skin", skin.name);
        if (skin.joints.size() != skin.inverse_bind.size())
            throw UsageError(fmt::format("{}: {} joints and {} inverse bind matrices", owner, skin.joints.size(),
                                         skin.inverse_bind.size()));
        scene::Skin made;
        made.name = skin.name;
        for (const NodeId& joint : skin.joints)
            made.joints.push_back(api::require(in.stamps.nodes, joint, fmt::format("{}: a joint", owner)));
        for (const Transform& matrix : skin.inverse_bind) made.inverse_bind.push_back(api::matrix_of(matrix, owner));
        return in.stamps.skins.id<SkinId>(in.add_skin(std::move(made)));
    });
}

NodeId SceneBuilder::node(const Transform& transform, const NodeOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        return in.stamps.nodes.id<NodeId>(in.add_node(transform, options, api::titled("node", options.name)));
    });
}

InstanceId SceneBuilder::instance(const MeshId& mesh, const MaterialId& material, const Transform& transform,
                                  const InstanceOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        const std::string owner = api::titled("instance", options.name);
        const Impl::Attachment attachment = in.check_attachment(mesh, material, options, owner);
        const scene::NodeId node = in.add_node(transform, {options.mobility, options.parent, options.name}, owner);
        in.attach(node, attachment, options);
        return InstanceId(in.stamps.nodes.id<NodeId>(node));
    });
}

InstanceId SceneBuilder::attach(const NodeId& id, const MeshId& mesh, const MaterialId& material,
                                const InstanceOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        const scene::NodeId node = api::require(in.stamps.nodes, id, "the node");
        const std::string owner = api::titled("node", in.scene.nodes[node].name);
        if (in.scene.nodes[node].mesh != scene::none) throw UsageError(fmt::format("{}: it has a mesh already", owner));
        const Impl::Attachment attachment = in.check_attachment(mesh, material, options, owner);
        if (options.mobility != Mobility::fixed) in.declare(node, options.mobility);
        in.attach(node, attachment, options);
        return InstanceId(id);
    });
}

LightId SceneBuilder::light(const Light& light, const Transform& transform, const NodeOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        scene::Light made = api::to_scene(light);
        made.node = in.add_node(transform, options, api::titled("light", light.name));
        in.scene.lights.push_back(std::move(made));
        in.stamps.lights.renew(in.scene.lights.size() - 1);
        return in.stamps.lights.id<LightId>(in.scene.lights.size() - 1);
    });
}

AreaLightParts SceneBuilder::area_light(const AreaLight& light, const Transform& transform,
                                        const InstanceOptions& options)
{
    const api::LightShape shape = with_memory([&] { return api::shape_of(light); });
    std::optional<MaterialLayers> layers;
    if (light.outer_angle != 0) {
        layers.emplace();
        layers->emission_inner = light.inner_angle, layers->emission_outer = light.outer_angle;
    }
    const MaterialId emission = material({.name = light.name,
                                          .base_color = {0, 0, 0},
                                          .double_sided = light.two_sided && light.shape != AreaLightShape::sphere,
                                          .emissive = light.radiance,
                                          .layers = layers,
                                          .hidden_from_camera = light.hidden_from_camera});
    MeshId made;
    try {
        made = mesh(
            {.positions = shape.positions, .indices = shape.indices, .normals = shape.normals, .name = light.name});
        return {instance(made, emission, transform, options), emission};
    } catch (...) {
        // Leave the builder as it was.
        if (made) remove(made);
        remove(emission);
        throw;
    }
}

CameraId SceneBuilder::camera(const Camera& camera, const NodeOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        scene::Camera made = api::to_scene(camera);
        made.node = in.add_node(camera.transform, options, api::titled("camera", camera.name));
        in.scene.cameras.push_back(std::move(made));
        in.stamps.cameras.renew(in.scene.cameras.size() - 1);
        return in.stamps.cameras.id<CameraId>(in.scene.cameras.size() - 1);
    });
}

void SceneBuilder::environment(const EnvironmentImage& image, int lights)
{
    with_memory([&] {
        Impl& in = impl();
        api::check_environment_lights(lights);
        if (!ranges::image_side.contains(image.width) || !ranges::image_side.contains(image.height) ||
            std::int64_t{image.width} * image.height > ranges::k_max_pixels)
            throw UsageError(fmt::format("environment: size {} x {} is out of range", image.width, image.height));
        const std::size_t expected =
            std::size_t{3} * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
        if (image.pixels.size() != expected)
            throw UsageError(
                fmt::format("environment: {} numbers for pixels: expected {}", image.pixels.size(), expected));
        ImageF pixels(image.width, image.height, 3);
        std::copy(image.pixels.begin(), image.pixels.end(), pixels.data.begin());
        auto environment = std::make_shared<const scene::Environment>(std::move(pixels));
        in.remove_lights(&scene::Light::of_environment);
        api::set_environment(
            in.scene, in.stamps, std::move(environment), lights, [&](const std::string& name, const glm::dmat4& local) {
                return in.add_node(api::transform_of(scene::translated(local, in.stamps.origin)), {.name = name}, name);
            });
    });
}

void SceneBuilder::background(const Vec3& color)
{
    if (!is_finite(api::vec(color)) || std::min({color.x, color.y, color.z}) < 0)
        throw UsageError("background: the colour is negative or not finite");
    Impl& in = impl();
    in.remove_lights(&scene::Light::of_environment);
    in.scene.background = {};
    in.scene.background.color = api::vec(color);
}

void SceneBuilder::ambient(const Vec3& color)
{
    if (!is_finite(api::vec(color)) || std::min({color.x, color.y, color.z}) < 0)
        throw UsageError("ambient: the colour is negative or not finite");
    impl().scene.ambient = api::vec(color);
}

void SceneBuilder::clip(double start, double end, double fps)
{
    if (!(std::isfinite(start) && std::isfinite(end) && end >= start))
        throw UsageError(fmt::format("clip: from {} s to {} s", start, end));
    if (!(fps > 0 && fps <= k_highest_fps && (end - start) * fps < scene::k_most_frames))
        throw UsageError(fmt::format("clip: {} frames a second: expected above 0, at most {}, and at most {} frames",
                                     fps, k_highest_fps, scene::k_most_frames));
    scene::Timeline timeline;
    timeline.start = start;
    timeline.end = end;
    impl().scene.timeline = timeline.at_rate(fps);
}

Scene SceneBuilder::finish(const FinishOptions& options)
{
    return with_memory([&] {
        Impl& in = impl();
        in.scene.finish();
        auto made = std::make_shared<scene::Scene>(in.scene);
        scene::add_emitter_lights(*made, {.fill = options.default_light});
        if (options.default_light) scene::add_default_light(*made);
        if (options.default_camera) scene::add_default_camera(*made);
        // Number what was added.
        api::SceneStamps stamps = in.stamps;
        while (stamps.nodes.size() < made->nodes.size()) stamps.nodes.renew(stamps.nodes.size());
        while (stamps.lights.size() < made->lights.size()) stamps.lights.renew(stamps.lights.size());
        while (stamps.cameras.size() < made->cameras.size()) stamps.cameras.renew(stamps.cameras.size());
        return api::SceneAccess::make(std::move(made), std::move(stamps));
    });
}

}   // namespace gnomon
