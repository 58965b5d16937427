// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loads scene files by extension. A file that an importer accepts is complete and safe to use; otherwise InputError
// names the file, the place and the fault. The size of every allocation is bounded by input that exists.

#include <filesystem>
#include <string>

#include "gnomon/types.h"
#include "scene/memory_budget.h"
#include "scene/scene.h"

namespace gnomon::io {

/// How a file is read; see LoadOptions. Formats that have no repairs, clips or variants ignore these.
struct ReadOptions {
    bool strict = false;       // refuse every error, instead of repairing those that docs/guide/files.md lists
    std::string animation{};   // glTF: name or number of the clip that plays, "all", or empty
    std::string variant{};     // glTF: name of a variant, or empty
    std::uint64_t memory = scene::MemoryBudget::k_usual;   // bytes that the file may ask for
};

/// The scene is finished (Scene::finish was called) and has no default light or camera.
/// @throws InputError, UsageError (unknown extension, or no such clip or variant), InterruptedError
scene::Scene load_scene(const std::filesystem::path& file, const Progress& progress = {},
                        const ReadOptions& options = {});

/// BART's AFF, the animated file format.
scene::Scene load_aff(const std::filesystem::path& file, const Progress& progress = {},
                      const ReadOptions& options = {});

/// Wavefront OBJ with MTL. Invalid statements are errors. Missing parts (materials, textures, normals) are replaced
/// with a warning. Statements that are not supported (lines, curves) give a warning, too.
scene::Scene load_obj(const std::filesystem::path& file, const Progress& progress = {},
                      const ReadOptions& options = {});

/// PLY meshes, as text or binary in either byte order. Point clouds are rejected.
scene::Scene load_ply(const std::filesystem::path& file, const Progress& progress = {},
                      const ReadOptions& options = {});

/// STL meshes, as text or binary.
scene::Scene load_stl(const std::filesystem::path& file, const Progress& progress = {},
                      const ReadOptions& options = {});

/// glTF 2.0: .gltf with its buffers and images in its folder or below, or .glb. Places in errors are JSON pointers
/// (line:column if the JSON itself is invalid, "byte N" in the container of a GLB).
/// @throws UsageError  no such clip or variant
scene::Scene load_gltf(const std::filesystem::path& file, const Progress& progress = {},
                       const ReadOptions& options = {});

}   // namespace gnomon::io
