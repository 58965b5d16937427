// SPDX-License-Identifier: Apache-2.0
// gnomon info, on the public API alone.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/subcommands.h"
#include "gnomon/gnomon.h"

namespace gnomon::cli {

namespace {
// The number of names and the first few of them.
std::string names_of(const std::vector<std::string>& names)
{
    constexpr std::size_t shown = 8;
    std::string text = fmt::format("{}", names.size());
    for (std::size_t i = 0; i < std::min(names.size(), shown); ++i)
        if (!names[i].empty()) text += fmt::format("{}{}", i == 0 ? "  " : ", ", names[i]);
    return names.size() > shown ? text + ", ..." : text;
}

std::string animation_line(const AnimationInfo& a, std::size_t number)
{
    return fmt::format("{:<10} {}  {}{} frames, {:g} to {:g} s{}", number == 0 ? "animations" : "", number,
                       a.name.empty() ? "" : a.name + ", ", a.frames, a.start, a.end, a.plays ? ", plays" : "");
}

nlohmann::json document_of(const std::vector<AnimationInfo>& animations)
{
    nlohmann::json list = nlohmann::json::array();
    for (const AnimationInfo& a : animations)
        list.push_back(
            {{"name", a.name}, {"start", a.start}, {"end", a.end}, {"frames", a.frames}, {"plays", a.plays}});
    return list;
}
}   // namespace

int run_info(const CommandLine& line, Output& output)
{
    const Scene scene = load_scene(line, output.progress());
    const SceneInfo info = scene.info();

    output.say(fmt::format("scene      {}", info.name));
    output.say(fmt::format("triangles  {} ({} dynamic)", info.triangles, info.triangles_dynamic));
    output.say(fmt::format("objects    {} ({} dynamic)", info.objects, info.objects_dynamic));
    output.say(fmt::format("meshes     {}, {} materials, {} textures", info.meshes, info.materials, info.textures));
    output.say(fmt::format("lights     {}", names_of(info.lights)));
    output.say(fmt::format("cameras    {}", names_of(info.cameras)));
    output.say(fmt::format("clip       {} frames, {:g} to {:g} s, {:g} frames per second", info.frames, info.start,
                           info.end, info.fps));
    for (std::size_t i = 0; i < info.animations.size(); ++i) output.say(animation_line(info.animations[i], i));
    if (!info.variants.empty()) output.say(fmt::format("variants   {}", names_of(info.variants)));
    output.say(fmt::format("bounds     {:g} {:g} {:g} to {:g} {:g} {:g}", info.bounds_low[0], info.bounds_low[1],
                           info.bounds_low[2], info.bounds_high[0], info.bounds_high[1], info.bounds_high[2]));
    output.say(fmt::format("memory     {:.1f} MB at peak", static_cast<double>(peak_memory_bytes()) / 1e6));
    for (const std::string& warning : info.warnings) output.warn(warning);

    output.finish({{"scene", line.positionals[0]},
                   {"name", info.name},
                   {"triangles", info.triangles},
                   {"triangles_dynamic", info.triangles_dynamic},
                   {"objects", info.objects},
                   {"objects_dynamic", info.objects_dynamic},
                   {"meshes", info.meshes},
                   {"materials", info.materials},
                   {"textures", info.textures},
                   {"lights", info.lights.size()},
                   {"light_names", info.lights},
                   {"cameras", info.cameras.size()},
                   {"camera_names", info.cameras},
                   {"frames", info.frames},
                   {"fps", info.fps},
                   {"start", info.start},
                   {"end", info.end},
                   {"animations", document_of(info.animations)},
                   {"variants", info.variants},
                   {"bounds", {{"low", info.bounds_low}, {"high", info.bounds_high}}},
                   {"peak_memory_bytes", peak_memory_bytes()},
                   {"warnings", info.warnings}});
    return 0;
}

}   // namespace gnomon::cli
