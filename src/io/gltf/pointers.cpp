// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/pointers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <limits>

#include "base/check.h"
#include "scene/material.h"
#include "scene/material_layers.h"

namespace gnomon::io::gltf {

namespace {

constexpr std::string_view k_nodes = "/nodes/", k_lights = "/extensions/KHR_lights_punctual/lights/",
                           k_materials = "/materials/", k_cameras = "/cameras/";

// The properties of nodes, by what follows the node's index.
constexpr std::pair<std::string_view, Path> k_paths[] = {{"translation", Path::translation},
                                                         {"rotation", Path::rotation},
                                                         {"scale", Path::scale},
                                                         {"weights", Path::weights},
                                                         {"extensions/KHR_node_visibility/visible", Path::visibility}};

struct Row {
    Property property;
    Owner owner;
    std::string_view name;   // what follows the owner's index
    int components;
};
constexpr Row k_rows[] = {
    {Property::light_color, Owner::light, "color", 3},
    {Property::light_intensity, Owner::light, "intensity", 1},
    {Property::light_range, Owner::light, "range", 1},
    {Property::light_inner, Owner::light, "spot/innerConeAngle", 1},
    {Property::light_outer, Owner::light, "spot/outerConeAngle", 1},
    {Property::base_color, Owner::material, "pbrMetallicRoughness/baseColorFactor", 4},
    {Property::metallic, Owner::material, "pbrMetallicRoughness/metallicFactor", 1},
    {Property::roughness, Owner::material, "pbrMetallicRoughness/roughnessFactor", 1},
    {Property::emissive, Owner::material, "emissiveFactor", 3},
    {Property::emissive_strength, Owner::material, "extensions/KHR_materials_emissive_strength/emissiveStrength", 1},
    {Property::yfov, Owner::camera, "perspective/yfov", 1},
    {Property::ymag, Owner::camera, "orthographic/ymag", 1},
    {Property::camera_near, Owner::camera, "perspective/znear", 1},
    {Property::camera_near, Owner::camera, "orthographic/znear", 1},
    {Property::camera_far, Owner::camera, "perspective/zfar", 1},
    {Property::camera_far, Owner::camera, "orthographic/zfar", 1}};

constexpr float k_most = std::numeric_limits<float>::max();
// Transmission that changes stays above 0, so that rays pass the surface at all times.
constexpr float k_least_transmission = 1e-6f;

// A part of a material, by what follows the material's index.
struct PartRow {
    std::string name;
    scene::MaterialPart part;
};

const std::vector<PartRow>& material_parts()
{
    using scene::Material;
    using scene::MaterialLayers;
    static const std::vector<PartRow> rows = [] {
        std::vector<PartRow> made;
        const auto add = [&](std::string name, auto member, float least, float most,
                             scene::MaterialPart::Place place = scene::MaterialPart::Place::offset) {
            made.push_back({std::move(name), {member, place, least, most, nullptr}});
        };
        const auto extended = [](const char* extension, const char* name) {
            return fmt::format("extensions/KHR_materials_{}/{}", extension, name);
        };
        add("normalTexture/scale", &Material::normal_scale, -k_most, k_most);
        add("occlusionTexture/strength", &Material::occlusion_strength, 0, 1);
        add(extended("ior", "ior"), &Material::ior, 1, k_most);
        add(extended("transmission", "transmissionFactor"), &Material::transmission, k_least_transmission, 1);
        add(extended("volume", "thicknessFactor"), &MaterialLayers::thickness, 0, k_most);
        add(extended("volume", "attenuationDistance"), &MaterialLayers::attenuation_distance, 0, k_most);
        add(extended("volume", "attenuationColor"), &MaterialLayers::attenuation_color, 0, 1);
        add(extended("specular", "specularFactor"), &MaterialLayers::specular, 0, 1);
        add(extended("specular", "specularColorFactor"), &MaterialLayers::specular_color, 0, k_most);
        add(extended("clearcoat", "clearcoatFactor"), &MaterialLayers::clearcoat, 0, 1);
        add(extended("clearcoat", "clearcoatRoughnessFactor"), &MaterialLayers::clearcoat_roughness, 0, 1);
        add(extended("clearcoat", "clearcoatNormalTexture/scale"), &MaterialLayers::clearcoat_normal_scale, -k_most,
            k_most);
        add(extended("sheen", "sheenColorFactor"), &MaterialLayers::sheen_color, 0, 1);
        add(extended("sheen", "sheenRoughnessFactor"), &MaterialLayers::sheen_roughness, 0, 1);
        add(extended("anisotropy", "anisotropyStrength"), &MaterialLayers::anisotropy, 0, 1);
        add(extended("anisotropy", "anisotropyRotation"), &MaterialLayers::anisotropy_rotation, -k_most, k_most);
        add(extended("iridescence", "iridescenceFactor"), &MaterialLayers::iridescence, 0, 1);
        add(extended("iridescence", "iridescenceIor"), &MaterialLayers::iridescence_ior, 1, k_most);
        add(extended("iridescence", "iridescenceThicknessMinimum"), &MaterialLayers::iridescence_thickness_least, 0,
            k_most);
        add(extended("iridescence", "iridescenceThicknessMaximum"), &MaterialLayers::iridescence_thickness_most, 0,
            k_most);
        add(extended("dispersion", "dispersion"), &MaterialLayers::dispersion, 0, k_most);
        // Where textures lie. That of emission is part of lights, whose places are found once.
        const auto add_places = [&](const std::string& texture, auto member) {
            using enum scene::MaterialPart::Place;
            for (const auto& [name, place] : {std::pair{"offset", offset}, {"scale", scale}, {"rotation", rotation}})
                add(fmt::format("{}/extensions/KHR_texture_transform/{}", texture, name), member, -k_most, k_most,
                    place);
        };
        add_places("pbrMetallicRoughness/baseColorTexture", &Material::base_color_texture);
        add_places("pbrMetallicRoughness/metallicRoughnessTexture", &Material::metallic_roughness_texture);
        add_places("normalTexture", &Material::normal_texture);
        add_places("occlusionTexture", &Material::occlusion_texture);
        for (std::size_t i = 0; i < std::size(k_layer_textures); ++i)
            add_places(fmt::format("extensions/{}/{}", k_layer_textures[i].extension, k_layer_textures[i].property),
                       scene::k_layer_textures[i]);
        GNOMON_CHECK(made.size() < 256 - static_cast<std::size_t>(Property::first_part));
        return made;
    }();
    return rows;
}

const Row& row_of(Property property)
{
    GNOMON_CHECK(property < Property::first_part);
    const auto* const row = std::ranges::find(k_rows, property, &Row::property);
    GNOMON_CHECK(row != std::end(k_rows));
    return *row;
}

// An element of a list, and the rest of the pointer behind it.
struct Element {
    Index index = 0;
    std::string_view rest;
};

// Reads "PREFIX INDEX / REST".
std::optional<Element> element_of(std::string_view pointer, std::string_view prefix, std::size_t count)
{
    if (!pointer.starts_with(prefix)) return {};
    pointer.remove_prefix(prefix.size());
    Element element;
    const char* const end = pointer.data() + pointer.size();
    const auto [stop, error] = std::from_chars(pointer.data(), end, element.index);
    if (error != std::errc() || stop == end || *stop != '/' || element.index >= count) return {};
    element.rest = std::string_view(stop + 1, static_cast<std::size_t>(end - stop - 1));
    return element;
}

void resolve(const Model& model, Channel& channel)
{
    if (const auto node = element_of(channel.pointer, k_nodes, model.nodes.size())) {
        const auto* const known = std::ranges::find(k_paths, node->rest, &std::pair<std::string_view, Path>::first);
        if (known == std::end(k_paths)) return;
        channel.node = node->index, channel.path = known->second, channel.path_word = known->first;
        channel.has_pointer = false;
        return;
    }
    const auto note = [&](Owner owner, const std::optional<Element>& element) {
        if (!element) return;
        for (const Row& row : k_rows)
            if (row.owner == owner && row.name == element->rest)
                channel.property = row.property, channel.owner = element->index;
    };
    note(Owner::light, element_of(channel.pointer, k_lights, model.lights.size()));
    note(Owner::material, element_of(channel.pointer, k_materials, model.materials.size()));
    note(Owner::camera, element_of(channel.pointer, k_cameras, model.cameras.size()));
    if (const auto material = element_of(channel.pointer, k_materials, model.materials.size())) {
        const std::vector<PartRow>& parts = material_parts();
        const auto known = std::ranges::find(parts, material->rest, &PartRow::name);
        if (known == parts.end()) return;
        channel.property = static_cast<Property>(static_cast<std::size_t>(Property::first_part) +
                                                 static_cast<std::size_t>(known - parts.begin()));
        channel.owner = material->index;
    }
}

// Replaces a pointer to the weights of a mesh by channels for the nodes that have the mesh and no weights of their own.
void resolve_mesh_weights(const Model& model, Animation& animation)
{
    std::vector<Channel> more;
    for (Channel& channel : animation.channels) {
        if (!channel.has_pointer || channel.path != Path::pointer || channel.node != k_absent) continue;
        const auto mesh = element_of(channel.pointer, "/meshes/", model.meshes.size());
        if (!mesh || mesh->rest != "weights") continue;
        bool first = true;
        const Channel pointing = channel;
        for (Index n = 0; n < model.nodes.size() && more.size() < model.nodes.size(); ++n) {
            if (model.nodes[n].mesh != mesh->index || model.nodes[n].weights) continue;
            Channel& resolved = first ? channel : more.emplace_back(pointing);
            resolved.node = n, resolved.path = Path::weights, resolved.path_word = "weights";
            resolved.has_pointer = false;
            first = false;
        }
    }
    animation.channels.insert(animation.channels.end(), more.begin(), more.end());
}

}   // namespace

Owner owner_of(Property property)
{
    return property >= Property::first_part ? Owner::material : row_of(property).owner;
}

int components_of(Property property)
{
    if (const auto part = part_of(property)) return part->components();
    return row_of(property).components;
}

std::optional<scene::MaterialPart> part_of(Property property)
{
    if (property < Property::first_part) return {};
    return material_parts()
        .at(static_cast<std::size_t>(property) - static_cast<std::size_t>(Property::first_part))
        .part;
}

const char* why_ignored(const std::string& pointer)
{
    if (pointer.ends_with("/alphaCutoff")) return "holes of a surface cannot change: ignored";
    if (pointer.ends_with("/xmag") || pointer.ends_with("/aspectRatio")) return "the image's size decides: ignored";
    if (pointer.find("/emissiveTexture/") != std::string::npos) return "a texture of emission cannot move: ignored";
    return nullptr;
}

void resolve_pointers(Model& model)
{
    for (Animation& animation : model.animations) {
        for (Channel& channel : animation.channels)
            if (channel.has_pointer && channel.path == Path::pointer && channel.node == k_absent)
                resolve(model, channel);
        resolve_mesh_weights(model, animation);
    }
}

}   // namespace gnomon::io::gltf
