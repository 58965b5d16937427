// SPDX-License-Identifier: Apache-2.0
#include "bench/report/chart.h"

#include <nlohmann/json.hpp>

namespace gnomon::bench {

namespace {
using Json = nlohmann::ordered_json;

constexpr double k_line_width = 2;
constexpr double k_point_radius = 6;
constexpr std::size_t k_few_points = 12;   // up to this many points are marked, so that a single point is visible

Json dataset(const ChartSeries& series, bool stacked, bool lowest)
{
    Json points = Json::array();
    for (const auto& [x, y] : series.points) points.push_back({{"x", x}, {"y", y}});
    const bool marks = series.style == ChartSeries::Style::points;
    Json set{{"label", series.name},
             {"data", std::move(points)},
             {"borderColor", series.color},
             {"backgroundColor", stacked ? series.color + "b0" : series.color},
             {"borderWidth", k_line_width},
             {"pointRadius", marks                                  ? k_point_radius
                             : series.points.size() <= k_few_points ? 2
                                                                    : 0},
             {"pointHitRadius", k_point_radius},
             {"showLine", !marks}};
    if (marks) set["pointStyle"] = "rectRot";
    if (series.style == ChartSeries::Style::dashed) set["borderDash"] = {6, 4};
    if (stacked) set["fill"] = lowest ? "origin" : "-1";
    return set;
}
}   // namespace

Json chart_js(const Chart& chart)
{
    Json sets = Json::array();
    for (const ChartSeries& series : chart.series) sets.push_back(dataset(series, chart.stacked, sets.empty()));
    const auto title = [](const std::string& text) { return Json{{"display", !text.empty()}, {"text", text}}; };
    Json x{{"type", "linear"}, {"title", title(chart.x_label)}};
    // End the x axis where the data end.
    bool any = false;
    double low = 0, high = 0;
    for (const ChartSeries& series : chart.series)
        for (const auto& point : series.points) {
            low = any ? std::min(low, point.first) : point.first;
            high = any ? std::max(high, point.first) : point.first;
            any = true;
        }
    if (any && high > low) x["min"] = low, x["max"] = high;
    Json y{{"type", chart.logarithmic ? "logarithmic" : "linear"},
           {"title", title(chart.y_label)},
           {"stacked", chart.stacked}};
    if (!chart.logarithmic) y["beginAtZero"] = true;
    if (!chart.y_high) y["grace"] = "3%";   // so that a mark at the top is not clipped
    if (chart.y_low) y["min"] = *chart.y_low;
    if (chart.y_high) y["max"] = *chart.y_high;
    return {{"type", "line"},
            {"data", {{"datasets", std::move(sets)}}},
            {"options",
             {{"scales", {{"x", std::move(x)}, {"y", std::move(y)}}}, {"plugins", {{"title", title(chart.title)}}}}}};
}

}   // namespace gnomon::bench
