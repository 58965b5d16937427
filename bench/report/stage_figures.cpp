// SPDX-License-Identifier: Apache-2.0
#include "bench/report/stage_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace gnomon::bench {

namespace {
using Json = nlohmann::ordered_json;

// One colour per stage; neighbours differ in lightness, too.
constexpr std::array<const char*, FrameTimes::k_stages> k_stage_colors{k_color_off,  k_color_printed, k_color_third,
                                                                       k_color_ours, k_color_second,  k_color_fourth,
                                                                       "#8fd19e",    "#cc79a7",       "#b0b0b0"};

std::string words(std::string name)
{
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

bool spent(const WayWork& way, std::size_t stage)
{
    return std::any_of(way.frames.begin(), way.frames.end(),
                       [stage](const FrameWork& frame) { return frame.times.ms[stage] > 0; });
}

double percent(std::uint64_t part, std::uint64_t whole)
{
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

// The first frame with filled caches; the only frame if there is just one.
std::size_t first_steady(const WayWork& way)
{
    return way.frames.size() > 1 ? 1 : 0;
}

ChartSeries series_of(const WayWork& way, int first_frame, const std::string& name, const char* color,
                      const std::function<double(const FrameWork&)>& value)
{
    ChartSeries series{name, {}, color, ChartSeries::Style::line};
    for (std::size_t i = first_steady(way); i < way.frames.size(); ++i)
        series.points.emplace_back(first_frame + static_cast<double>(i), value(way.frames[i]));
    return series;
}
}   // namespace

double steady_median(const WayWork& way, const std::function<double(const FrameWork&)>& value)
{
    std::vector<double> values;
    for (std::size_t i = first_steady(way); i < way.frames.size(); ++i) values.push_back(value(way.frames[i]));
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

FrameWork work_of(const Frame& image)
{
    return {image.milliseconds, image.times, image.counters.shadow, image.counters.indirect};
}

ReportTable stage_table(const std::vector<WayWork>& ways)
{
    ReportTable table;
    table.caption =
        "Time by stage in milliseconds, medians from the second frame on. The time of a stage that runs on several "
        "threads is the sum over the threads divided by their number. The rest of the whole frame is time in which "
        "threads wait for each other.";
    table.columns = {""};
    for (const WayWork& way : ways) table.columns.push_back(way.name);
    const auto add = [&](const std::string& name, const std::function<double(const FrameWork&)>& value) {
        std::vector<std::string> cells{name};
        for (const WayWork& way : ways) cells.push_back(fmt::format("{:.1f}", steady_median(way, value)));
        table.rows.push_back({std::move(cells), false});
    };
    for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
        if (std::any_of(ways.begin(), ways.end(), [stage](const WayWork& way) { return spent(way, stage); }))
            add(words(FrameTimes::k_names[stage]), [stage](const FrameWork& frame) { return frame.times.ms[stage]; });
    add("whole frame", [](const FrameWork& frame) { return frame.ms; });
    return table;
}

Chart stage_chart(const WayWork& way, int first_frame)
{
    Chart chart{"Time by stage: " + way.name, "frame", "ms", {}, true, {}, {}, {}};
    for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
        if (spent(way, stage))
            chart.series.push_back(series_of(way, first_frame, words(FrameTimes::k_names[stage]), k_stage_colors[stage],
                                             [stage](const FrameWork& frame) { return frame.times.ms[stage]; }));
    return chart;
}

Chart saved_chart(const WayWork& way, int first_frame)
{
    Chart chart{"Work saved by caching: " + way.name, "frame", "%", {}, {}, {}, 0.0, 100.0};
    const auto add = [&](const char* name, const char* color, double SavedWork::*percentage) {
        chart.series.push_back(series_of(way, first_frame, name, color, [&way, percentage](const FrameWork& frame) {
            return saved_of(frame, way.frames.front()).*percentage;
        }));
    };
    add("shadow rays culled", k_color_ours, &SavedWork::shadow_skipped);
    add("shadow rays traced against dynamic objects only", k_color_third, &SavedWork::shadow_dynamic_only);
    add("indirect rays saved in comparison with the first frame", k_color_fourth, &SavedWork::indirect);
    return chart;
}

SavedWork saved_of(const FrameWork& frame, const FrameWork& first)
{
    const std::uint64_t rays = std::min(frame.indirect.rays, first.indirect.rays);
    return {percent(frame.shadow.rays_skipped, frame.shadow.rays),
            percent(frame.shadow.rays_dynamic_only, frame.shadow.rays),
            percent(first.indirect.rays - rays, first.indirect.rays)};
}

SavedWork saved_of(const WayWork& way)
{
    FrameWork sum, firsts;
    for (std::size_t i = first_steady(way); i < way.frames.size(); ++i) {
        const FrameWork& frame = way.frames[i];
        sum.shadow.rays += frame.shadow.rays;
        sum.shadow.rays_skipped += frame.shadow.rays_skipped;
        sum.shadow.rays_dynamic_only += frame.shadow.rays_dynamic_only;
        sum.indirect.rays += frame.indirect.rays;
        firsts.indirect.rays += way.frames.front().indirect.rays;
    }
    return saved_of(sum, firsts);
}

Json stages_json(const FrameTimes& times)
{
    Json json = Json::object();
    for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
        json[FrameTimes::k_names[stage]] = times.ms[stage];
    return json;
}

Json work_json(const std::vector<FrameWork>& frames, int first_frame)
{
    Json list = Json::array();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const FrameWork& frame = frames[i];
        list.push_back({{"frame", first_frame + static_cast<int>(i)},
                        {"ms", frame.ms},
                        {"stages", stages_json(frame.times)},
                        {"shadow",
                         {{"rays", frame.shadow.rays},
                          {"rays_skipped", frame.shadow.rays_skipped},
                          {"rays_dynamic_only", frame.shadow.rays_dynamic_only}}},
                        {"indirect", {{"clusters", frame.indirect.clusters}, {"rays", frame.indirect.rays}}}});
    }
    return list;
}

}   // namespace gnomon::bench
