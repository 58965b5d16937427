// SPDX-License-Identifier: Apache-2.0
// gnomon view: opens the viewer and reports its summary.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/signals.h"
#include "cli/subcommands.h"
#include "gnomon/error.h"
#include "gnomon/version.h"
#ifdef GNOMON_VIEWER
#include "viewer/viewer.h"
#endif

namespace gnomon::cli {

int run_view(const CommandLine& line, Output& output)
{
#ifdef GNOMON_VIEWER
    viewer::ViewSettings settings(line.values);
    settings.render_options();   // throws on options that exclude each other, before a window opens
    viewer::Viewer viewer(std::move(settings), line.positionals.at(0), line.values.integer("threads"));
    const viewer::ViewSummary summary = viewer.run(interrupted);
    for (const std::string& file : summary.files) output.say(file);
    output.detail(fmt::format("{} images, median {:.1f} ms; longest window frame {:.1f} ms", summary.images,
                              summary.median_image_ms, summary.longest_ms));
    output.detail(fmt::format("{} inputs, each shown after {:.0f} ms in the median and {:.0f} ms at most",
                              summary.latency.inputs, summary.latency.median_ms, summary.latency.longest_ms));
    output.detail(fmt::format("images rendered for them were shown after {:.0f} ms in the median and {:.0f} ms at most",
                              summary.rendered.median_ms, summary.rendered.longest_ms));
    output.finish({{"version", std::string(version())},
                   {"scene", line.positionals[0]},
                   {"window_frames", summary.window_frames},
                   {"longest_frame_ms", summary.longest_ms},
                   {"pictures", summary.images},
                   {"median_picture_ms", summary.median_image_ms},
                   {"inputs", summary.latency.inputs},
                   {"median_latency_ms", summary.latency.median_ms},
                   {"longest_latency_ms", summary.latency.longest_ms},
                   {"median_rendered_latency_ms", summary.rendered.median_ms},
                   {"longest_rendered_latency_ms", summary.rendered.longest_ms},
                   {"loads", summary.loads},
                   {"files", summary.files},
                   {"options_set", summary.options_set},
                   {"frozen", summary.frozen},
                   {"moved", summary.moved},
                   {"peak_memory_bytes", peak_memory_bytes()}});
    return 0;
#else
    (void)line, (void)output;
    throw MissingError(
        "this program was built without the viewer; install GLFW, Dear ImGui and OpenGL and build it again");
#endif
}

}   // namespace gnomon::cli
