// SPDX-License-Identifier: Apache-2.0
#pragma once
// The files that a scene file may name: regular ones in its own folder or below, whatever links stand between. What is
// anything else (a FIFO, a device, a folder, outside) is not even opened. Read them with read_whole_file.

#include <filesystem>
#include <optional>
#include <string>

#include "io/file/read_file.h"

namespace gnomon::io {

class SceneFolder {
 public:
    /// @param scene_file  its folder is the limit
    explicit SceneFolder(const std::filesystem::path& scene_file);

    /// Where a name leads to, or nothing and the reason why not.
    /// @param name  as the file writes it; relative; a backslash counts as a slash, as exporters on Windows write it
    std::optional<std::filesystem::path> find(std::string name, std::string& problem) const;

 private:
    std::filesystem::path folder_;   // canonical; empty: there is none
};

}   // namespace gnomon::io
