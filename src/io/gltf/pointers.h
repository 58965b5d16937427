// SPDX-License-Identifier: Apache-2.0
#pragma once
// What KHR_animation_pointer points to: properties of nodes, which are animated like those of ordinary channels, and
// the properties of lights, materials and cameras that this importer can animate.

#include "io/gltf/model.h"

namespace gnomon::io::gltf {

enum class Owner : std::uint8_t { light, material, camera };

Owner owner_of(Property property);
/// How many numbers its value has.
int components_of(Property property);

/// Replaces pointers to properties of nodes by the nodes and paths that they point to, and notes the properties of
/// lights, materials and cameras that others point to. What is not known, or does not exist, stays as it is.
void resolve_pointers(Model& model);

}   // namespace gnomon::io::gltf
