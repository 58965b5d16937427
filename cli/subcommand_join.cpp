// SPDX-License-Identifier: Apache-2.0
// gnomon join, on the public API alone.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/one_line.h"
#include "cli/subcommands.h"
#include "gnomon/gnomon.h"

namespace gnomon::cli {

int run_join(const CommandLine& line, Output& output)
{
    const std::string& out = line.positionals[0];
    const VideoResult result = join_video(out, output.progress());
    if (result.complete_before)
        output.say(fmt::format("{} is complete; nothing to do", one_line(out)));
    else
        output.say(fmt::format("{} ({} frames, {}x{})", one_line(out), result.frames.size(), result.size.width,
                               result.size.height));
    output.finish({{"version", std::string(version())},
                   {"file", out},
                   {"complete_before", result.complete_before},
                   {"frames", result.frames.size()}});
    return 0;
}

}   // namespace gnomon::cli
