// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/machine.h"
#include "bench/shadow_textures/report.h"
#include "cli/program.h"
#include "cli/subcommands.h"
#include "options/enum_names.h"

namespace gnomon::cli {

namespace {

bench::ShadowTexturesBenchOptions options_of(const options::OptionValues& values)
{
    bench::ShadowTexturesBenchOptions options;
    if (values.given("objects")) {
        options.objects.clear();
        for (const std::string& word : values.all("objects"))
            options.objects.push_back(static_cast<int>(*options::parse_integer(word)));
    }
    if (values.given("dynamic")) {
        if (values.given("movers")) throw UsageError("--movers and --dynamic exclude each other");
        options.dynamic.clear();
        for (const std::string& word : values.all("dynamic")) options.dynamic.push_back(*options::parse_number(word));
    }
    if (values.given("movers")) {
        options.dynamic_objects = values.integer("movers");
        const int fewest = *std::min_element(options.objects.begin(), options.objects.end());
        if (*options.dynamic_objects > fewest)
            throw UsageError(
                fmt::format("--movers {}: the scene has only {} objects", *options.dynamic_objects, fewest));
    }
    options.size = *options::parse_size(values.text("size"));
    options.vertices = values.integer("vertices");
    options.frames = values.integer("frames");
    options.as_printed = values.flag("as-printed");
    options.by_footprints = values.flag("by-footprints");
    options.images = values.given("report");
    if (const std::vector<std::string> words = values.all("method"); !words.empty()) {
        options.methods.clear();
        for (const ShadowTextures method :
             {ShadowTextures::per_caster, ShadowTextures::depth, ShadowTextures::coherent, ShadowTextures::items})
            if (std::find(words.begin(), words.end(), options::name_of(method)) != words.end())
                options.methods.push_back(method);
    }
    return options;
}

}   // namespace

int run_bench_shadow_textures(const CommandLine& line, Output& output)
{
    const bench::ShadowTexturesBenchOptions options = options_of(line.values);
    std::optional<bench::ReportFile> report;
    if (line.values.given("report")) report.emplace(line.values.text("report"));

    const bench::ShadowTexturesBenchResult result = bench::bench_shadow_textures(options, output.progress());
    output.say(fmt::format("device     {}; times in ms, {}", result.device, result.clock));
    output.say(
        "objects dynamic        method    shadows  (buffers + textures)    planning  whole frame   draws  copies  "
        "textures  touched  identical");
    for (const bench::ShadowTexturesRow& row : result.rows)
        output.say(
            fmt::format("{:7} {:7} {:>13} {:10.2f}  ({:7.2f} + {:8.2f}) {:11.3f} {:12.2f} {:7.1f} {:7.1f} {:9.1f} "
                        "{:8.1f}  {}",
                        row.objects, row.dynamic_objects, bench::name_of(row), row.shadow_ms, row.buffers_ms,
                        row.textures_ms, row.shadow_cpu_ms, row.frame_ms, row.draws, row.copies, row.textures_updated,
                        row.touched, row.identical_to_full ? "yes" : "NO"));
    for (const auto& [method, exponent] : result.exponents)
        output.say(fmt::format("{:10} time grows with the number of objects to the power of {:.2f}",
                               options::name_of(method), exponent));

    const nlohmann::ordered_json document = bench::shadow_textures_json(options, result);
    if (report) {
        bench::ReportPage page("Gnomon: shadow textures",
                               fmt::format("{}; {}", result.device, bench::machine_line(gnomon::processor_threads())));
        bench::add_shadow_textures_section(page, line.command, options, result, document);
        report->write(page);
        output.say(fmt::format("report     {}", report->path().string()));
    }
    output.finish(document);
    const bool identical = std::all_of(result.rows.begin(), result.rows.end(),
                                       [](const bench::ShadowTexturesRow& row) { return row.identical_to_full; });
    return identical ? k_exit_done : k_exit_different;
}

}   // namespace gnomon::cli
