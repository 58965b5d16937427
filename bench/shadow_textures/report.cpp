// SPDX-License-Identifier: Apache-2.0
#include "bench/shadow_textures/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/report/image_figures.h"
#include "options/enum_names.h"

namespace gnomon::bench {

namespace {

using Style = ChartSeries::Style;
using Value = double ShadowTexturesRow::*;

// Percent of the whole frame's time saved at 10 percent dynamic objects [Oh and Shin 2004, 4].
constexpr double k_printed_dynamic = 10, k_printed_saved = 23.4;

const char* color_of(ShadowTextures method)
{
    switch (method) {
        case ShadowTextures::per_caster:
            return k_color_off;
        case ShadowTextures::depth:
            return k_color_paper;
        case ShadowTextures::items:
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
            "The scene has spheres of {} vertices at random positions with random motions, and one spot light with a "
            "view of {} x {} texels; the image has {} x {} pixels. Times are medians over {} frames by {}, after two "
            "frames that draw everything and detect the dynamic objects. 'per-caster', the previous method, draws for "
            "every receiver {}. 'depth' draws one depth buffer and every receiver once. 'coherent' keeps both from "
            "frame to frame and redraws only what changed. 'items' is coherent with one item buffer in place of all "
            "textures, Gnomon's default. The image is simple: every sphere is drawn once with its shadow texture{}.",
            options_.vertices, options_.view_size, options_.view_size, options_.size.width, options_.size.height,
            options_.frames, result_.clock == "device" ? "the device's timestamps" : "process CPU time",
            options_.as_printed ? "all casters nearer to the light, as the paper describes it"
                                : "the casters nearer to the light whose extents meet its own, as a fair opponent does",
            options_.as_printed ? ", whose colour alone decides, as in the paper" : ""));
        if (options_.dynamic_objects)
            crowd();
        else {
            if (options_.objects.size() > 1) figure_7();
            if (options_.dynamic.size() > 1) figure_8();
        }
        images();
        table();
    }

 private:
    // Shows Figure 6, and what the texture's colour alone decides wrongly.
    void images()
    {
        if (result_.images.empty() || options_.dynamic_objects) return;
        std::vector<NamedImage> list;
        for (const ShadowTexturesImages& one : result_.images)
            list.push_back({fmt::format("{} spheres", one.objects), one.compared});
        if (options_.objects.size() > 1)
            page_.gallery(
                list,
                "Figure 6 of the paper, with our spheres: the last frame of each number of objects. The paper "
                "shows 100 and 300; it does not state their positions, radii and colours.");
        const ShadowTexturesImages& last = result_.images.back();
        Tasks tasks(1);
        page_.comparison(compare_images(
            fmt::format("{} spheres, of which {} move. As printed, a pixel is lit where its object's texture is white: "
                        "no object shadows itself, and where the filter reads texels that the object just misses, its "
                        "rim is dark. With hard edges, {:.2f} % of the pixels differ.",
                        last.objects, last.dynamic_objects, result_.rows.back().printed_wrong_percent),
            "as printed", last.as_printed, "distances compared", last.compared, tasks));
    }

    bool has_first_percent(const ShadowTexturesRow& row) const
    {
        const int dynamic_objects = static_cast<int>(std::lround(row.objects * options_.dynamic.front() / 100));
        return row.dynamic_objects == dynamic_objects;
    }
    bool most_objects(const ShadowTexturesRow& row) const
    {
        return row.objects == *std::max_element(options_.objects.begin(), options_.objects.end());
    }

    template <class Filter, class X>
    std::vector<std::pair<double, double>> points(ShadowTextures method, Value y, const X& x,
                                                  const Filter& filter) const
    {
        std::vector<std::pair<double, double>> list;
        for (const ShadowTexturesRow& row : result_.rows)
            if (row.method == method && !row.by_footprints && filter(row))
                list.emplace_back(static_cast<double>(x(row)), row.*y);
        std::sort(list.begin(), list.end());
        return list;
    }
    template <class Filter, class X>
    Chart chart_of(const std::string& title, const std::string& x_label, const std::string& y_label, Value y,
                   const X& x, const Filter& filter) const
    {
        Chart chart{title, x_label, y_label, {}, {}, {}, {}, {}};
        for (const ShadowTextures method : options_.methods)
            chart.series.push_back(
                {std::string(options::name_of(method)), points(method, y, x, filter), color_of(method), Style::line});
        return chart;
    }

    // Redraws Figure 7: render time against the number of objects.
    void figure_7()
    {
        // Chart the whole frame.
        const auto by_objects = [](const ShadowTexturesRow& row) { return row.objects; };
        const auto shown = [&](const ShadowTexturesRow& row) { return has_first_percent(row); };
        const std::string moving = fmt::format("{} % of the objects are dynamic.", options_.dynamic.front());
        page_.chart(chart_of("Figure 7: the whole frame", "objects", "ms per frame", &ShadowTexturesRow::frame_ms,
                             by_objects, shown),
                    fmt::format("Figure 7 of the paper, measured here: time of the whole frame. {}", moving));

        // Chart the shadow pass on a logarithmic scale.
        Chart shadows = chart_of("Figure 7: the shadow pass", "objects", "ms per frame", &ShadowTexturesRow::shadow_ms,
                                 by_objects, shown);
        shadows.logarithmic = true;
        // Add the growth that the paper describes, scaled to our last points: quadratic for the previous method, linear
        // with one depth buffer.
        const auto described = [&](ShadowTextures method, const char* name, double power) {
            const auto ours = points(method, &ShadowTexturesRow::shadow_ms, by_objects, shown);
            if (ours.empty()) return;
            ChartSeries series{name, {}, k_color_printed, Style::dashed};
            for (const auto& point : ours)
                series.points.emplace_back(point.first,
                                           ours.back().second * std::pow(point.first / ours.back().first, power));
            shadows.series.push_back(std::move(series));
        };
        described(ShadowTextures::per_caster, "quadratic, as the paper describes the previous method", 2);
        described(ShadowTextures::depth, "linear, as the paper describes one depth buffer", 1);
        std::string exponents;
        for (const auto& [method, exponent] : result_.exponents)
            exponents += fmt::format("{}{} {:.2f}", exponents.empty() ? "" : ", ", options::name_of(method), exponent);
        page_.chart(
            shadows,
            fmt::format("The shadow pass alone, and the growth that the paper describes, scaled to the last measured "
                        "points because the paper prints no numbers. Measured growth as a power of the number of "
                        "objects, by least squares: {}. {}",
                        exponents, moving));
    }

    // Redraws Figure 8: render time with and without coherence against the percentage of dynamic objects.
    void figure_8()
    {
        // Chart the whole frame and the shadow pass.
        const auto by_percent = [](const ShadowTexturesRow& row) { return row.dynamic_percent; };
        const auto shown = [&](const ShadowTexturesRow& row) { return most_objects(row); };
        const int objects = *std::max_element(options_.objects.begin(), options_.objects.end());
        page_.chart(chart_of("Figure 8: the whole frame", "dynamic objects, %", "ms per frame",
                             &ShadowTexturesRow::frame_ms, by_percent, shown),
                    fmt::format("Figure 8 of the paper, measured here: time of the whole frame, {} objects.", objects));
        page_.chart(chart_of("Figure 8: the shadow pass", "dynamic objects, %", "ms per frame",
                             &ShadowTexturesRow::shadow_ms, by_percent, shown),
                    fmt::format("Time of the shadow pass alone, {} objects.", objects));

        // Chart the time saved, with the value that the paper prints.
        const auto saved = [&](ShadowTextures method, Value y) {
            const auto depth = points(ShadowTextures::depth, y, by_percent, shown),
                       coherent = points(method, y, by_percent, shown);
            std::vector<std::pair<double, double>> list;
            for (std::size_t i = 0; i < std::min(depth.size(), coherent.size()); ++i)
                list.emplace_back(depth[i].first, 100 * (1 - coherent[i].second / depth[i].second));
            return list;
        };
        const auto frame = saved(ShadowTextures::coherent, &ShadowTexturesRow::frame_ms);
        if (frame.empty()) return;
        Chart chart{"Time saved by coherence", "dynamic objects, %", "% of the time of depth", {}, {}, {}, {}, {}};
        const auto add = [&](const char* name, ShadowTextures method, Value y, const char* color) {
            if (auto list = saved(method, y); !list.empty())
                chart.series.push_back({name, std::move(list), color, Style::line});
        };
        add("coherent, whole frame", ShadowTextures::coherent, &ShadowTexturesRow::frame_ms, k_color_ours);
        add("coherent, shadow pass", ShadowTextures::coherent, &ShadowTexturesRow::shadow_ms, k_color_third);
        add("items, whole frame", ShadowTextures::items, &ShadowTexturesRow::frame_ms, k_color_fourth);
        add("items, shadow pass", ShadowTextures::items, &ShadowTexturesRow::shadow_ms, k_color_second);
        chart.series.push_back(
            {"whole frame, printed", {{k_printed_dynamic, k_printed_saved}}, k_color_printed, Style::points});
        page_.chart(chart,
                    fmt::format("Time saved by coherence. The paper prints {} % of the whole frame at {} % dynamic "
                                "objects, on a Pentium IV 2.66 GHz with a Radeon 9800 XT; it does not state the "
                                "number of objects and lights or the resolution.",
                                k_printed_saved, k_printed_dynamic));
    }

    // Shows the cost of a few dynamic objects among a growing number of static ones.
    void crowd()
    {
        const auto by_objects = [](const ShadowTexturesRow& row) { return row.objects; };
        const auto all = [](const ShadowTexturesRow&) { return true; };
        Chart time =
            chart_of("The shadow pass", "objects", "ms per frame", &ShadowTexturesRow::shadow_ms, by_objects, all);
        time.logarithmic = true;
        page_.chart(time, fmt::format("Time of the shadow pass with {} dynamic objects among small static ones. The "
                                      "density around the dynamic objects is the same for every number of objects.",
                                      *options_.dynamic_objects));
        Chart touched{"Objects visited", "objects", "per frame", {}, {}, {}, {}, {}};
        for (const ShadowTextures method : options_.methods)
            if (method == ShadowTextures::coherent || method == ShadowTextures::items)
                touched.series.push_back({std::string(options::name_of(method)),
                                          points(method, &ShadowTexturesRow::touched, by_objects, all),
                                          color_of(method), Style::line});
        page_.chart(touched, "Objects and entries of the light-space index that are visited to plan a frame.");
    }

    void table()
    {
        ReportTable table;
        table.caption =
            "All settings. The shadow pass consists of the light view's buffers and the receivers' textures, which "
            "'items' does not need. Planning is the CPU time to plan and record the pass. Identical: after the last "
            "frame, buffers and textures equal those of a full redraw to the bit. Draws without extents: those of the "
            "previous method if it drew all casters nearer than a receiver. As printed: pixels of the last frame in "
            "which the texture's colour decides otherwise than comparing distances, with hard edges.";
        table.columns = {"objects, dynamic objects, method",
                         "shadow pass, ms",
                         "buffers, ms",
                         "textures, ms",
                         "planning, ms",
                         "whole frame, ms",
                         "draws",
                         "draws without extents",
                         "copies",
                         "textures drawn",
                         "objects visited",
                         "identical",
                         "as printed, pixels wrong, %"};
        for (const ShadowTexturesRow& r : result_.rows)
            table.rows.push_back({{fmt::format("{}, {}, {}", r.objects, r.dynamic_objects, name_of(r)),
                                   fmt::format("{:.2f}", r.shadow_ms), fmt::format("{:.2f}", r.buffers_ms),
                                   fmt::format("{:.2f}", r.textures_ms), fmt::format("{:.3f}", r.shadow_cpu_ms),
                                   fmt::format("{:.2f}", r.frame_ms), fmt::format("{:.1f}", r.draws),
                                   r.draws_of_all_between > 0 ? fmt::format("{:.1f}", r.draws_of_all_between) : "",
                                   fmt::format("{:.1f}", r.copies), fmt::format("{:.1f}", r.textures_updated),
                                   fmt::format("{:.1f}", r.touched), r.identical_to_full ? "yes" : "no",
                                   fmt::format("{:.2f}", r.printed_wrong_percent)},
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
