// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/tables.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>

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
        "sums over frames, so both are given; nor does it state the frames and the number of lights.";
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
