// SPDX-License-Identifier: Apache-2.0
#pragma once
// A chart as data, and as Chart.js (3.9) wants it. What it looks like beyond that is report/page.js's to say.

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon::bench {

/// Colours of what returns from chart to chart: told apart by colour-blind eyes, too.
inline constexpr const char* k_color_off = "#6b7280";       // every ray traced: grey
inline constexpr const char* k_color_paper = "#d55e00";     // as published: vermilion
inline constexpr const char* k_color_ours = "#0072b2";      // our own: blue
inline constexpr const char* k_color_printed = "#7b3294";   // values printed in a paper: purple
inline constexpr const char* k_color_second = "#e69f00";    // more of the published method: orange
inline constexpr const char* k_color_third = "#56b4e9";     // more of ours: sky blue
inline constexpr const char* k_color_fourth = "#009e73";    // green

struct ChartSeries {
    enum class Style { line, dashed, points };
    std::string name;
    std::vector<std::pair<double, double>> points;   // x ascending
    std::string color = k_color_off;
    Style style = Style::line;
};

struct Chart {
    std::string title;
    std::string x_label, y_label;
    std::vector<ChartSeries> series;
    bool stacked = false;       // series on top of each other, as areas
    bool logarithmic = false;   // y; all values above 0
    std::optional<double> y_low, y_high;
};

/// Chart.js's configuration of a line chart over numbers.
nlohmann::ordered_json chart_js(const Chart& chart);

}   // namespace gnomon::bench
