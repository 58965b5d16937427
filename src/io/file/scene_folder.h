// SPDX-License-Identifier: Apache-2.0
#pragma once
// Resolves files that a scene file refers to: regular files in its own folder or below, after following links. Others
// (a FIFO, a device, a folder, a file outside) are never opened. Read the results with read_whole_file.

#include <filesystem>
#include <optional>
#include <string>

#include "io/file/read_file.h"

namespace gnomon::io {

/// The name of the file that a name probably means: with slashes for backslashes, without quotation marks, with letters
/// of the other case, or in the folder itself, because files are moved between computers together with what they refer
/// to. Returns nothing if there is none; what is returned may still lie outside the folder.
std::string name_like(const std::filesystem::path& folder, const std::string& name);

class SceneFolder {
 public:
    /// @param scene_file  files must lie in its folder
    explicit SceneFolder(const std::filesystem::path& scene_file);

    /// Returns the path of a file, or nothing and the reason. If a file with a similar name is found instead
    /// (name_like()), the problem says so; otherwise it is empty.
    /// @param name  as written in the scene file; relative; a backslash counts as a slash, because exporters on Windows
    ///              write it
    std::optional<std::filesystem::path> find(std::string name, std::string& problem) const;

 private:
    std::filesystem::path folder_;   // canonical; empty if it does not exist
};

}   // namespace gnomon::io
