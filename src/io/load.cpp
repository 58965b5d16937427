// SPDX-License-Identifier: Apache-2.0
#include "io/load.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::io {

scene::Scene load_scene(const std::filesystem::path& file, const Progress& progress)
{
    const std::string extension = file.extension().string();
    if (extension == ".aff") return load_aff(file, progress);
    throw UsageError(fmt::format("{}: unknown kind of scene '{}'; .aff is read", file.string(), extension));
}

}   // namespace gnomon::io
