// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/scene_access.h"
#include "base/machine.h"
#include "bench/core/moving_lights.h"
#include "bench/culling/json.h"
#include "bench/culling/readings.h"
#include "bench/culling/report.h"
#include "cli/subcommands.h"
#include "scene/view.h"

namespace gnomon::cli {

namespace {

constexpr int k_frames_by_default = 100;   // the help text of --frames states it, too

// One line for a frame; percentages are of all shadow rays.
std::string line_of(const bench::CullingFrame& f, const bench::CullingBenchOptions& options)
{
    const auto percent = [&](std::uint64_t n) {
        return 100.0 * static_cast<double>(n) / std::max<double>(1, static_cast<double>(f.off.rays));
    };
    std::string text = fmt::format("frame {:4}  off {} rays, {:.1f} ms", f.frame, f.off.rays, f.off.ms);
    if (options.paper)
        text += fmt::format("; paper {:.1f} % skipped, {:.1f} % dynamic only, {} wrong, {:.1f} ms",
                            percent(f.paper.skipped), percent(f.paper.dynamic_only), f.paper.wrong, f.paper.ms);
    if (options.certified)
        text += fmt::format("; certified {:.1f} % skipped, {:.2f} % dynamic only, {} wrong, {:.1f} ms",
                            percent(f.certified.skipped), percent(f.certified.dynamic_only), f.certified.wrong,
                            f.certified.ms);
    return text;
}

bench::CullingBenchOptions options_of(const options::OptionValues& values, const Scene& scene)
{
    bench::CullingBenchOptions options;
    // Frames of the clip, or times so many seconds apart, which may lie beyond its ends.
    for (const std::string& step : values.all("step"))
        options.step = std::max(options.step, *options::parse_number(step));
    for (const std::string& step : values.all("step"))
        bench::frames_between(options.step, *options::parse_number(step));
    if (values.given("start")) {
        if (options.step == 0) throw UsageError("--start needs --step");
        options.start = values.number("start");
    }
    const scene::Timeline& timeline = api::scene_of(scene)->timeline;
    const int steps = options.step > 0 ? bench::steps_in(timeline, options) : scene.frame_count();
    options.frames = {1, std::min(k_frames_by_default, steps)};
    if (values.given("frames")) options.frames = *options::parse_range(values.text("frames"));
    if ((options.step == 0 && options.frames.last > scene.frame_count()) || options.frames.count() < 1)
        throw UsageError(fmt::format("--frames {}-{}: the clip has frames 1 to {}", options.frames.first,
                                     options.frames.last, scene.frame_count()));
    options.size = *options::parse_size(values.text("size"));
    options.camera = scene::find_camera(*api::scene_of(scene), values.text("camera"));
    options.threads = values.integer("threads");
    options.max_depth = values.integer("max-depth");
    options.repeat = values.integer("repeat");
    options.counts = !values.flag("no-counts");
    if (values.flag("as-printed")) options.paper_options = shadow_culling::PaperOptions::as_printed();
    options.layout = bench::layout_named(values.text("tree"));
    for (const std::string& name : values.all("reading")) options.readings.push_back(bench::reading_named(name));
    for (const bench::PaperReading& reading : options.readings)
        if (reading.caches_occluders && !options.counts)
            throw UsageError(fmt::format("--reading {} is a matter of counts: not with --no-counts", reading.name));
    options.images = values.given("report");
    if (const std::vector<std::string> methods = values.all("method"); !methods.empty()) {
        options.paper = std::find(methods.begin(), methods.end(), "paper") != methods.end();
        options.certified = std::find(methods.begin(), methods.end(), "certified") != methods.end();
    }
    if (values.flag("as-printed") && !options.paper) throw UsageError("--as-printed needs --method paper");
    return options;
}

void say_summary(const bench::CullingWindow& window, Output& output)
{
    const bench::CullingBenchResult& result = window.result;
    const bench::CullingBenchOptions& options = window.options;
    const auto saved = [&](const char* method, const bench::CullingBenchResult::Saved& s) {
        output.say(fmt::format(
            "{:10} nodes saved {:.1f} % (best {:.1f} in frame {}; of the sums {:.1f}), tests saved {:.1f} % (best "
            "{:.1f} in frame {}; of the sums {:.1f})",
            method, s.nodes_mean, s.nodes_best, s.nodes_best_frame, s.nodes_of_totals, s.tests_mean, s.tests_best,
            s.tests_best_frame, s.tests_of_totals));
    };
    if (options.paper) {
        if (options.counts) saved("paper", result.paper_saved);
        output.say(fmt::format("{:10} {:.3f} extra tests per pixel, {:.1f} wrong results per frame; {:.1f} MB", "paper",
                               result.paper_extra_tests_per_pixel, result.paper_wrong_mean,
                               static_cast<double>(result.paper_bytes) / 1e6));
    }
    for (std::size_t r = 0; r < result.readings.size(); ++r) {
        const bench::CullingBenchResult::Reading& reading = result.readings[r];
        const std::string& name = options.readings[r].name;
        if (options.counts) saved(name.c_str(), reading.saved);
        output.say(fmt::format("{:10} {:.3f} extra tests per pixel, {:.1f} wrong results per frame; {:.1f} MB", name,
                               reading.extra_tests_per_pixel, reading.wrong_mean,
                               static_cast<double>(reading.bytes) / 1e6));
    }
    if (!options.certified) return;
    if (options.counts) saved("certified", result.certified_saved);
    output.say(
        fmt::format("{:10} speed-up {:.2f} x, over the second half {:.2f} x; first frame {:.2f} x the time, worst "
                    "later frame {}; {} wrong results",
                    "certified", result.speedup_mean, result.speedup_steady, result.first_frame_ratio,
                    result.frames.size() > 1 ? fmt::format("{:.2f} x", result.worst_frame_ratio) : std::string("-"),
                    result.wrong_total));
    output.say(fmt::format(
        "{:10} {:.2f} MB for {} visible triangles: {:.1f} bytes per triangle and light; evidence at most {:.2f} MB; "
        "mask of dynamic objects {:.2f} MB",
        "certified", static_cast<double>(result.bytes) / 1e6, result.visible_triangles, result.bytes_per_triangle_light,
        static_cast<double>(result.most_evidence_bytes) / 1e6, static_cast<double>(result.mask_bytes) / 1e6));
    if (window.moving_lights)
        output.say(fmt::format("{:10} {:.3f} x the time from the second frame on, while every light moves", "certified",
                               result.later_frames_ratio));
}

}   // namespace

int run_bench_culling(const CommandLine& line, Output& output)
{
    const options::OptionValues& values = line.values;
    const Scene scene = load_scene(line, output.progress());
    bench::CullingWindow window{
        line.positionals.at(0), line.command, values.flag("moving-lights"), 0, options_of(values, scene), {}, {}};
    // Create the report's folder before the work, so that one that cannot be written fails at once.
    std::optional<bench::ReportFile> report;
    if (values.given("report")) report.emplace(values.text("report"));

    // Measure; print each frame when it is done, or at the end if its times are medians of several runs.
    const auto inside = window.moving_lights ? bench::with_moving_lights(api::scene_of(scene)) : api::scene_of(scene);
    window.lights = inside->lights.size();
    const bool live = window.options.repeat == 1;
    window.result =
        bench::bench_culling(inside, window.options, output.progress(), [&](const bench::CullingFrame& frame) {
            if (live) output.say(line_of(frame, window.options));
        });
    for (const bench::CullingFrame& frame : window.result.frames)
        if (!live) output.say(line_of(frame, window.options));
    say_summary(window, output);
    // With several steps: the same frames after histories of every step.
    if (const std::vector<std::string> steps = values.all("step"); steps.size() > 1)
        for (const std::string& seconds : steps) {
            window.steps.push_back(
                bench::measure_step(inside, window, *options::parse_number(seconds), output.progress()));
            const bench::CullingBenchResult& at = window.steps.back().result;
            output.say(
                fmt::format("step {:g} s  nodes saved {:.1f} % (best {:.1f}), tests saved {:.1f} % (best {:.1f}); "
                            "{:.3f} extra tests per pixel, {:.1f} wrong results per frame",
                            window.steps.back().seconds, at.paper_saved.nodes_mean, at.paper_saved.nodes_best,
                            at.paper_saved.tests_mean, at.paper_saved.tests_best, at.paper_extra_tests_per_pixel,
                            at.paper_wrong_mean));
        }
    const nlohmann::ordered_json document = bench::culling_json(window);
    if (report) {
        const int threads = window.options.threads > 0 ? window.options.threads : gnomon::processor_threads();
        bench::ReportPage page("Gnomon: shadow culling", bench::machine_line(threads));
        bench::add_culling_section(page, window);
        report->write(page);
        output.say(fmt::format("report     {}", report->path().string()));
    }
    output.finish(document);
    return 0;
}

}   // namespace gnomon::cli
