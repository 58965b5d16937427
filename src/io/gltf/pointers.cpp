// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/pointers.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>

#include "base/check.h"

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
    {Property::ymag, Owner::camera, "orthographic/ymag", 1}};

const Row& row_of(Property property)
{
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
}

}   // namespace

Owner owner_of(Property property)
{
    return row_of(property).owner;
}

int components_of(Property property)
{
    return row_of(property).components;
}

void resolve_pointers(Model& model)
{
    for (Animation& animation : model.animations)
        for (Channel& channel : animation.channels)
            if (channel.has_pointer && channel.path == Path::pointer && channel.node == k_absent)
                resolve(model, channel);
}

}   // namespace gnomon::io::gltf
