// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/machine.h"
#include "app/verbs.h"
#include "ray/ray_scene.h"

namespace gnomon::app {

int run_devices(const CommandLine&, Output& output)
{
    std::string present;
    nlohmann::ordered_json features = nlohmann::ordered_json::object();
    for (const auto& [name, there] : processor_features()) {
        features[name] = there;
        if (there) present += (present.empty() ? "" : " ") + name;
    }
    output.say(fmt::format("processor  {}", processor_name()));
    output.say(fmt::format("threads    {}", processor_threads()));
    output.say(fmt::format("features   {}", present));
    output.say(fmt::format("packets    {} rays", ray::RayScene::packet_width()));
    output.say("Vulkan     not built");

    output.finish({{"cpu",
                    {{"name", processor_name()},
                     {"threads", processor_threads()},
                     {"packet_width", ray::RayScene::packet_width()},
                     {"features", std::move(features)}}},
                   {"vulkan", {{"built", false}, {"devices", nlohmann::ordered_json::array()}}}});
    return 0;
}

}   // namespace gnomon::app
