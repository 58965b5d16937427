// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "app/indirect_bench.h"
#include "app/machine.h"
#include "app/moving_lights.h"
#include "app/verbs.h"

namespace gnomon::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr int k_frames_by_default = 10;

template <class T>
Json maybe(const std::optional<T>& value)
{
    return value ? Json(*value) : Json(nullptr);
}

Json to_json(const IndirectRow& r)
{
    Json json{{"method", r.method},
              {"clusters", r.work.clusters},
              {"ms_cold", r.ms_cold},
              {"ms_static", r.ms_static},
              {"ms_moving", r.ms_moving},
              {"ms_repair", r.ms_repair},
              {"ms_rebuild", r.ms_rebuild},
              {"ms_moving_median", r.ms_moving_median},
              {"ms_moving_worst", r.ms_moving_worst},
              {"cpu_ms_cold", r.cpu_ms_cold},
              {"cpu_ms_static", r.cpu_ms_static},
              {"cpu_ms_moving", r.cpu_ms_moving},
              {"cpu_ms_repair", r.cpu_ms_repair},
              {"cpu_ms_rebuild", r.cpu_ms_rebuild},
              {"dirty_pixels", r.work.dirty_pixels},
              {"dirty_nodes", r.work.dirty_nodes},
              {"nrmse", maybe(r.nrmse)},
              {"nrmse_by_frame", r.nrmse_by_frame},
              {"nrmse_brute", nullptr},
              {"energy_ratio", maybe(r.energy_ratio)},
              {"flicker", maybe(r.flicker)},
              {"flicker_floor", maybe(r.flicker_floor)},
              {"view_change_mean", r.view_change ? Json(r.view_change->mean) : Json(nullptr)},
              {"view_change_largest", r.view_change ? Json(r.view_change->largest) : Json(nullptr)},
              {"rays", r.work.rays},
              {"rays_cold", r.rays_cold},
              {"bytes", r.work.bytes}};
    return json;
}

void say_row(const IndirectRow& r, Output& output)
{
    const auto percent = [](const std::optional<double>& value) {
        return value ? fmt::format("{:.2f} %", 100 * *value) : std::string("-");
    };
    output.say(fmt::format("{:14} nRMSE {}, energy {}", r.method, r.nrmse ? fmt::format("{:.4f}", *r.nrmse) : "-",
                           r.energy_ratio ? fmt::format("{:.4f}", *r.energy_ratio) : "-"));
    output.say(fmt::format(
        "{:14} {:.1f} ms moving (median {:.1f}, worst {:.1f}; repair {:.2f} of it), {:.1f} static, "
        "{:.1f} cold, {:.1f} to prepare anew",
        "", r.ms_moving, r.ms_moving_median, r.ms_moving_worst, r.ms_repair, r.ms_static, r.ms_cold, r.ms_rebuild));
    output.say(fmt::format("{:14} {:.1f} ms of CPU moving, {:.1f} static, {:.1f} cold", "", r.cpu_ms_moving,
                           r.cpu_ms_static, r.cpu_ms_cold));
    output.say(fmt::format("{:14} flicker {} (floor {}); while the view alone moves {} on average, {} at most", "",
                           percent(r.flicker), percent(r.flicker_floor),
                           r.view_change ? percent(r.view_change->mean) : "-",
                           r.view_change ? percent(r.view_change->largest) : "-"));
    output.say(fmt::format("{:14} {} clusters, {} rays a frame ({} cold), {} pixels and {} nodes dirty, {:.1f} MB", "",
                           r.work.clusters, r.work.rays, r.rays_cold, r.work.dirty_pixels, r.work.dirty_nodes,
                           static_cast<double>(r.work.bytes) / 1e6));
}

int camera_of(const scene::Scene& scene, const std::string& wanted)
{
    if (wanted == "auto") return 0;
    const auto count = static_cast<int>(scene.cameras.size());
    for (int c = 0; c < count; ++c)
        if (scene.cameras[static_cast<std::size_t>(c)].name == wanted) return c;
    int number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error == std::errc() && end == wanted.data() + wanted.size() && number >= 0 && number < count) return number;
    throw UsageError(fmt::format("no camera '{}': the scene has {}, numbered from 0", wanted, count));
}

IndirectBenchOptions options_of(const OptionValues& values, const Scene& scene)
{
    IndirectBenchOptions options;
    options.frames = {1, std::min(k_frames_by_default, scene.frame_count())};
    if (values.given("frames")) options.frames = *parse_range(values.text("frames"));
    if (options.frames.last > scene.frame_count() || options.frames.count() < 1)
        throw UsageError(fmt::format("no frames {} to {}: the clip has frames 1 to {}", options.frames.first,
                                     options.frames.last, scene.frame_count()));
    if (values.given("size")) options.size = *parse_size(values.text("size"));
    options.threads = values.integer("threads");
    options.camera = camera_of(*scene.inside(), values.text("camera"));
    options.spp = values.integer("spp");
    options.judged = values.integer("judged");
    options.reference_cache = values.text("keep-references");
    std::vector<std::string> methods = values.all("method");
    if (methods.empty()) methods = {"visible"};
    for (const std::string& name : methods) options.methods.push_back(find_indirect_method(name));
    return options;
}

}   // namespace

int run_bench_indirect(const CommandLine& line, Output& output)
{
    if (line.values.text("renderer") == "raster")
        throw UsageError("bench indirect measures the traced frame: --renderer trace");
    const OptionValues& values = line.values;
    const Scene scene = load_scene(line, output.progress());
    const IndirectBenchOptions options = options_of(values, scene);
    const auto inside = values.flag("moving-lights") ? with_moving_lights(scene.inside()) : scene.inside();
    const IndirectBenchResult result =
        bench_indirect(inside, options, output.progress(), [&](const IndirectRow& row) { say_row(row, output); });
    output.say(
        fmt::format("{:14} {} paths a point, {} points of frames {} to {}; noise {:.4f} of the mean; {} computed, "
                    "{} found",
                    "reference", options.spp, result.points, result.judged.front(), result.judged.back(),
                    result.reference_noise, result.references_computed, result.references_found));

    Json rows = Json::array();
    for (const IndirectRow& row : result.rows) rows.push_back(to_json(row));
    output.finish({{"device", processor_name()},
                   {"threads", options.threads > 0 ? options.threads : processor_threads()},
                   {"width", options.size.width},
                   {"height", options.size.height},
                   {"frames", {options.frames.first, options.frames.last}},
                   {"judged_frames", result.judged},
                   {"spp", options.spp},
                   {"points", result.points},
                   {"mean_irradiance", result.mean_irradiance},
                   {"reference_noise", result.reference_noise},
                   {"rows", std::move(rows)}});
    return 0;
}

}   // namespace gnomon::app
