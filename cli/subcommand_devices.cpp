// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "cli/subcommands.h"
#include "ray/ray_scene.h"
#ifdef GNOMON_VULKAN
#include "gnomon/error.h"
#include "vk/instance.h"
#endif

namespace gnomon::cli {

namespace {

using Json = nlohmann::ordered_json;

// Prints the Vulkan devices line by line and returns them as JSON. A machine without Vulkan is a result, not an error.
Json describe_vulkan(Output& output)
{
    Json list = Json::array();
#ifdef GNOMON_VULKAN
    try {
        const auto instance = vk::Instance::get();
        for (const vk::DeviceInfo& d : instance->devices()) {
            const std::string version =
                fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(d.api_version), VK_API_VERSION_MINOR(d.api_version),
                            VK_API_VERSION_PATCH(d.api_version));
            output.say(fmt::format("Vulkan     {} ({}, Vulkan {}, {} MiB, {})", d.name, d.kind, version, d.memory >> 20,
                                   d.driver));
            const char* const verdict = d.chosen ? "chosen" : d.suitable ? "suitable" : "not suitable";
            output.say(fmt::format("           {}: {}", verdict, fmt::join(d.reasons, ", ")));
            if (d.no_rays.empty())
                output.say("           supports ray tracing");
            else
                output.say(fmt::format("           no ray tracing: the device lacks {}", fmt::join(d.no_rays, ", ")));
            list.push_back({{"name", d.name},
                            {"kind", d.kind},
                            {"driver", d.driver},
                            {"vulkan", version},
                            {"memory_bytes", d.memory},
                            {"suitable", d.suitable},
                            {"chosen", d.chosen},
                            {"traces_rays", d.no_rays.empty()},
                            {"reasons", d.reasons}});
        }
        if (list.empty()) output.say("Vulkan     no device; install a Vulkan driver");
        return {{"built", true}, {"devices", std::move(list)}};
    } catch (const MissingError& error) {
        output.say(error.what());
        return {{"built", true}, {"missing", error.what()}, {"devices", std::move(list)}};
    }
#else
    output.say("Vulkan     this program was built without Vulkan");
    return {{"built", false}, {"devices", std::move(list)}};
#endif
}

}   // namespace

int run_devices(const CommandLine&, Output& output)
{
    std::string present;
    nlohmann::ordered_json features = nlohmann::ordered_json::object();
    for (const auto& [name, there] : gnomon::processor_features()) {
        features[name] = there;
        if (there) present += (present.empty() ? "" : " ") + name;
    }
    output.say(fmt::format("processor  {}", gnomon::processor_name()));
    output.say(fmt::format("threads    {}", gnomon::processor_threads()));
    output.say(fmt::format("features   {}", present));
    output.say(fmt::format("packets    {} rays", ray::RayScene::packet_width()));
    Json vulkan = describe_vulkan(output);

    output.finish({{"cpu",
                    {{"name", gnomon::processor_name()},
                     {"threads", gnomon::processor_threads()},
                     {"packet_width", ray::RayScene::packet_width()},
                     {"features", std::move(features)}}},
                   {"vulkan", std::move(vulkan)}});
    return 0;
}

}   // namespace gnomon::cli
