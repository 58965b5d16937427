// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "api/scene_access.h"
#include "base/machine.h"
#include "bench/core/moving_lights.h"
#include "bench/indirect/report.h"
#include "bench/indirect/vulkan.h"
#include "cli/subcommands.h"

namespace gnomon::cli {

namespace {

constexpr int k_frames_by_default = 10;   // the help text of --frames states it, too

// The report's image of the reference has --spp / k_image_paths_divisor paths per pixel, but at least
// k_least_image_paths.
constexpr int k_image_paths_divisor = 8, k_least_image_paths = 64;

void say_row(const bench::IndirectRow& r, Output& output)
{
    const auto percent = [](const std::optional<double>& value) {
        return value ? fmt::format("{:.2f} %", 100 * *value) : std::string("-");
    };
    const auto number = [](const std::optional<double>& value) {
        return value ? fmt::format("{:.4f}", *value) : std::string("-");
    };
    output.say(fmt::format("{:14} nRMSE {} ({} against all texels), energy {}", r.method, number(r.nrmse),
                           number(r.nrmse_brute), number(r.energy_ratio)));
    if (const bench::LocalMeans& means = r.local_means; means.blocks > 0)
        output.say(
            fmt::format("{:14} means of blocks of {} pixels: {} of {} differ by more than {:.0f} % ({} beyond "
                        "the reference's noise); from {:.3f} to {:.3f} times the reference",
                        "", bench::LocalMeans::k_block, means.off, means.blocks, 100 * bench::LocalMeans::k_bound,
                        means.surely_off, means.least, means.greatest));
    output.say(fmt::format(
        "{:14} {:.1f} ms moving (median {:.1f}, worst {:.1f}, {:.2f} of it repair), {:.1f} ms static, "
        "{:.1f} ms first frame, {:.1f} ms to rebuild",
        "", r.ms_moving, r.ms_moving_median, r.ms_moving_worst, r.ms_repair, r.ms_static, r.ms_cold, r.ms_rebuild));
    output.say(fmt::format("{:14} CPU time {:.1f} ms moving, {:.1f} ms static, {:.1f} ms first frame", "",
                           r.cpu_ms_moving, r.cpu_ms_static, r.cpu_ms_cold));
    output.say(fmt::format(
        "{:14} flicker {} (noise floor {}); change while only the view moves: {} on average, {} at most", "",
        percent(r.flicker), percent(r.flicker_floor), r.view_change ? percent(r.view_change->mean) : "-",
        r.view_change ? percent(r.view_change->largest) : "-"));
    output.say(fmt::format(
        "{:14} {} clusters, {} rays per frame ({} in the first), {} dirty pixels and {} dirty nodes, {:.1f} MB", "",
        r.work.clusters, r.work.rays, r.rays_cold, r.work.dirty_pixels, r.work.dirty_nodes,
        static_cast<double>(r.work.bytes) / 1e6));
}

bench::IndirectBenchOptions options_of(const options::OptionValues& values, const Scene& scene)
{
    bench::IndirectBenchOptions options;
    options.frames = {1, std::min(k_frames_by_default, scene.frame_count())};
    if (values.given("frames")) options.frames = *options::parse_range(values.text("frames"));
    if (options.frames.last > scene.frame_count() || options.frames.count() < 1)
        throw UsageError(fmt::format("--frames {}-{}: the clip has frames 1 to {}", options.frames.first,
                                     options.frames.last, scene.frame_count()));
    options.size = *options::parse_size(values.text("size"));
    options.threads = values.integer("threads");
    options.camera = scene::find_camera(*api::scene_of(scene), values.text("camera"));
    options.spp = values.integer("spp");
    options.bounces = values.integer("bounces");
    options.judged = values.integer("judged");
    options.grid = std::stoi(values.text("judged-every"));
    options.reference_cache = values.text("keep-references");
    options.images = values.given("report");
    options.image_spp = std::max(k_least_image_paths, options.spp / k_image_paths_divisor);
    std::vector<std::string> methods = values.all("method");
    if (methods.empty() && !options.images) methods = {"visible"};
    const bench::IndirectSettings settings{values.number("depth-threshold"), values.number("normal-threshold"),
                                           values.text("receivers") == "full", values.text("renderer") == "raster",
                                           static_cast<std::size_t>(values.integer("indirect-memory")) << 20};
    // Methods of papers have one bounce.
    bench::IndirectSettings cached = settings;
    cached.bounces = options.bounces;
    if (options.images) options.methods = bench::indirect_methods_of_paper(settings);
    for (const std::string& name : methods) {
        const auto same = [&](const bench::IndirectMethodInfo& m) { return m.name == name; };
        if (std::none_of(options.methods.begin(), options.methods.end(), same))
            options.methods.push_back(bench::find_indirect_method(name, cached));
    }
    return options;
}

}   // namespace

int run_bench_indirect(const CommandLine& line, Output& output)
{
    const options::OptionValues& values = line.values;
    // Load the scene and read the options.
    const bool raster = values.text("renderer") == "raster";
    const std::string device = raster ? bench::vulkan_device_name() : std::string();
    const Scene scene = load_scene(line, output.progress());
    std::optional<bench::ReportFile> report;
    if (values.given("report")) report.emplace(values.text("report"));
    bench::IndirectStudy study;
    study.scene = line.positionals[0];
    study.printed = bench::paper_scene_of(study.scene);
    study.command = line.command;
    study.device = device;
    study.options = options_of(values, scene);
    const bench::IndirectBenchOptions& options = study.options;
    const auto inside =
        values.flag("moving-lights") ? bench::with_moving_lights(api::scene_of(scene)) : api::scene_of(scene);
    // Measure all methods.
    const bench::IndirectBenchResult& result = study.result = bench::bench_indirect(
        inside, options, output.progress(), [&](const bench::IndirectRow& row) { say_row(row, output); });
    output.say(
        fmt::format("{:14} {} paths per point, {} points in frames {} to {}; noise {:.4f} of the mean; {} computed, "
                    "{} loaded",
                    "reference", options.spp, result.points, result.judged.front(), result.judged.back(),
                    result.reference_noise, result.references_computed, result.references_found));

    // Measure the gather alone at every pixel of a large image.
    if (raster && study.options.methods.front().settings.full) {
        const scene::SceneState state(inside, inside->timeline.time_of(options.frames.first));
        const ray::RayScene rays(state);
        Tasks tasks(options.threads);
        const scene::View view = scene::make_view(state, options.camera, bench::k_large_gather_size);
        study.large = bench::measure_large_gather(state, rays, view, tasks);
        output.say(fmt::format("{:14} {:.2f} ms for every pixel of {}x{} and {} clusters", "gather", study.large->ms,
                               study.large->size.width, study.large->size.height, study.large->clusters));
    }
    if (raster)
        output.say(fmt::format("{:14} {}; times are the device's, except for cached visibility", "device", device));

    if (report) {
        study.direct = bench::direct_light(api::public_scene(inside), study);
        bench::ReportPage page(
            "Gnomon: indirect light",
            bench::machine_line(study.options.threads > 0 ? study.options.threads : gnomon::processor_threads()) +
                (raster ? "; Vulkan on " + device : ""));
        bench::add_indirect_section(page, study);
        report->write(page);
        output.say(fmt::format("report     {}", report->path().string()));
    }
    output.finish(bench::indirect_json(study));
    return 0;
}

}   // namespace gnomon::cli
