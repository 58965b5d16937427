// SPDX-License-Identifier: Apache-2.0
#include "bench/shadow_textures/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace gnomon::bench {

namespace {

using Style = ChartSeries::Style;
using Value = double ShadowTexturesRow::*;

// Of the whole frame at 10 percent dynamic objects [Oh and Shin 2004, 4].
constexpr double k_printed_dynamic = 10, k_printed_saved = 23.4;

const char* color_of(TextureMethod method)
{
    switch (method) {
        case TextureMethod::per_caster:
            return k_color_off;
        case TextureMethod::depth:
            return k_color_paper;
        case TextureMethod::items:
            return k_color_fourth;
        default:
            return k_color_ours;
    }
}

class Section {
 public:
    Section(ReportPage& page, const ShadowTexturesBenchOptions& options, const ShadowTexturesBenchResult& result)
        : page_(page), options_(options), result_(result)
    {
    }

    void write()
    {
        page_.text(fmt::format(
            "Spheres of {} vertices at random places with random motions; one spot light, its view {} x {} texels; the "
            "image {} x {} pixels. Times are medians of {} frames after the first two (everything drawn, dynamic "
            "objects "
            "found out), of {}. Per-caster draws for every "
            "receiver all casters between it and the light; depth draws one depth buffer and every receiver once; "
            "coherent keeps both from frame to frame and touches what moved; items is coherent with one item buffer in "
            "place "
            "of all textures, as Gnomon's images have it. The image is the plainest: every sphere "
            "drawn once, with its shadow texture.",
            options_.vertices, options_.view_size, options_.view_size, options_.size.width, options_.size.height,
            options_.frames, result_.clock == "device" ? "the device's timestamps" : "process CPU time"));
        if (options_.dynamic_objects)
            crowd();
        else {
            if (options_.objects.size() > 1) figure_7();
            if (options_.dynamic.size() > 1) figure_8();
        }
        table();
    }

 private:
    bool first_share(const ShadowTexturesRow& row) const
    {
        const int dynamic_objects = static_cast<int>(std::lround(row.objects * options_.dynamic.front() / 100));
        return row.dynamic_objects == dynamic_objects;
    }
    bool most_objects(const ShadowTexturesRow& row) const
    {
        return row.objects == *std::max_element(options_.objects.begin(), options_.objects.end());
    }

    template <class Filter, class X>
    std::vector<std::pair<double, double>> points(TextureMethod method, Value y, const X& x, const Filter& filter) const
    {
        std::vector<std::pair<double, double>> list;
        for (const ShadowTexturesRow& row : result_.rows)
            if (row.method == method && filter(row)) list.emplace_back(static_cast<double>(x(row)), row.*y);
        std::sort(list.begin(), list.end());
        return list;
    }
    template <class Filter, class X>
    Chart chart_of(const std::string& title, const std::string& x_label, const std::string& y_label, Value y,
                   const X& x, const Filter& filter) const
    {
        Chart chart{title, x_label, y_label, {}, {}, {}, {}, {}};
        for (const TextureMethod method : options_.methods)
            chart.series.push_back({name_of(method), points(method, y, x, filter), color_of(method), Style::line});
        return chart;
    }

    // Render time against the number of objects.
    void figure_7()
    {
        const auto by_objects = [](const ShadowTexturesRow& row) { return row.objects; };
        const auto shown = [&](const ShadowTexturesRow& row) { return first_share(row); };
        const std::string moving = fmt::format("{} % of the objects move.", options_.dynamic.front());
        page_.chart(chart_of("Figure 7: the whole frame", "objects", "ms a frame", &ShadowTexturesRow::frame_ms,
                             by_objects, shown),
                    fmt::format("Figure 7 of the paper, redrawn: time of the whole frame. {}", moving));

        Chart shadows = chart_of("Figure 7: the shadow pass", "objects", "ms a frame", &ShadowTexturesRow::shadow_ms,
                                 by_objects, shown);
        shadows.logarithmic = true;
        // As the paper describes the curves, through our last points: quadratic before, linear with one depth buffer.
        const auto described = [&](TextureMethod method, const char* name, double power) {
            const auto ours = points(method, &ShadowTexturesRow::shadow_ms, by_objects, shown);
            if (ours.empty()) return;
            ChartSeries series{name, {}, k_color_printed, Style::dashed};
            for (const auto& point : ours)
                series.points.emplace_back(point.first,
                                           ours.back().second * std::pow(point.first / ours.back().first, power));
            shadows.series.push_back(std::move(series));
        };
        described(TextureMethod::per_caster, "quadratic, as the paper describes the previous method", 2);
        described(TextureMethod::depth, "linear, as it describes one depth buffer", 1);
        std::string exponents;
        for (const auto& [method, exponent] : result_.exponents)
            exponents += fmt::format("{}{} {:.2f}", exponents.empty() ? "" : ", ", name_of(method), exponent);
        page_.chart(
            shadows,
            fmt::format("The shadow pass alone, and the growth that the paper describes (it prints no numbers), "
                        "laid through our last points. Powers of the number of objects, by least squares: {}. {}",
                        exponents, moving));
    }

    // With and without coherence while the share of dynamic objects varies.
    void figure_8()
    {
        const auto by_share = [](const ShadowTexturesRow& row) { return row.dynamic_percent; };
        const auto shown = [&](const ShadowTexturesRow& row) { return most_objects(row); };
        const int objects = *std::max_element(options_.objects.begin(), options_.objects.end());
        page_.chart(chart_of("Figure 8: the whole frame", "dynamic objects, %", "ms a frame",
                             &ShadowTexturesRow::frame_ms, by_share, shown),
                    fmt::format("Figure 8 of the paper, redrawn: time of the whole frame, {} objects.", objects));
        page_.chart(chart_of("Figure 8: the shadow pass", "dynamic objects, %", "ms a frame",
                             &ShadowTexturesRow::shadow_ms, by_share, shown),
                    fmt::format("The shadow pass alone, {} objects.", objects));

        const auto saved = [&](TextureMethod method, Value y) {
            const auto depth = points(TextureMethod::depth, y, by_share, shown),
                       coherent = points(method, y, by_share, shown);
            std::vector<std::pair<double, double>> list;
            for (std::size_t i = 0; i < std::min(depth.size(), coherent.size()); ++i)
                list.emplace_back(depth[i].first, 100 * (1 - coherent[i].second / depth[i].second));
            return list;
        };
        const auto frame = saved(TextureMethod::coherent, &ShadowTexturesRow::frame_ms);
        if (frame.empty()) return;
        Chart chart{"Saved by coherence", "dynamic objects, %", "% of the time of depth", {}, {}, {}, {}, {}};
        const auto add = [&](const char* name, TextureMethod method, Value y, const char* color) {
            if (auto list = saved(method, y); !list.empty())
                chart.series.push_back({name, std::move(list), color, Style::line});
        };
        add("coherent, whole frame", TextureMethod::coherent, &ShadowTexturesRow::frame_ms, k_color_ours);
        add("coherent, shadow pass", TextureMethod::coherent, &ShadowTexturesRow::shadow_ms, k_color_third);
        add("items, whole frame", TextureMethod::items, &ShadowTexturesRow::frame_ms, k_color_fourth);
        add("items, shadow pass", TextureMethod::items, &ShadowTexturesRow::shadow_ms, k_color_second);
        chart.series.push_back(
            {"whole frame, as printed", {{k_printed_dynamic, k_printed_saved}}, k_color_printed, Style::points});
        page_.chart(chart,
                    fmt::format("What coherence saves; the paper prints {} % of the whole frame at {} % dynamic "
                                "objects (Pentium IV 2.66 GHz, Radeon 9800 XT; objects, lights and resolution are "
                                "not stated).",
                                k_printed_saved, k_printed_dynamic));
    }

    // A few dynamic objects, ever more that stands still beside them.
    void crowd()
    {
        const auto by_objects = [](const ShadowTexturesRow& row) { return row.objects; };
        const auto all = [](const ShadowTexturesRow&) { return true; };
        Chart time =
            chart_of("The shadow pass", "objects", "ms a frame", &ShadowTexturesRow::shadow_ms, by_objects, all);
        time.logarithmic = true;
        page_.chart(time, fmt::format("{} objects move, among small ones that stand still, equally dense around them "
                                      "whatever there is elsewhere.",
                                      *options_.dynamic_objects));
        Chart touched{"Objects looked at", "objects", "a frame", {}, {}, {}, {}, {}};
        for (const TextureMethod method : options_.methods)
            if (method == TextureMethod::coherent || method == TextureMethod::items)
                touched.series.push_back({name_of(method), points(method, &ShadowTexturesRow::touched, by_objects, all),
                                          color_of(method), Style::line});
        page_.chart(touched, "Objects and entries of the light-space index that planning a frame looks at.");
    }

    void table()
    {
        ReportTable table;
        table.caption =
            "Every setting. Shadow pass: the light view's buffers and the receivers' textures; the look-up of items "
            "could "
            "stand for the latter. CPU alone: planning and recording. Identical: to a full redraw, to the bit, after "
            "the "
            "last frame.";
        table.columns = {"objects, moving, method", "shadow pass, ms",   "buffers",  "textures",
                         "CPU alone, ms",           "whole frame, ms",   "draws",    "copies",
                         "textures made",           "objects looked at", "identical"};
        for (const ShadowTexturesRow& r : result_.rows)
            table.rows.push_back({{fmt::format("{}, {}, {}", r.objects, r.dynamic_objects, name_of(r.method)),
                                   fmt::format("{:.2f}", r.shadow_ms), fmt::format("{:.2f}", r.buffers_ms),
                                   fmt::format("{:.2f}", r.textures_ms), fmt::format("{:.3f}", r.shadow_cpu_ms),
                                   fmt::format("{:.2f}", r.frame_ms), fmt::format("{:.1f}", r.draws),
                                   fmt::format("{:.1f}", r.copies), fmt::format("{:.1f}", r.textures_updated),
                                   fmt::format("{:.1f}", r.touched), r.identical_to_full ? "yes" : "no"},
                                  false});
        page_.table(table);
    }

    ReportPage& page_;
    const ShadowTexturesBenchOptions& options_;
    const ShadowTexturesBenchResult& result_;
};

}   // namespace

void add_shadow_textures_section(ReportPage& page, const std::string& command,
                                 const ShadowTexturesBenchOptions& options, const ShadowTexturesBenchResult& result,
                                 const nlohmann::ordered_json& document)
{
    const char* const of = options.dynamic_objects      ? "crowd"
                           : options.objects.size() > 1 ? "figure-7"
                           : options.dynamic.size() > 1 ? "figure-8"
                                                        : "one";
    const std::map<std::string, std::string> titles{
        {"crowd", ": a crowd"}, {"figure-7", ": Figure 7"}, {"figure-8", ": Figure 8"}, {"one", ""}};
    page.section("Shadow textures (Oh and Shin 2004)" + titles.at(of), command);
    Section(page, options, result).write();
    page.attach(fmt::format("shadow-textures-{}.json", of), document);
}

}   // namespace gnomon::bench
