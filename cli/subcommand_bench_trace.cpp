// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "api/scene_access.h"
#include "bench/core/trace_bench.h"
#include "cli/subcommands.h"
#include "scene/view.h"

namespace gnomon::cli {

int run_bench_trace(const CommandLine& line, Output& output)
{
    const options::OptionValues& values = line.values;
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = load_scene(line, output.progress());
    const std::chrono::duration<double, std::milli> load = std::chrono::steady_clock::now() - start;

    bench::TraceBenchOptions options;
    if (values.given("frame")) options.frame = values.integer("frame");
    if (options.frame > scene.frame_count())
        throw UsageError(fmt::format("--frame {}: the clip has frames 1 to {}", options.frame, scene.frame_count()));
    options.size = *options::parse_size(values.text("size"));
    options.camera = scene::find_camera(*api::scene_of(scene), values.text("camera"));
    options.threads = values.integer("threads");
    options.max_depth = values.integer("max-depth");
    options.arithmetic = values.choice<Arithmetic>("isa");
    const bench::TraceBenchResult result = bench::bench_trace(api::scene_of(scene), options);

    const double load_ms = load.count() + result.build_ms;   // from opening the file to the first ray
    output.say(fmt::format("frame   {:.2f} ms ({:.2f} ms on one thread)", result.frame_ms, result.one_thread_ms));
    output.say(fmt::format("bare    {:.2f} ms for {} rays on one thread", result.bare_ms, result.rays));
    output.say(fmt::format("ratio   {:.3f}", result.ratio));
    output.say(fmt::format("load    {:.1f} ms, {:.1f} ms of it for building BVHs", load_ms, result.build_ms));
    output.say(fmt::format("update  {:.3f} ms", result.update_ms));
    output.say(fmt::format("memory  {:.1f} MB for BVHs and vertices", static_cast<double>(result.bytes) / 1e6));
    output.finish({{"frame_ms", result.frame_ms},
                   {"bare_ms", result.bare_ms},
                   {"ratio", result.ratio},
                   {"load_ms", load_ms},
                   {"update_ms", result.update_ms},
                   {"rays", result.rays},
                   {"bytes", result.bytes}});
    return 0;
}

}   // namespace gnomon::cli
