// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "cli/subcommands.h"
#include "gnomon/arithmetic.h"
#include "gnomon/devices.h"

namespace gnomon::cli {

namespace {

using Json = nlohmann::ordered_json;

// Prints the Vulkan devices line by line and returns them as JSON.
Json describe_vulkan(const Devices& devices, Output& output)
{
    Json list = Json::array();
    if (!devices.vulkan_built) {
        output.say("Vulkan     this program was built without Vulkan");
        return {{"built", false}, {"devices", std::move(list)}};
    }
    if (!devices.vulkan_missing.empty()) {
        output.say(devices.vulkan_missing);
        return {{"built", true}, {"missing", devices.vulkan_missing}, {"devices", std::move(list)}};
    }
    for (const VulkanDevice& d : devices.vulkan) {
        output.say(fmt::format("Vulkan     {} ({}, Vulkan {}, {} MiB, {})", d.name, d.kind, d.version,
                               d.memory_bytes >> 20, d.driver));
        const char* const verdict = d.chosen ? "chosen" : d.suitable ? "suitable" : "not suitable";
        output.say(fmt::format("           {}: {}", verdict, fmt::join(d.reasons, ", ")));
        if (d.missing_for_rays.empty())
            output.say("           supports ray tracing");
        else
            output.say(
                fmt::format("           no ray tracing: the device lacks {}", fmt::join(d.missing_for_rays, ", ")));
        list.push_back({{"name", d.name},
                        {"kind", d.kind},
                        {"driver", d.driver},
                        {"vulkan", d.version},
                        {"memory_bytes", d.memory_bytes},
                        {"suitable", d.suitable},
                        {"chosen", d.chosen},
                        {"traces_rays", d.missing_for_rays.empty()},
                        {"reasons", d.reasons}});
    }
    if (list.empty()) output.say("Vulkan     no device; install a Vulkan driver");
    return {{"built", true}, {"devices", std::move(list)}};
}

}   // namespace

int run_devices(const CommandLine&, Output& output)
{
    const Devices devices = gnomon::devices();
    std::string present;
    nlohmann::ordered_json features = nlohmann::ordered_json::object();
    for (const auto& [name, there] : gnomon::processor_features()) {
        features[name] = there;
        if (there) present += (present.empty() ? "" : " ") + name;
    }
    output.say(fmt::format("processor  {}", gnomon::processor_name()));
    output.say(fmt::format("threads    {}", gnomon::processor_threads()));
    output.say(fmt::format("features   {}", present));
    output.say(fmt::format("in use     {}", gnomon::instruction_set_name()));
    output.say(fmt::format("packets    {} rays", devices.packet_width));
    Json vulkan = describe_vulkan(devices, output);

    output.finish({{"cpu",
                    {{"name", gnomon::processor_name()},
                     {"threads", gnomon::processor_threads()},
                     {"packet_width", devices.packet_width},
                     {"instruction_set", std::string(gnomon::instruction_set_name())},
                     {"features", std::move(features)}}},
                   {"vulkan", std::move(vulkan)}});
    return 0;
}

}   // namespace gnomon::cli
