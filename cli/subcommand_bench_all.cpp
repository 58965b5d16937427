// SPDX-License-Identifier: Apache-2.0
// gnomon bench all: every chapter, one page.
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "bench/report/chapter.h"
#include "cli/progress_line.h"
#include "cli/subcommands.h"

namespace gnomon::cli {

namespace {
using Clock = std::chrono::steady_clock;

struct Left {
    std::string what, why;
};

// One part after the other, each with its share of the whole way.
std::vector<Left> measure_all(std::vector<bench::BenchPart>& parts, Output& output)
{
    std::vector<Left> left;
    const Progress progress = output.progress();
    double total = 0, before = 0;
    for (const bench::BenchPart& part : parts) total += part.weight;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        bench::BenchPart& part = parts[i];
        output.say(fmt::format("{} of {}: {}", i + 1, parts.size(), part.name));
        try {
            part.measure([&](const ProgressStep& step) {
                return progress({"measuring", (before + part.weight * step.done) / total});
            });
        } catch (const MissingError& error) {
            output.warn(fmt::format("{}: left out: {}", part.name, error.what()));
            left.push_back({part.name, error.what()});
        }
        before += part.weight;
    }
    return left;
}
}   // namespace

int run_bench_all(const CommandLine& line, Output& output)
{
    if (!line.values.given("report")) throw UsageError("bench all needs --report DIR: where to put the page");
    const int threads =
        line.values.integer("threads") > 0 ? line.values.integer("threads") : gnomon::processor_threads();
    const bench::BenchSettings settings{line.values.flag("quick"), threads, line.command, bench::find_bench_scenes()};
    bench::ReportFile file(line.values.text("report"));   // made now, so that a wrong one is found before the work
    const auto start = Clock::now();

    std::vector<std::unique_ptr<bench::BenchChapter>> chapters;
    chapters.push_back(bench::culling_chapter(settings));
    chapters.push_back(bench::shadow_textures_chapter(settings));
    chapters.push_back(bench::indirect_chapter(settings));
    chapters.push_back(bench::frame_chapter(settings));

    std::vector<bench::BenchPart> parts;
    for (const auto& chapter : chapters)
        for (bench::BenchPart& part : chapter->parts()) parts.push_back(std::move(part));
    const std::vector<Left> left = measure_all(parts, output);

    bench::ReportPage page("Gnomon beside the papers it is made of", bench::machine_line(threads));
    bench::ReportTable lead;
    lead.columns = {"", "as printed", "as published, here", "Gnomon's own"};
    lead.caption = "The most important figures. What was measured, and how, is in the sections below.";
    for (const auto& chapter : chapters)
        for (bench::ReportTable::Row& row : chapter->lead()) lead.rows.push_back(std::move(row));
    page.lead(lead, settings.command);
    nlohmann::ordered_json document{{"machine", bench::machine_line(threads)}, {"quick", settings.quick}};
    for (const auto& chapter : chapters) {
        chapter->write(page);
        document[chapter->name()] = chapter->json();
    }
    page.section("About this page", settings.command);
    if (settings.quick)
        page.text(
            "Measured with --quick: smaller images and fewer frames than the papers', so ratios and percentages are "
            "near "
            "theirs, times are not.");
    for (const auto& [name, scene] :
         {std::pair{"BART's Kitchen", settings.scenes.kitchen}, {"BART's Robots", settings.scenes.robots}})
        if (scene.empty())
            page.text(
                fmt::format("{} is not there: set GNOMON_SCENES to the folder that holds bart/. {} stands in where "
                            "nothing else is left.",
                            name, settings.scenes.stand_in));
    for (const Left& one : left) page.text(fmt::format("Left out: {}: {}.", one.what, one.why));
    page.text(
        fmt::format("Measured in {}.", duration_text(std::chrono::duration<double>(Clock::now() - start).count())));
    page.attach("all.json", document);
    file.write(page);
    output.say(fmt::format("report     {}", file.path().string()));
    output.finish(document);
    return 0;
}

}   // namespace gnomon::cli
