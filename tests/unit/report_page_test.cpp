// SPDX-License-Identifier: Apache-2.0
// Report pages as text: complete and escaped. tests/cli/report_test.cpp opens one in a browser.
#include "bench/report/page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/report/stage_figures.h"
#include "gnomon/error.h"
#include "support.h"

namespace gnomon::bench {
namespace {

using Json = nlohmann::ordered_json;

std::size_t times(const std::string& text, const std::string& word)
{
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

TEST(Chart, WritesSeriesAsLines)
{
    Chart chart;
    chart.title = "T", chart.x_label = "frame";
    chart.series.push_back({"a", {{3, 1.5}, {7, 2}}, k_color_ours, ChartSeries::Style::line});
    chart.series.push_back({"b", {{5, 4}}, k_color_printed, ChartSeries::Style::points});
    const Json json = chart_js(chart);
    EXPECT_EQ(json["type"], "line");
    EXPECT_EQ(json["options"]["scales"]["x"]["min"], 3);
    EXPECT_EQ(json["options"]["scales"]["x"]["max"], 7);
    ASSERT_EQ(json["data"]["datasets"].size(), 2u);
    EXPECT_EQ(json["data"]["datasets"][0]["data"][0], (Json{{"x", 3.0}, {"y", 1.5}}));
    EXPECT_EQ(json["data"]["datasets"][0]["showLine"], true);
    EXPECT_EQ(json["data"]["datasets"][1]["showLine"], false);
}

// Two frames after a first one with empty caches.
WayWork three_frames()
{
    WayWork way{"w", std::vector<FrameWork>(3)};
    for (std::size_t i = 0; i < 3; ++i) {
        FrameWork& frame = way.frames[i];
        frame.ms = i == 0 ? 100 : 10;
        frame.times.ms[FrameTimes::rays] = i == 0 ? 70 : 3;
        frame.times.ms[FrameTimes::indirect_mirrored] = i == 2 ? 4 : 0;
        frame.shadow.rays = 1000;
        frame.shadow.rays_skipped = i == 0 ? 0u : 750u;
        frame.shadow.rays_dynamic_only = i == 2 ? 100u : 0u;
        frame.indirect.rays = i == 0 ? 400 : i == 1 ? 100 : 500;
    }
    return way;
}

TEST(StageFigures, ShowTimeByStage)
{
    const ReportTable table = stage_table({three_frames()});
    EXPECT_EQ(table.columns, (std::vector<std::string>{"", "w"}));
    ASSERT_EQ(table.rows.size(), 3u) << "stages without time are left out";
    EXPECT_EQ(table.rows[0].cells, (std::vector<std::string>{"rays", "3.0"}));
    EXPECT_EQ(table.rows[1].cells, (std::vector<std::string>{"indirect mirrored", "4.0"}));
    EXPECT_EQ(table.rows[2].cells, (std::vector<std::string>{"whole frame", "10.0"}));
    const Chart chart = stage_chart(three_frames(), 7);
    EXPECT_TRUE(chart.stacked);
    ASSERT_EQ(chart.series.size(), 2u);
    EXPECT_EQ(chart.series[1].name, "indirect mirrored");
    EXPECT_EQ(chart.series[1].points, (std::vector<std::pair<double, double>>{{8, 0}, {9, 4}}));
    const Json json = work_json(three_frames().frames, 7);
    EXPECT_EQ(json[2]["frame"], 9);
    EXPECT_EQ(json[2]["stages"]["indirect_mirrored"], 4.0);
    EXPECT_EQ(json[2]["shadow"], (Json{{"rays", 1000}, {"rays_skipped", 750}, {"rays_dynamic_only", 100}}));
}

TEST(StageFigures, ShowSavedWork)
{
    const WayWork way = three_frames();
    const SavedWork saved = saved_of(way);
    EXPECT_EQ(saved.shadow_skipped, 75);
    EXPECT_EQ(saved.shadow_dynamic_only, 5);
    EXPECT_EQ(saved.indirect, 25) << "600 rays in two frames, where the first cast 400";
    EXPECT_EQ(saved_of(way.frames[1], way.frames[0]).indirect, 75);
    EXPECT_EQ(saved_of(way.frames[2], way.frames[0]).indirect, 0) << "more than the first: nothing saved";
    EXPECT_EQ(saved_of(FrameWork{}, FrameWork{}).shadow_skipped, 0) << "no work, nothing saved";
    const Chart chart = saved_chart(way, 7);
    ASSERT_EQ(chart.series.size(), 3u);
    EXPECT_EQ(chart.series[1].points, (std::vector<std::pair<double, double>>{{8, 0}, {9, 10}}));
}

TEST(ReportPage, NamesMachineAndCommandUnderEveryFigure)
{
    ReportPage page("Title", "a machine");
    page.section("One", "gnomon one");
    page.table({"numbers", {"", "x"}, {{{"row", "1"}, false}, {{"row", "2"}, true}}});
    page.chart({}, "first chart");
    page.section("Two", "gnomon two");
    page.comparison({"images", "a", "b", Image8(2, 2, 3), Image8(2, 2, 3), Image8(2, 2, 3)});
    const std::string html = page.html();
    EXPECT_EQ(times(html, "<figure "), 3u);
    EXPECT_EQ(times(html, "<figcaption>"), 3u);
    EXPECT_EQ(times(html, "a machine"), 4u);   // and in the head
    EXPECT_EQ(times(html, "<code>gnomon one</code>"), 2u);
    EXPECT_EQ(times(html, "<code>gnomon two</code>"), 1u);
    EXPECT_EQ(times(html, "<section "), 2u);
    EXPECT_EQ(times(html, "</section>"), 2u);
    EXPECT_EQ(times(html, "data:image/png;base64,iVBORw0KGgo"), 3u);
}

TEST(ReportPage, StartsWithSummaryTableAndListOfSections)
{
    ReportPage page("Title", "a machine");
    page.section("First", "gnomon one");
    EXPECT_EQ(times(page.html(), "<nav>"), 0u);
    page.section("Second", "gnomon two");
    page.lead({"most important", {""}, {{{"row"}, false}}}, "gnomon all");
    const std::string html = page.html();
    EXPECT_EQ(times(html, "<li>"), 2u);
    EXPECT_EQ(times(html, "href=\"#section-2\">Second<"), 1u);
    EXPECT_LT(html.find("most important"), html.find("<nav>"));
    EXPECT_LT(html.find("<nav>"), html.find("<h2>First"));
    EXPECT_EQ(times(html, "<code>gnomon all</code>"), 1u);
}

TEST(ReportPage, EscapesMarkup)
{
    const std::string evil = "</script><script>alert('x')</script>&\"";
    ReportPage page(evil, evil);
    page.section(evil, evil);
    page.text(evil);
    page.table({evil, {evil}, {{{evil}, false}}});
    Chart chart;
    chart.title = evil;
    chart.series.push_back({evil, {{1, 2}}, k_color_off, ChartSeries::Style::line});
    page.chart(chart, evil);
    page.attach(evil, {{evil, evil}});
    const std::string html = page.html();
    EXPECT_EQ(times(html, "alert("), times(html, "script>alert(") + times(html, "script&gt;alert("));
    EXPECT_EQ(times(html, "<script>alert("), 0u);
    EXPECT_EQ(times(html, "</script>"), 4u);   // the chart, the attachment, Chart.js and our own script
}

TEST(ReportPage, LoadsNoExternalResources)
{
    ReportPage page("t", "m");
    page.section("s", "c");
    page.chart({}, "");
    page.comparison({"p", "a", "b", Image8(1, 1, 3), Image8(1, 1, 3), {}});
    std::string html = page.html();
    for (const char* outside : {"src=\"http", "href=\"http", "src=\"//", "@import", "url(http"})
        EXPECT_EQ(times(html, outside), 0u) << outside;
}

TEST(ReportFile, IsCompleteOrAbsent)
{
    const test::ScratchFolder scratch;
    const auto folder = scratch / "a/b/c";
    {
        ReportFile file(folder);
        EXPECT_TRUE(std::filesystem::exists(folder));
    }
    EXPECT_FALSE(std::filesystem::exists(scratch / "a")) << "its folder is removed with it";
    {
        ReportFile file(folder);
        file.write(ReportPage("t", "m"));
    }
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "index.html"));
    const auto size = std::filesystem::file_size(folder / "index.html");
    EXPECT_EQ(size, ReportPage("t", "m").html().size());
    {
        const ReportFile abandoned(folder);
    }
    EXPECT_EQ(std::filesystem::file_size(folder / "index.html"), size) << "an older page is kept";
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST(ReportFile, NamesAFolderThatCannotBeCreated)
{
    const test::ScratchFolder scratch;
    std::ofstream(scratch / "file") << "x";
    EXPECT_THROW(ReportFile(scratch / "file/below"), MissingError);
    EXPECT_THROW(ReportFile(scratch / "file"), MissingError);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

}   // namespace
}   // namespace gnomon::bench
