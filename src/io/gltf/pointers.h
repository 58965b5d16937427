// SPDX-License-Identifier: Apache-2.0
#pragma once
// What KHR_animation_pointer points to: properties of nodes, which are animated like those of ordinary channels, and
// the properties of lights, materials and cameras that this importer can animate.

#include <optional>
#include <string>

#include "io/gltf/model.h"
#include "scene/value_tracks.h"

namespace gnomon::io::gltf {

enum class Owner : std::uint8_t { light, material, camera };

Owner owner_of(Property property);
/// How many numbers its value has.
int components_of(Property property);

/// The part of a material that a property is, without a track; nothing for others.
std::optional<scene::MaterialPart> part_of(Property property);
/// Why a pointer is ignored that leads to something known; null: it is not known.
const char* why_ignored(const std::string& pointer);

/// Replaces pointers to properties of nodes by the nodes and paths that they point to, and notes the properties of
/// lights, materials and cameras that others point to. What is not known, or does not exist, stays as it is.
void resolve_pointers(Model& model);

}   // namespace gnomon::io::gltf
