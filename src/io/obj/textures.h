// SPDX-License-Identifier: Apache-2.0
#pragma once
// The textures of MTL materials: read below the scene's folder, decoded in parallel, put together as the scene wants
// them (mask into the colour's alpha, roughness and metallic into G and B, heights into normals).
//
// What cannot be read is left out with a warning: scenes travel without their textures, and are still worth seeing.

#include "gnomon/types.h"
#include "io/file/scene_folder.h"
#include "io/obj/mtl.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Gives scene.materials[i] the textures of mtl[i].
/// @throws InterruptedError
void add_obj_textures(scene::Scene& scene, const std::vector<MtlMaterial>& mtl, const SceneFolder& folder,
                      const Progress& progress);

}   // namespace gnomon::io
