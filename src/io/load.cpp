// SPDX-License-Identifier: Apache-2.0
#include "io/load.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::io {

scene::Scene load_scene(const std::filesystem::path& file, const Progress&)
{
    const std::string extension = file.extension().string();
    throw UsageError(fmt::format("{}: unknown kind of scene '{}'", file.string(), extension));
}

}   // namespace gnomon::io
