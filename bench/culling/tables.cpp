// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "bench/culling/readings.h"

namespace gnomon::bench {

namespace {

constexpr PrintedCulling k_printed[] = {
    {"BART Kitchen", "Figure 7", "kitchen", 22, 19.8, 59.5, 24.5, 59.8, 20, 19, 0.173},
    {"BART Robots", "Figure 8", "robot", 52, 7.4, 19.5, 9.5, 29.6, 31, 41, 0.149},
};

std::string number(double value, int digits)
{
    return fmt::format("{:.{}f}", value, digits);
}

std::string best(double value, int frame)
{
    return fmt::format("{:.1f} (frame {})", value, frame);
}

void add_saved(ReportTable& table, const std::string& name, const CullingBenchResult::Saved& s,
               const std::string& extra, const std::string& wrong)
{
    table.rows.push_back({{name, number(s.nodes_mean, 1), best(s.nodes_best, s.nodes_best_frame),
                           number(s.tests_mean, 1), best(s.tests_best, s.tests_best_frame), extra, wrong},
                          false});
    table.rows.push_back(
        {{"of the sums over all frames", number(s.nodes_of_totals, 1), "", number(s.tests_of_totals, 1), "", "", ""},
         false});
}

}   // namespace

const PrintedCulling* printed_culling_of(const std::string& scene)
{
    std::string name = std::filesystem::path(scene).stem().string();
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const PrintedCulling& printed : k_printed)
        if (name.starts_with(printed.file)) return &printed;
    return nullptr;
}

ReportTable table_of_savings(std::span<const CullingWindow> windows)
{
    ReportTable table;
    table.caption =
        "Table 4 of the paper: percent of the shadow rays' kd-tree traversal steps and triangle tests that are saved. "
        "Printed values are coloured. The paper does not state whether its means are of the frames' percentages or of "
        "sums over frames, so both are given; nor does it state the frames and the number of lights. It has 22 and 52 "
        "frames of clips of 20 and 50 seconds, which is one a second: from 0 s on, or from -1 s, where the camera's "
        "keys "
        "begin. Windows of the clip's own frames, 1/40 and 1/16 s apart, follow.";
    table.columns = {"",
                     "steps saved, mean %",
                     "best %",
                     "tests saved, mean %",
                     "best %",
                     "extra tests per pixel",
                     "wrong results per frame"};
    for (const PrintedCulling& p : k_printed)
        table.rows.push_back({{fmt::format("{}, {} frames, printed", p.scene, p.frames), number(p.nodes_mean, 1),
                               best(p.nodes_best, p.nodes_best_frame), number(p.tests_mean, 1),
                               best(p.tests_best, p.tests_best_frame), number(p.extra_tests_per_pixel, 3), "not given"},
                              true});
    for (const CullingWindow& w : windows) {
        if (!w.options.counts || w.result.frames.empty()) continue;
        const CullingBenchResult& r = w.result;
        if (w.options.paper)
            add_saved(table, fmt::format("{}, published", name_of(w)), r.paper_saved,
                      number(r.paper_extra_tests_per_pixel, 3), number(r.paper_wrong_mean, 1));
        if (w.options.certified)
            add_saved(table, fmt::format("{}, certified", name_of(w)), r.certified_saved, "none",
                      number(static_cast<double>(r.wrong_total) / static_cast<double>(r.frames.size()), 1));
    }
    return table;
}

ReportTable table_of_reasons(std::span<const CullingWindow> windows)
{
    using shadow_culling::FullReason;
    ReportTable table;
    table.caption =
        "Why shadow rays of the published method are traced: percent of all shadow rays over all frames of a window. "
        "What is hidden or cut off in part, not seen before, or shadowed in part is traced against everything, "
        "whatever "
        "the step. The paper does not count this.";
    table.columns = {"",
                     "no ray",
                     "dynamic objects only",
                     "on dynamic objects",
                     "hidden or cut off in part",
                     "not seen before",
                     "shadowed in part",
                     "no shadow ray before"};
    for (const CullingWindow& w : windows) {
        if (!w.options.paper || w.result.frames.empty()) continue;
        CullingFrame::Paper sum;
        for (const CullingFrame& frame : w.result.frames) {
            sum.rays += frame.paper.rays, sum.skipped += frame.paper.skipped;
            sum.dynamic_only += frame.paper.dynamic_only;
            for (std::size_t i = 0; i < sum.full.size(); ++i) sum.full[i] += frame.paper.full[i];
        }
        const auto percent = [&](std::uint64_t n) {
            return number(100 * static_cast<double>(n) / std::max(1.0, static_cast<double>(sum.rays)), 1);
        };
        const auto full = [&](FullReason reason) { return percent(sum.full[static_cast<std::size_t>(reason)]); };
        table.rows.push_back({{name_of(w), percent(sum.skipped), percent(sum.dynamic_only), full(FullReason::dynamic),
                               full(FullReason::partially_occluded), full(FullReason::not_seen),
                               full(FullReason::partly_shadowed), full(FullReason::not_shadowed)},
                              false});
    }
    return table;
}

ReportTable table_of_readings(std::span<const CullingWindow> windows)
{
    ReportTable table;
    table.caption =
        "Readings of the paper that each change one thing, and its two extensions by its own future work. Percent "
        "saved, mean (best) over the frames.";
    table.columns = {"",      "steps saved, %", "tests saved, %", "extra tests per pixel", "wrong results per frame",
                     "memory"};
    const auto add = [&](const std::string& name, const CullingBenchResult::Saved& s, double extra, double wrong,
                         std::uint64_t bytes) {
        table.rows.push_back({{name, fmt::format("{:.1f} ({:.1f})", s.nodes_mean, s.nodes_best),
                               fmt::format("{:.1f} ({:.1f})", s.tests_mean, s.tests_best), number(extra, 3),
                               number(wrong, 1), fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6)},
                              false});
    };
    for (const CullingWindow& w : windows) {
        if (!w.options.counts || w.options.readings.empty() || w.result.frames.empty()) continue;
        const CullingBenchResult& r = w.result;
        add(fmt::format("{}, as measured above", name_of(w)), r.paper_saved, r.paper_extra_tests_per_pixel,
            r.paper_wrong_mean, r.paper_bytes);
        for (std::size_t i = 0; i < r.readings.size(); ++i)
            add(w.options.readings[i].label, r.readings[i].saved, r.readings[i].extra_tests_per_pixel,
                r.readings[i].wrong_mean, r.readings[i].bytes);
    }
    return table;
}

ReportTable table_of_steps(std::span<const CullingWindow> windows)
{
    ReportTable table;
    table.caption =
        "Savings against the time between frames, always in the same frames: those of the largest step, after a "
        "history "
        "of frames of each step. The paper has one step for each scene, and does not state it.";
    table.columns = {"",
                     "step, s",
                     "steps saved, mean (best) %",
                     "tests saved, mean (best) %",
                     "extra tests per pixel",
                     "wrong results per frame"};
    for (const CullingWindow& w : windows)
        for (const CullingStep& step : w.steps) {
            const CullingBenchResult& r = step.result;
            table.rows.push_back(
                {{std::filesystem::path(w.scene).filename().string(), fmt::format("{:g}", step.seconds),
                  fmt::format("{:.1f} ({:.1f})", r.paper_saved.nodes_mean, r.paper_saved.nodes_best),
                  fmt::format("{:.1f} ({:.1f})", r.paper_saved.tests_mean, r.paper_saved.tests_best),
                  number(r.paper_extra_tests_per_pixel, 3), number(r.paper_wrong_mean, 1)},
                 false});
        }
    return table;
}

ReportTable table_of_trees(std::span<const CullingWindow> windows)
{
    ReportTable table;
    table.caption =
        "Figure 4 of the paper, measured: the published method on a kd-tree with static and dynamic triangles in trees "
        "of "
        "their own, on one tree split along the scene graph (Figure 4a), and on one split by the surface area "
        "heuristic "
        "over all triangles alone (4b). In one tree, traversal of dynamic objects stops at nodes that hold none.";
    table.columns = {"",
                     "tree",
                     "nodes",
                     "split at bounds of the scene graph",
                     "steps of every ray, millions",
                     "steps saved, mean (best) %",
                     "tests of every ray, millions",
                     "tests saved, mean (best) %"};
    for (const CullingWindow& w : windows) {
        if (!w.options.counts || !w.options.paper || w.result.frames.empty()) continue;
        std::uint64_t nodes = 0, tests = 0;
        for (const CullingFrame& frame : w.result.frames) nodes += frame.off.nodes, tests += frame.off.tests;
        const auto millions = [&](std::uint64_t n) {
            return number(static_cast<double>(n) / 1e6 / static_cast<double>(w.result.frames.size()), 1);
        };
        const CullingBenchResult::Saved& s = w.result.paper_saved;
        table.rows.push_back({{name_of(w), name_of(w.options.layout), fmt::format("{}", w.result.tree_nodes),
                               fmt::format("{}", w.result.tree_group_splits), millions(nodes),
                               fmt::format("{:.1f} ({:.1f})", s.nodes_mean, s.nodes_best), millions(tests),
                               fmt::format("{:.1f} ({:.1f})", s.tests_mean, s.tests_best)},
                              false});
    }
    return table;
}

ReportTable table_of_speed(std::span<const CullingWindow> windows)
{
    ReportTable table;
    table.caption =
        "Certified culling compared with tracing every ray. Speed-ups are ratios of summed process CPU times, "
        "including "
        "certificates. First and worst later frame are ratios of wall times.";
    table.columns = {"",
                     "speed-up",
                     "second half",
                     "first frame",
                     "worst later frame",
                     "wrong results",
                     "visible triangles",
                     "memory",
                     "bytes per triangle and light"};
    for (const CullingWindow& w : windows) {
        if (!w.options.certified || w.result.frames.empty()) continue;
        const CullingBenchResult& r = w.result;
        table.rows.push_back(
            {{name_of(w), fmt::format("{:.2f} x", r.speedup_mean), fmt::format("{:.2f} x", r.speedup_steady),
              fmt::format("{:.2f} x the time", r.first_frame_ratio),
              r.frames.size() > 1 ? fmt::format("{:.2f} x the time", r.worst_frame_ratio) : std::string("-"),
              fmt::format("{}", r.wrong_total), fmt::format("{}", r.visible_triangles),
              fmt::format("{:.2f} MB", static_cast<double>(r.bytes) / 1e6),
              fmt::format("{:.1f}", r.bytes_per_triangle_light)},
             false});
    }
    return table;
}

}   // namespace gnomon::bench
