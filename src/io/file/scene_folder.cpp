// SPDX-License-Identifier: Apache-2.0
#include "io/file/scene_folder.h"

#include <algorithm>

namespace gnomon::io {

SceneFolder::SceneFolder(const std::filesystem::path& scene_file)
{
    std::error_code error;
    folder_ = std::filesystem::canonical(scene_file.has_parent_path() ? scene_file.parent_path() : ".", error);
    if (error) folder_.clear();
}

std::optional<std::filesystem::path> SceneFolder::find(std::string name, std::string& problem) const
{
    std::replace(name.begin(), name.end(), '\\', '/');
    if (name.size() > 1 && name[1] == ':') return problem = "is an absolute path", std::nullopt;
    if (folder_.empty()) return problem = "does not exist", std::nullopt;
    const std::filesystem::path found = resolve_inside(folder_, name, {folder_}, problem);
    if (found.empty()) return std::nullopt;
    return found;
}

}   // namespace gnomon::io
