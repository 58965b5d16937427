// SPDX-License-Identifier: Apache-2.0
#pragma once
// Makes the textures of MTL materials: reads files from the scene's folder, decodes them in parallel, and combines them
// (mask into the colour's alpha, roughness and metallic into G and B, heights into normals).
//
// Textures that cannot be read are left out with a warning, because scenes are often distributed without them.

#include "gnomon/types.h"
#include "io/file/scene_folder.h"
#include "io/obj/mtl.h"
#include "scene/memory_budget.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Adds the textures of mtl[i] to scene.materials[i].
/// @throws InterruptedError
void add_obj_textures(scene::Scene& scene, const std::vector<MtlMaterial>& mtl, const SceneFolder& folder,
                      scene::MemoryBudget& memory);

}   // namespace gnomon::io
