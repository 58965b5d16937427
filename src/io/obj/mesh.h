// SPDX-License-Identifier: Apache-2.0
#pragma once
// Meshes of an OBJ file: one per object. Corners with equal position, texture coordinate and normal become one vertex,
// triangles are sorted by material, and v is flipped (OBJ counts it from the bottom row).

#include "io/obj/normals.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Adds a node and a mesh for every object that has faces.
/// @param material_of  scene material of each of data.materials
/// @throws InterruptedError
void add_obj_meshes(scene::Scene& scene, const ObjData& data, const std::vector<scene::MaterialId>& material_of,
                    const ObjNormalOptions& options);

}   // namespace gnomon::io
