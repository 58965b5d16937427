// SPDX-License-Identifier: Apache-2.0
// gnomon bench all: measures every chapter and writes one report page.
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

struct SkippedPart {
    std::string name, reason;
};

// Measures one part after the other; progress advances by the weights of the parts. Returns the parts for which
// something is missing on this machine.
std::vector<SkippedPart> measure_all(std::vector<bench::BenchPart>& parts, Output& output)
{
    std::vector<SkippedPart> skipped;
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
            output.warn(fmt::format("skipped {}: {}", part.name, error.what()));
            skipped.push_back({part.name, error.what()});
        }
        before += part.weight;
    }
    return skipped;
}
}   // namespace

int run_bench_all(const CommandLine& line, Output& output)
{
    if (!line.values.given("report")) throw UsageError("bench all needs --report DIR, the folder for the page");
    const int threads =
        line.values.integer("threads") > 0 ? line.values.integer("threads") : gnomon::processor_threads();
    const bench::BenchSettings settings{line.values.flag("quick"), threads, line.command,
                                        bench::find_bench_scenes(line.values.text("scenes"))};
    bench::ReportFile file(
        line.values.text("report"));   // before the work, so that a folder that cannot be written fails at once
    const auto start = Clock::now();

    // Measure all parts of all chapters.
    std::vector<std::unique_ptr<bench::BenchChapter>> chapters;
    chapters.push_back(bench::culling_chapter(settings));
    chapters.push_back(bench::shadow_textures_chapter(settings));
    chapters.push_back(bench::indirect_chapter(settings));
    chapters.push_back(bench::frame_chapter(settings));

    std::vector<bench::BenchPart> parts;
    for (const auto& chapter : chapters)
        for (bench::BenchPart& part : chapter->parts()) parts.push_back(std::move(part));
    const std::vector<SkippedPart> skipped = measure_all(parts, output);

    // Write the page: the most important results, the chapters, and the conditions of the measurement.
    bench::ReportPage page("Gnomon compared with the papers it implements", bench::machine_line(threads));
    bench::ReportTable lead;
    lead.columns = {"", "printed in the paper", "published method, measured here", "Gnomon's method"};
    lead.caption = "The most important results. The sections below say what was measured and how.";
    for (const auto& chapter : chapters)
        for (bench::ReportTable::Row& row : chapter->lead()) lead.rows.push_back(std::move(row));
    std::vector<std::string> lacking = bench::missing_scenes(settings.scenes);
    for (const auto& chapter : chapters)
        for (std::string& sentence : chapter->left_out()) lacking.push_back(std::move(sentence));
    for (const SkippedPart& part : skipped) lacking.push_back(fmt::format("Skipped: {}: {}.", part.name, part.reason));
    page.notice("This page is not complete. Where the scenes come from is described in docs/guide/scenes.md.", lacking);
    page.lead(lead, settings.command);
    nlohmann::ordered_json document{
        {"machine", bench::machine_line(threads)}, {"quick", settings.quick}, {"lacking", lacking}};
    for (const auto& chapter : chapters) {
        chapter->write(page);
        document[chapter->name()] = chapter->json();
    }
    page.section("About this page", settings.command);
    if (settings.quick)
        page.text(
            "This page was measured with --quick: images are smaller and frames fewer than in the papers. Ratios and "
            "percentages are close to those of a full run; times are not.");
    page.text(fmt::format("The measurement took {}.",
                          duration_text(std::chrono::duration<double>(Clock::now() - start).count())));
    page.attach("all.json", document);
    file.write(page);
    output.say(fmt::format("report     {}", file.path().string()));
    output.finish(document);
    return 0;
}

}   // namespace gnomon::cli
