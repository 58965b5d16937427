// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scene files in, by extension. Every importer is strict: what it accepts is whole and safe, what it refuses is named
// with file and place (InputError), and every allocation is bounded by input that exists.

#include <filesystem>

#include "gnomon/types.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Finished (Scene::finish was called), without default light and camera.
/// @throws InputError, UsageError (unknown extension), InterruptedError
scene::Scene load_scene(const std::filesystem::path& file, const Progress& progress = {});

/// BART's AFF.
scene::Scene load_aff(const std::filesystem::path& file, const Progress& progress = {});

/// Wavefront OBJ with MTL. What the file says wrongly is an error; what it lacks (materials, textures, normals) is
/// replaced, with a warning; what it says and we cannot show (lines, curves) is a warning, too.
scene::Scene load_obj(const std::filesystem::path& file, const Progress& progress = {});

/// glTF 2.0: .gltf with its buffers and images below its own folder, or .glb. Places in errors are JSON pointers
/// (line:column where the JSON itself is broken, "byte N" in a GLB's frame).
scene::Scene load_gltf(const std::filesystem::path& file, const Progress& progress = {});

}   // namespace gnomon::io
