// SPDX-License-Identifier: Apache-2.0
#include "io/load.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::io {

scene::Scene load_scene(const std::filesystem::path& file, const Progress& progress, const ReadOptions& options)
{
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (extension == ".aff") return load_aff(file, progress, options);
    if (extension == ".obj") return load_obj(file, progress, options);
    if (extension == ".gltf" || extension == ".glb") return load_gltf(file, progress, options);
    if (extension == ".ply") return load_ply(file, progress, options);
    if (extension == ".stl") return load_stl(file, progress, options);
    throw UsageError(fmt::format("{}: unknown scene format '{}'; use .gltf, .glb, .obj, .ply, .stl or .aff",
                                 file.string(), extension));
}

}   // namespace gnomon::io
