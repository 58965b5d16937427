// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "api/scene_access.h"
#include "bench/lights/report.h"
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
    options.truth = values.integer("truth");
    if (const std::vector<std::string> samples = values.all("samples"); !samples.empty()) {
        options.samples.clear();
        for (const std::string& n : samples) options.samples.push_back(static_cast<int>(*options::parse_number(n)));
    }
    std::optional<bench::ReportFile> report;
    if (values.given("report")) report.emplace(values.text("report"));
    const bench::LightsBenchResult result = bench::bench_lights(api::scene_of(scene), options, output.progress());

    const auto percent = [](double share) { return 100 * share; };
    for (const bench::LightsBenchResult::Row& r : result.rows)
        output.say(fmt::format(
            "{}: {} points, lit {:.1f} %, dark {:.1f} %, penumbra {:.1f} %, unproven {:.2f} %; {} of {} "
            "segments contradict; {:.1f} ms at first, then {:.1f} ms; error {:.5f}, at most {:.4f}{}",
            r.light, r.points, percent(r.lit), percent(r.dark), percent(r.penumbra), percent(r.unproven), r.wrong,
            r.segments, r.ms_cold, r.ms_steady, r.error.rmse, r.error.max_abs,
            r.soft_rmse.empty() ? "" : fmt::format("; soft textures {:.3f}", fmt::join(r.soft_rmse, " and "))));
    for (const bench::LightsBenchResult::Opponent& o : result.opponents)
        output.say(fmt::format("{} rays a point: {:.1f} ms; error {:.5f}, at most {:.4f}", o.samples, o.ms,
                               o.error.rmse, o.error.max_abs));
    for (const bench::LightsBenchResult::Soft& s : result.soft)
        output.say(fmt::format(
            "soft textures, {}: error {:.4f}, at most {:.3f}; {} of {} dark points see a tenth of "
            "the light or more; {} textures, {:.1f} made again in a later frame; {:.0f} ms at "
            "first, then {:.0f} ms",
            s.name, s.error.rmse, s.error.max_abs, s.leaks, s.darkest, s.textures, s.updated, s.ms_first, s.ms_then));
    output.say(fmt::format("error of the truth itself {:.5f}; {:.1f} MB", result.truth_rmse,
                           static_cast<double>(result.bytes) / 1e6));
    if (!report) {
        output.finish(bench::lights_json(result, nullptr));
        return 0;
    }
    const bench::LightsImages images = bench::lights_images(api::scene_of(scene), options, output.progress());
    for (const bench::RasterLightsRow& r : images.raster.rows)
        output.say(
            fmt::format("rasterised, {}: error {:.4f}, at most {:.3f}; {} of {} dark pixels see a tenth of the "
                        "light or more; {:.0f} ms at first, {:.0f} ms for another view, {:.0f} ms if nothing "
                        "changed",
                        r.method, r.rmse, r.max_abs, r.leaks, r.darkest, r.ms_first, r.ms_view, r.ms_still));
    const nlohmann::ordered_json document = bench::lights_json(result, &images);
    bench::ReportPage page("Gnomon: lights with size", bench::machine_line(1));
    bench::add_lights_section(page, line.command, options, result, images, document);
    report->write(page);
    output.say(fmt::format("report     {}", report->path().string()));
    output.finish(document);
    return 0;
}

}   // namespace gnomon::cli
