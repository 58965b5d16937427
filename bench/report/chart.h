// SPDX-License-Identifier: Apache-2.0
#pragma once
// Describes a line chart and converts it to the configuration of Chart.js 3.9. report/page.js sets fonts, legend and
// tooltips.

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon::bench {

/// Colours that mean the same in all charts; colour-blind readers can distinguish them.
inline constexpr const char* k_color_off = "#6b7280";       // every ray traced: grey
inline constexpr const char* k_color_paper = "#d55e00";     // the published method: vermilion
inline constexpr const char* k_color_ours = "#0072b2";      // Gnomon's method: blue
inline constexpr const char* k_color_printed = "#7b3294";   // values printed in a paper: purple
inline constexpr const char* k_color_second = "#e69f00";    // a second series of the published method: orange
inline constexpr const char* k_color_third = "#56b4e9";     // a second series of Gnomon's method: sky blue
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
    bool stacked = false;       // series stacked as areas
    bool logarithmic = false;   // logarithmic y axis; all values must be above 0
    std::optional<double> y_low, y_high;
};

/// The configuration of Chart.js for a line chart with a numeric x axis.
nlohmann::ordered_json chart_js(const Chart& chart);

}   // namespace gnomon::bench
