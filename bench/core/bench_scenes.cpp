// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <filesystem>

#include "bench/report/chapter.h"

namespace gnomon::bench {

BenchScenes find_bench_scenes()
{
    const char* named = std::getenv("GNOMON_SCENES");
    const std::filesystem::path folder = named ? named : "../shared/scenes";
    const auto there = [&](const char* file) {
        std::error_code ignored;
        return std::filesystem::is_regular_file(folder / file, ignored) ? (folder / file).string() : std::string();
    };
    return {there("bart/kitchen/aff/kitchen.aff"), there("bart/robots/aff/Robot.aff"), "builtin:kinetic"};
}

}   // namespace gnomon::bench
