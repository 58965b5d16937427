// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "bench/report/chapter.h"

namespace gnomon::bench {

namespace {

constexpr const char* k_kitchen = "bart/kitchen/aff/kitchen.aff";
constexpr const char* k_robots = "bart/robots/aff/Robot.aff";
constexpr const char* k_buddha = "stanford/buddha_50k_decimated.obj";
constexpr const char* k_sponza = "sponza/sponza.obj";

}   // namespace

BenchScenes find_bench_scenes(const std::string& searched)
{
    const char* named = std::getenv("GNOMON_SCENES");
    const std::filesystem::path folder = !searched.empty() ? searched : named ? named : "../shared/scenes";
    const auto there = [&](const char* file) {
        std::error_code ignored;
        return std::filesystem::is_regular_file(folder / file, ignored) ? (folder / file).string() : std::string();
    };
    return {.kitchen = there(k_kitchen),
            .robots = there(k_robots),
            .stand_in = "builtin:kinetic",
            .buddha = there(k_buddha),
            .sponza = there(k_sponza),
            .folder = folder.string()};
}

std::vector<std::string> missing_scenes(const BenchScenes& scenes)
{
    struct Row {
        const std::string& found;
        const char* name;
        const char* file;
        std::string instead;
    };
    const Row rows[] = {
        {scenes.kitchen, "BART's Kitchen", k_kitchen, scenes.stand_in + " is measured instead where that is possible"},
        {scenes.robots, "BART's Robots", k_robots, "its tables and figures are left out"},
        {scenes.buddha, "The Happy Buddha", k_buddha,
         "Table 2 for it and Figure 1 of the light quad-tree are left out"},
        {scenes.sponza, "Sponza", k_sponza, "Figure 10 of the light quad-tree is left out"},
    };
    std::vector<std::string> sentences;
    for (const Row& row : rows)
        if (row.found.empty())
            sentences.push_back(fmt::format(
                "{} was not found ({}): {}.", row.name,
                (std::filesystem::path(scenes.folder) / row.file).lexically_normal().string(), row.instead));
    return sentences;
}

}   // namespace gnomon::bench
