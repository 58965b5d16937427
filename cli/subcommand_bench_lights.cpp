// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/scene_access.h"
#include "bench/lights/bench.h"
#include "cli/subcommands.h"
#include "scene/view.h"

namespace gnomon::cli {

int run_bench_lights(const CommandLine& line, Output& output)
{
    const options::OptionValues& values = line.values;
    const Scene scene = load_scene(line, output.progress());
    bench::LightsBenchOptions options;
    if (values.given("frames")) options.frames = *options::parse_range(values.text("frames"));
    if (options.frames.last > scene.frame_count() || options.frames.count() < 1)
        throw UsageError(fmt::format("--frames {}-{}: the clip has frames 1 to {}", options.frames.first,
                                     options.frames.last, scene.frame_count()));
    options.size = *options::parse_size(values.text("size"));
    options.camera = scene::find_camera(*api::scene_of(scene), values.text("camera"));
    options.side = static_cast<float>(values.number("side"));
    options.check = values.integer("check");
    if (const std::vector<std::string> samples = values.all("samples"); !samples.empty()) {
        options.samples.clear();
        for (const std::string& n : samples) options.samples.push_back(static_cast<int>(*options::parse_number(n)));
    }
    const bench::LightsBenchResult result = bench::bench_lights(api::scene_of(scene), options, output.progress());

    nlohmann::ordered_json rows = nlohmann::ordered_json::array(), opponents = rows;
    const auto percent = [](double share) { return 100 * share; };
    for (const bench::LightsBenchResult::Row& r : result.rows) {
        output.say(
            fmt::format("{}: {} points, lit {:.1f} %, dark {:.1f} %, penumbra {:.1f} %, unproven {:.2f} %; {} of {} "
                        "segments contradict; {:.1f} ms at first, then {:.1f} ms; error {:.5f}, at most {:.4f}",
                        r.light, r.points, percent(r.lit), percent(r.dark), percent(r.penumbra), percent(r.unproven),
                        r.wrong, r.segments, r.ms_cold, r.ms_steady, r.error.rmse, r.error.max_abs));
        rows.push_back({{"light", r.light},
                        {"points", r.points},
                        {"lit", r.lit},
                        {"dark", r.dark},
                        {"penumbra", r.penumbra},
                        {"unproven", r.unproven},
                        {"segments", r.segments},
                        {"wrong", r.wrong},
                        {"ms_cold", r.ms_cold},
                        {"ms_steady", r.ms_steady},
                        {"rmse", r.error.rmse},
                        {"max_abs", r.error.max_abs},
                        {"listed_triangles", r.triangles}});
    }
    for (const bench::LightsBenchResult::Opponent& o : result.opponents) {
        output.say(fmt::format("{} rays a point: {:.1f} ms; error {:.5f}, at most {:.4f}", o.samples, o.ms,
                               o.error.rmse, o.error.max_abs));
        opponents.push_back(
            {{"samples", o.samples}, {"ms", o.ms}, {"rmse", o.error.rmse}, {"max_abs", o.error.max_abs}});
    }
    output.say(fmt::format("error of the truth itself {:.5f}; {:.1f} MB", result.truth_rmse,
                           static_cast<double>(result.bytes) / 1e6));
    output.finish(
        {{"rows", rows}, {"opponents", opponents}, {"truth_rmse", result.truth_rmse}, {"bytes", result.bytes}});
    return 0;
}

}   // namespace gnomon::cli
