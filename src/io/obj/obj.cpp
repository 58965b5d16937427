// SPDX-License-Identifier: Apache-2.0
// Loads OBJ scenes: text, materials, meshes, textures, in that order; see the headers of each.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/file/scene_folder.h"
#include "io/load.h"
#include "io/obj/data.h"
#include "io/obj/mesh.h"
#include "io/obj/mtl.h"
#include "io/obj/textures.h"
#include "scene/file_surfaces.h"

namespace gnomon::io {

namespace {

constexpr std::uint64_t k_largest_obj = 4ull << 30;
// What a group and a material become, however small they are; measured.
constexpr std::uint64_t k_bytes_per_object = 2400, k_bytes_per_material = 1800;
constexpr std::uint64_t k_largest_mtl = 64ull << 20;
constexpr std::size_t k_most_libraries = 256;   // files
constexpr glm::vec3 k_default_grey{0.6f};       // of faces without a material

std::string_view text_of(const std::vector<std::uint8_t>& bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The new library names on one line: the whole line if such a file exists (names may contain blanks), else its words
// up to a limit.
std::vector<std::string> library_names(const std::string& line, const SceneFolder& folder,
                                       std::unordered_set<std::string>& known)
{
    if (known.contains(line)) return {};
    std::string problem;
    std::vector<std::string> names;
    // A similar name with blanks counts as one name only where it can be no list of names.
    const bool one = line.find_first_of(" \t") == std::string::npos || line.find_first_of("\\:\"") != std::string::npos;
    if (folder.find(line, problem) && (problem.empty() || one)) {
        known.insert(line);
        return {line};
    }
    for (std::size_t at = 0; at < line.size() && known.size() <= k_most_libraries;) {
        const std::size_t begin = line.find_first_not_of(" \t", at);
        if (begin == std::string::npos) break;
        at = std::min(line.find_first_of(" \t", begin), line.size());
        std::string name = line.substr(begin, at - begin);
        if (known.insert(name).second) names.push_back(std::move(name));
    }
    return names;
}

std::vector<MtlMaterial> read_libraries(const ObjData& data, const SceneFolder& folder, bool strict,
                                        std::vector<std::string>& warnings)
{
    std::vector<MtlMaterial> materials;
    std::unordered_set<std::string> known;
    std::set<std::filesystem::path> read;   // canonical, because one file may have many names: "a", "./a"
    std::size_t count = 0;
    for (const std::string& line : data.libraries) {
        for (const std::string& name : library_names(line, folder, known)) {
            if (++count > k_most_libraries) {
                warnings.emplace_back("too many material files: the others are left out");
                return materials;
            }
            std::string problem;
            const auto path = folder.find(name, problem);
            if (!path) {
                warnings.push_back(fmt::format("material file '{}' is left out: {}", shown(name), problem));
                continue;
            }
            if (!problem.empty()) warnings.push_back(fmt::format("material file '{}' {}", shown(name), problem));
            if (!read.insert(*path).second) continue;
            const auto bytes = read_whole_file(*path, name, k_largest_mtl);
            ObjText text(name, text_of(bytes), !strict);
            for (MtlMaterial& material : parse_mtl(text, strict, warnings)) materials.push_back(std::move(material));
        }
    }
    return materials;
}

}   // namespace

scene::Scene load_obj(const std::filesystem::path& file, const Progress& progress, const ReadOptions& options)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    report_progress("loading", 0);
    scene::Scene scene;
    scene.name = file.stem().string();
    const SceneFolder folder(file);

    // Parse the file, and release its text.
    ObjData data;
    {
        const auto bytes = read_whole_file(file, file.string(), k_largest_obj);
        ObjText text(file.string(), text_of(bytes), !options.strict);
        data = parse_obj(text, options.strict, scene.warnings);
    }

    // Create a material for every name that is used. If two have the same name, the first is used.
    const std::vector<MtlMaterial> library = read_libraries(data, folder, options.strict, scene.warnings);
    std::unordered_map<std::string, std::size_t> by_name;
    for (std::size_t i = 0; i < library.size(); ++i) by_name.try_emplace(library[i].name, i);
    std::vector<char> used(data.materials.size(), 0);
    for (const ObjFace& face : data.faces) used[face.material] = 1;
    std::vector<scene::MaterialId> material_of(data.materials.size(), scene::none);
    std::vector<MtlMaterial> mtl;   // of scene.materials
    scene::MaterialId grey = scene::none;
    std::size_t missing = 0;
    std::string first_missing;
    for (std::size_t m = 0; m < data.materials.size(); ++m) {
        if (!used[m]) continue;
        const auto found = by_name.find(data.materials[m]);
        if (found != by_name.end() && !data.materials[m].empty()) {
            material_of[m] = static_cast<scene::MaterialId>(scene.materials.size());
            mtl.push_back(library[found->second]);
            scene.materials.push_back(material_from_mtl(mtl.back(), scene.warnings));
            continue;
        }
        if (!data.materials[m].empty() && ++missing == 1) first_missing = data.materials[m];
        if (grey == scene::none) {
            grey = static_cast<scene::MaterialId>(scene.materials.size());
            MtlMaterial plain;
            plain.diffuse = data.colors.empty() ? k_default_grey : glm::vec3(1);
            plain.name = "default";
            mtl.push_back(plain);
            scene.materials.push_back(material_from_mtl(plain, scene.warnings));
        }
        material_of[m] = grey;
    }
    if (missing > 0)
        scene.warnings.push_back(missing == 1
                                     ? fmt::format("material '{}' is not defined: grey is used", shown(first_missing))
                                     : fmt::format("material '{}' and {} more are not defined: grey is used",
                                                   shown(first_missing), missing - 1));

    // Add meshes and textures. A group becomes a mesh, a node and an object, however few faces it has.
    scene::MemoryBudget memory(options.memory);
    memory.take(data.objects.size() * k_bytes_per_object, scene.textures, {file.string(), "", "its groups"});
    memory.take(mtl.size() * k_bytes_per_material, scene.textures, {file.string(), "", "its materials"});
    add_obj_meshes(scene, data, material_of, {});
    data = {};
    add_obj_textures(scene, mtl, folder, memory);
    if (std::string halved = memory.warning(scene.textures); !halved.empty())
        scene.warnings.push_back(std::move(halved));
    scene::find_solid_blends(scene);
    scene::find_outlines(scene);
    if (!options.strict) repair_surfaces(scene);
    scene::add_tangents(scene);
    scene.finish();
    return scene;
}

}   // namespace gnomon::io
