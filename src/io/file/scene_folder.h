// SPDX-License-Identifier: Apache-2.0
#pragma once
// Resolves files that a scene file refers to: regular files in its own folder or below, after following links. Others
// (a FIFO, a device, a folder, a file outside) are never opened. Read the results with read_whole_file.

#include <filesystem>
#include <optional>
#include <string>

#include "io/file/read_file.h"

namespace gnomon::io {

class SceneFolder {
 public:
    /// @param scene_file  files must lie in its folder
    explicit SceneFolder(const std::filesystem::path& scene_file);

    /// Returns the path of a file, or nothing and the reason.
    /// @param name  as written in the scene file; relative; a backslash counts as a slash, because exporters on Windows
    ///              write it
    std::optional<std::filesystem::path> find(std::string name, std::string& problem) const;

 private:
    std::filesystem::path folder_;   // canonical; empty if it does not exist
};

}   // namespace gnomon::io
