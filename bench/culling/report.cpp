// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/culling/json.h"
#include "bench/culling/tables.h"

namespace gnomon::bench {

namespace {

using Style = ChartSeries::Style;

// A line chart series of one value per frame.
template <class Value>
ChartSeries line(const CullingBenchResult& result, const std::string& name, const std::string& color, Value value,
                 Style style = Style::line)
{
    ChartSeries series{name, {}, color, style};
    for (const CullingFrame& frame : result.frames)
        series.points.emplace_back(frame.frame, static_cast<double>(value(frame)));
    return series;
}

double percent(std::uint64_t part, std::uint64_t whole)
{
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

// A printed mean, as a dashed line through the chart.
ChartSeries printed_mean(const CullingBenchResult& result, const std::string& name, double value,
                         const std::string& color)
{
    return line(
        result, name, color, [&](const CullingFrame&) { return value; }, Style::dashed);
}

// Marks a printed best value at its frame, if that frame is shown.
void add_printed_best(Chart& chart, const CullingBenchResult& result, const std::string& name, int frame, double value,
                      const std::string& color)
{
    if (frame < result.frames.front().frame || frame > result.frames.back().frame) return;
    chart.series.push_back({name, {{static_cast<double>(frame), value}}, color, Style::points});
}

class Section {
 public:
    Section(ReportPage& page, const CullingWindow& window)
        : page_(page),
          window_(window),
          options_(window.options),
          result_(window.result),
          printed_(printed_culling_of(window.scene))
    {
    }

    void write(CullingCharts charts)
    {
        page_.section(fmt::format("Shadow culling: {}", name_of(window_)), window_.command);
        page_.text(fmt::format(
            "{} x {} pixels, {} light{}, {}; {}{}. Every method computes the whole shadow pass for the same "
            "points: 'every ray' traces every shadow ray in packets through one BVH, 'published' is the method of "
            "Nah, Park and Han (2009), and 'certified' is Gnomon's method.{}",
            options_.size.width, options_.size.height, window_.lights, window_.lights == 1 ? "" : "s",
            options_.max_depth == 0 ? "primary hits only"
                                    : fmt::format("hits to reflection depth {}", options_.max_depth),
            options_.threads == 0 ? std::string("all threads")
                                  : fmt::format("{} thread{}", options_.threads, options_.threads == 1 ? "" : "s"),
            options_.repeat > 1 ? fmt::format("; times are medians of {} runs", options_.repeat) : "",
            window_.moving_lights ? " Every light moves in every frame, so no result can be reused." : ""));
        const bool all = charts != CullingCharts::brief;
        if (options_.counts) {
            if (charts == CullingCharts::all) {
                page_.table(table_of_savings({&window_, 1}));
                page_.table(table_of_reasons({&window_, 1}));
                if (!options_.readings.empty()) page_.table(table_of_readings({&window_, 1}));
                if (!window_.steps.empty()) add_step_figures(page_, {&window_, 1});
            }
            if (options_.paper && all) figure_of_the_paper();
            if (options_.certified) savings();
        }
        if (options_.certified && all) certified();
        if (options_.paper && all) rays_of_paper();
        if (options_.paper) wrong();
    }

 private:
    // Redraws Figures 7 and 8: the counts of every frame.
    void figure_of_the_paper()
    {
        const std::string figure = printed_ ? printed_->figure : "Figures 7 and 8";
        const auto off_color = k_color_off;
        Chart nodes{
            fmt::format("{}: traversal steps of shadow rays", figure), "frame", "steps per frame", {}, {}, {}, {}, {}};
        nodes.series.push_back(line(result_, "every ray", off_color, [](auto& f) { return f.off.nodes; }));
        nodes.series.push_back(line(result_, "published", k_color_paper, [](auto& f) { return f.paper.nodes; }));
        if (options_.certified)
            nodes.series.push_back(line(result_, "certified", k_color_ours, [](auto& f) { return f.certified.nodes; }));
        page_.chart(nodes,
                    fmt::format("{} of the paper, measured here: kd-tree nodes visited by shadow rays.", figure));

        Chart tests{
            fmt::format("{}: triangle tests of shadow rays", figure), "frame", "tests per frame", {}, {}, {}, {}, {}};
        tests.series.push_back(line(result_, "every ray", off_color, [](auto& f) { return f.off.tests; }));
        tests.series.push_back(line(result_, "published", k_color_paper, [](auto& f) { return f.paper.tests; }));
        tests.series.push_back(line(result_, "extra tests of the occlusion test", k_color_second,
                                    [](auto& f) { return f.paper.extra_tests; }));
        if (options_.certified)
            tests.series.push_back(line(result_, "certified", k_color_ours, [](auto& f) { return f.certified.tests; }));
        page_.chart(tests, fmt::format("{} of the paper, measured here: triangle tests of shadow rays, and the extra "
                                       "tests of the published method's occlusion test.",
                                       figure));

        Chart saved{fmt::format("{}: savings of the published method", figure), "frame", "% saved", {}, {}, {}, {}, {}};
        saved.series.push_back(line(result_, "steps, measured", k_color_ours,
                                    [](auto& f) { return 100 - percent(f.paper.nodes, f.off.nodes); }));
        saved.series.push_back(line(result_, "tests, measured", k_color_paper,
                                    [](auto& f) { return 100 - percent(f.paper.tests, f.off.tests); }));
        Chart extra{fmt::format("{}: extra tests of the occlusion test", figure),
                    "frame",
                    "tests per pixel",
                    {},
                    {},
                    {},
                    {},
                    {}};
        extra.series.push_back(
            line(result_, "measured", k_color_paper, [](auto& f) { return f.paper.extra_tests_per_pixel; }));
        if (printed_) {
            saved.series.push_back(printed_mean(result_, "steps, printed mean", printed_->nodes_mean, k_color_ours));
            saved.series.push_back(printed_mean(result_, "tests, printed mean", printed_->tests_mean, k_color_paper));
            add_printed_best(saved, result_, "steps, printed best", printed_->nodes_best_frame, printed_->nodes_best,
                             k_color_ours);
            add_printed_best(saved, result_, "tests, printed best", printed_->tests_best_frame, printed_->tests_best,
                             k_color_paper);
            extra.series.push_back(
                printed_mean(result_, "printed mean", printed_->extra_tests_per_pixel, k_color_printed));
        }
        page_.chart(saved, printed_ ? fmt::format("Traversal steps and triangle tests saved by the published method, "
                                                  "in percent. Dashed lines are the means that the paper prints for "
                                                  "{}; marks are its best frames, where they lie in this range.",
                                                  figure)
                                    : "Traversal steps and triangle tests saved by the published method, in percent.");
        page_.chart(extra, "Extra triangle tests of the published method, per pixel of the image.");
    }

    void savings()
    {
        Chart saved{"Saved on the kd-tree", "frame", "% saved", {}, {}, {}, {}, 100.0};
        saved.series.push_back(line(result_, "steps, certified", k_color_ours,
                                    [](auto& f) { return 100 - percent(f.certified.nodes, f.off.nodes); }));
        saved.series.push_back(line(result_, "tests, certified", k_color_third,
                                    [](auto& f) { return 100 - percent(f.certified.tests, f.off.tests); }));
        if (options_.paper) {
            saved.series.push_back(line(result_, "steps, published", k_color_paper,
                                        [](auto& f) { return 100 - percent(f.paper.nodes, f.off.nodes); }));
            saved.series.push_back(line(result_, "tests, published", k_color_second,
                                        [](auto& f) { return 100 - percent(f.paper.tests, f.off.tests); }));
        }
        page_.chart(saved,
                    "Traversal steps and triangle tests saved by certified culling and by the published method, in "
                    "percent.");
    }

    void certified()
    {
        const CullingBenchResult& r = result_;
        page_.table(table_of_speed({&window_, 1}));
        if (window_.moving_lights)
            page_.text(
                fmt::format("While every light moves, certified culling takes {:.3f} times the time of tracing every "
                            "ray, from the second frame on.",
                            r.later_frames_ratio));

        Chart times{"Time of the shadow pass", "frame", "CPU ms per frame", {}, {}, {}, {}, {}};
        times.series.push_back(line(r, "every ray", k_color_off, [](auto& f) { return f.off.ms; }));
        if (options_.paper)
            times.series.push_back(line(r, "published", k_color_paper, [](auto& f) { return f.paper.ms; }));
        times.series.push_back(line(r, "certified", k_color_ours, [](auto& f) { return f.certified.ms; }));
        page_.chart(times,
                    "Process CPU time of the whole shadow pass, including each method's bookkeeping and proofs.");

        Chart speed{"Speed-up over tracing every ray", "frame", "speed-up", {}, {}, {}, {}, {}};
        speed.series.push_back(
            line(r, "certified", k_color_ours, [](auto& f) { return ratio(f.off.ms, f.certified.ms); }));
        if (options_.paper)
            speed.series.push_back(
                line(r, "published", k_color_paper, [](auto& f) { return ratio(f.off.ms, f.paper.ms); }));
        speed.series.push_back(line(
            r, "every ray", k_color_off, [](auto&) { return 1; }, Style::dashed));
        page_.chart(speed, "Speed-up of the shadow pass over tracing every ray, frame by frame.");

        Chart rays{"Shadow rays by class, certified", "frame", "% of the rays", {}, true, {}, {}, 100.0};
        rays.series.push_back(
            line(r, "culled", k_color_ours, [](auto& f) { return percent(f.certified.skipped, f.certified.rays); }));
        rays.series.push_back(line(r, "dynamic objects only", k_color_third,
                                   [](auto& f) { return percent(f.certified.dynamic_only, f.certified.rays); }));
        rays.series.push_back(line(r, "traced: known to be partial", k_color_second,
                                   [](auto& f) { return percent(f.certified.partial, f.certified.rays); }));
        rays.series.push_back(line(r, "traced: state not known", k_color_off, [](auto& f) {
            const std::uint64_t known = f.certified.skipped + f.certified.dynamic_only + f.certified.partial;
            return percent(f.certified.rays - std::min(known, f.certified.rays), f.certified.rays);
        }));
        page_.chart(rays,
                    "How certified culling treats each shadow ray: culled, traced against dynamic objects only, or "
                    "traced against everything.");

        Chart proofs{"Certificates", "frame", "per frame", {}, {}, {}, {}, {}};
        proofs.series.push_back(line(r, "tried", k_color_second, [](auto& f) { return f.certified.certificates; }));
        proofs.series.push_back(line(r, "proven", k_color_ours, [](auto& f) { return f.certified.certified; }));
        page_.chart(proofs, "Proofs tried at the end of each frame, and those that succeeded.");
    }

    void rays_of_paper()
    {
        Chart rays{"Shadow rays by class, published", "frame", "% of the rays", {}, true, {}, {}, 100.0};
        rays.series.push_back(
            line(result_, "culled", k_color_ours, [](auto& f) { return percent(f.paper.skipped, f.paper.rays); }));
        rays.series.push_back(line(result_, "dynamic objects only", k_color_third,
                                   [](auto& f) { return percent(f.paper.dynamic_only, f.paper.rays); }));
        using shadow_culling::FullReason;
        const auto traced = [&](const char* name, const char* color, FullReason reason) {
            rays.series.push_back(line(result_, name, color, [reason](auto& f) {
                return percent(f.paper.full[static_cast<std::size_t>(reason)], f.paper.rays);
            }));
        };
        traced("traced: shadowed in part", k_color_second, FullReason::partly_shadowed);
        traced("traced: hidden or cut off in part", k_color_paper, FullReason::partially_occluded);
        traced("traced: not seen before", k_color_fourth, FullReason::not_seen);
        traced("traced: on dynamic objects", k_color_printed, FullReason::dynamic);
        traced("traced: no shadow ray before", k_color_off, FullReason::not_shadowed);
        page_.chart(rays, "How the published method treats each shadow ray, and why it traces those that it does.");
    }

    void wrong()
    {
        Chart chart{"Wrong results", "frame", "(point, light) results", {}, {}, {}, {}, {}};
        chart.series.push_back(line(result_, "published", k_color_paper, [](auto& f) { return f.paper.wrong; }));
        if (options_.certified)
            chart.series.push_back(line(result_, "certified", k_color_ours, [](auto& f) { return f.certified.wrong; }));
        page_.chart(chart, "Results of a shading point and a light that differ from those of tracing every ray.");
        if (!result_.images) return;
        const WrongImages& p = *result_.images;
        page_.comparison({fmt::format("Frame {}, which has the most wrong results: direct light at the primary hits, "
                                      "with every ray traced and with the published method. {} results are wrong; the "
                                      "difference image shows those at primary hits in red.",
                                      p.frame, p.wrong),
                          "every ray", "published", p.off, p.paper, p.difference});
    }

    ReportPage& page_;
    const CullingWindow& window_;
    const CullingBenchOptions& options_;
    const CullingBenchResult& result_;
    const PrintedCulling* printed_;
};

}   // namespace

void add_step_figures(ReportPage& page, std::span<const CullingWindow> windows)
{
    page.table(table_of_steps(windows));
    Chart chart{"Savings against the step", "seconds between frames", "% saved, mean", {}, {}, {}, 0.0, {}};
    const char* colors[][2] = {{k_color_ours, k_color_paper}, {k_color_third, k_color_second}};
    for (std::size_t w = 0; w < windows.size(); ++w) {
        const std::string scene = std::filesystem::path(windows[w].scene).stem().string();
        ChartSeries nodes{fmt::format("{}: steps", scene), {}, colors[w % 2][0], Style::line};
        ChartSeries tests{fmt::format("{}: triangle tests", scene), {}, colors[w % 2][1], Style::line};
        std::vector<const CullingStep*> steps;
        for (const CullingStep& step : windows[w].steps) steps.push_back(&step);
        std::sort(steps.begin(), steps.end(), [](auto* a, auto* b) { return a->seconds < b->seconds; });
        for (const CullingStep* step : steps) {
            nodes.points.emplace_back(step->seconds, step->result.paper_saved.nodes_mean);
            tests.points.emplace_back(step->seconds, step->result.paper_saved.tests_mean);
        }
        if (steps.empty()) continue;
        chart.series.push_back(std::move(nodes));
        chart.series.push_back(std::move(tests));
    }
    page.chart(
        chart,
        "What the published method saves falls as frames lie further apart: fewer of the triangles in a frame were "
        "seen whole in the frame before.");
}

void add_culling_section(ReportPage& page, const CullingWindow& window, CullingCharts charts)
{
    if (window.result.frames.empty()) return;
    Section(page, window).write(charts);
    std::string name = fmt::format("culling-{}-{}-{}", std::filesystem::path(window.scene).stem().string(),
                                   window.options.frames.first, window.options.frames.last);
    if (window.options.step > 0)
        name += fmt::format("-from-{:g}s-every-{:g}s", window.result.frames.front().time, window.options.step);
    page.attach(name + ".json", culling_json(window));
}

}   // namespace gnomon::bench
