// SPDX-License-Identifier: Apache-2.0
// A report page in a browser: Chromium, headless and offline, must open it without errors and draw all of it, and its
// comparisons must respond to mouse and keyboard (look_at_page.py).
#include <cstdio>
#include <map>

#include "run_program.h"

namespace gnomon::test {
namespace {

#define NEED_CHROMIUM                                            \
    if (std::system("command -v chromium >/dev/null 2>&1") != 0) \
    GTEST_SKIP() << "no chromium on this machine: install the Debian package chromium"

std::size_t times(const std::string& text, const std::string& word)
{
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

// The content and behaviour of a page, from look_at_page.py.
nlohmann::json look_at(const std::filesystem::path& page)
{
    const ScratchFolder folder;
    const std::string out = folder / "out", err = folder / "err";
    const std::string command = "PYTHONDONTWRITEBYTECODE=1 timeout 240 python3 " + places::source_folder +
                                "/tests/cli/look_at_page.py '" + page.string() + "' >'" + out + "' 2>'" + err + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << bytes_of(err);
    return nlohmann::json::parse(bytes_of(out), nullptr, false);
}

// A comparison shows its left image up to the slider: after a drag of the slider, a key press, and a drag over the
// images; and it shows the difference after a click.
void expect_comparison_moves(const nlohmann::json& seen, int width)
{
    SCOPED_TRACE(seen.dump());
    const auto expect_at = [&](const char* when, double low, double high) {
        const nlohmann::json& now = seen[when];
        const double value = now["value"];
        EXPECT_GE(value, low) << when;
        EXPECT_LE(value, high) << when;
        double hidden = -1, handle = -1;
        EXPECT_EQ(std::sscanf(now["clip"].get<std::string>().c_str(), "inset(0px %lf%% 0px 0px)", &hidden), 1);
        EXPECT_EQ(std::sscanf(now["handle"].get<std::string>().c_str(), "%lf%%", &handle), 1);
        EXPECT_NEAR(100 - hidden, value, 0.3) << when;   // the slider moves in whole steps, the images do not
        EXPECT_NEAR(handle, value, 0.3) << when;
        return value;
    };
    expect_at("start", 50, 50);
    const double dragged = expect_at("dragged", 20, 30);
    EXPECT_EQ(seen["dragged"]["focused"], true);
    expect_at("key", dragged + 0.1, dragged + 2);
    expect_at("image", 79, 81);
    EXPECT_EQ(seen["image"]["difference"], "none");
    EXPECT_EQ(seen["difference"]["difference"], "block");
    EXPECT_EQ(seen["start"]["sizes"], (nlohmann::json{width, width, width}));
}

TEST(Report, CullingReportOpensInABrowser)
{
    NEED_CHROMIUM;
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "culling", "builtin:cornell", "--frames", "3-8", "--size", "64x48", "--json",
                                 "--report", folder / "new/report"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(names_in(folder / "new/report"), std::vector<std::string>{"index.html"});
    const nlohmann::json found = look_at(folder / "new/report/index.html");
    ASSERT_TRUE(found.is_object());
    EXPECT_EQ(found["faults"], nlohmann::json::array());

    // Nodes, tests, saved, extra tests, saved by both, time, speed, rays, certificates, rays of the paper, wrong.
    EXPECT_EQ(found["charts"].size(), 11u);
    for (const nlohmann::json& chart : found["charts"]) {
        SCOPED_TRACE(chart.dump());
        EXPECT_GT(chart["width"].get<int>(), 300);
        EXPECT_GT(chart["drawn"].get<int>(), 5000);
        EXPECT_GT(chart["colors"].get<int>(), 2);   // axes, text, lines
        EXPECT_GT(chart["lines"].get<int>(), 0);
        EXPECT_EQ(chart["points"], 6);
        EXPECT_FALSE(chart["title"].get<std::string>().empty());
        EXPECT_FALSE(chart["tick"].get<std::string>().empty());
    }
    ASSERT_EQ(found["images"].size(), 1u);
    expect_comparison_moves(found["images"][0], 64);
    ASSERT_EQ(found["downloads"].size(), 1u);
    EXPECT_EQ(found["downloads"][0]["blob"], true);
    EXPECT_EQ(nlohmann::json::parse(found["downloads"][0]["text"].get<std::string>()), outcome.json());
}

// Without this, a page that is never looked at would have no faults.
TEST(Report, FaultsOfAPageAreSeen)
{
    NEED_CHROMIUM;
    const ScratchFolder folder;
    ASSERT_EQ(run({"bench", "culling", "builtin:cornell", "--frames", "1-3", "--size", "24x16", "--report",
                   folder / "report"})
                  .code,
              0);
    std::ofstream(folder / "report/index.html", std::ios::app)
        << "<script>console.error('a complaint')</script><script>no_such_function()</script>"
           "<img src=\"https://example.org/a.png\">";
    const nlohmann::json found = look_at(folder / "report/index.html");
    ASSERT_TRUE(found.is_object());
    const std::string faults = found["faults"].dump();
    EXPECT_NE(faults.find("a complaint"), std::string::npos) << faults;
    EXPECT_NE(faults.find("no_such_function"), std::string::npos) << faults;
    EXPECT_GE(found["faults"].size(), 3u) << faults;
}

TEST(Report, ShowsPublishedValuesAndTheCommand)
{
    const ScratchFolder folder;
    ASSERT_EQ(
        run({"bench", "culling", "builtin:cornell", "--frames", "1-3", "--size", "24x16", "--report", folder / "a b"})
            .code,
        0);
    const std::string html = bytes_of(folder / "a b/index.html");
    for (const char* printed : {">19.8<", ">59.5 (frame 20)<", ">24.5<", ">59.8 (frame 19)<", ">0.173<", ">7.4<",
                                ">19.5 (frame 31)<", ">9.5<", ">29.6 (frame 41)<", ">0.149<"})
        EXPECT_GE(times(html, printed), 1u) << printed;
    const std::string command = "<code>gnomon bench culling builtin:cornell --frames 1-3 --size 24x16 --report '";
    EXPECT_GT(times(html, "<figure "), 10u);
    EXPECT_EQ(times(html, "<figure "), times(html, command)) << "a name with a space is quoted";
}

// The frames of every method show the time of each stage; the last method has two charts, stacked times and fractions
// of work.
void expect_frames_by_stage(const nlohmann::json& ways, const nlohmann::json& charts)
{
    ASSERT_EQ(ways.size(), 5u);
    for (const nlohmann::json& way : ways) {
        SCOPED_TRACE(way.dump());
        ASSERT_EQ(way["frames"].size(), 6u);
        for (const nlohmann::json& frame : way["frames"]) {
            EXPECT_EQ(frame["stages"].size(), 9u);
            double sum = 0;
            for (const auto& [name, ms] : frame["stages"].items()) sum += ms.get<double>();
            EXPECT_GT(frame["stages"]["rays"].get<double>(), 0);
            EXPECT_LE(sum, 1.001 * frame["ms"].get<double>());
        }
        const bool certified = way["shadow_culling"] == "certified", bounced = way["indirect"] == "visible";
        EXPECT_EQ(way["not_done_percent"]["shadow_rays_skipped"].get<double>() > 50, certified);
        EXPECT_EQ(way["not_done_percent"]["indirect_rays"].get<double>() > 50, bounced);
        EXPECT_EQ(way["frames"][1]["stages"]["indirect"].get<double>() > 1, bounced);
    }
    std::map<std::string, nlohmann::json> by_title;
    for (const nlohmann::json& chart : charts) by_title[chart["title"]] = chart;
    const std::string way = ": certified shadows, indirect light, 2 threads";
    ASSERT_TRUE(by_title.count("Time by stage" + way)) << charts;
    ASSERT_TRUE(by_title.count("Work saved by caching" + way)) << charts;
    EXPECT_GE(by_title["Time by stage" + way]["lines"], 7);
    EXPECT_GE(by_title["Time by stage" + way]["colors"], 8);
    EXPECT_EQ(by_title["Time by stage" + way]["points"], 5) << "the caches of the first frame are empty";
    EXPECT_EQ(by_title["Work saved by caching" + way]["lines"], 3);
    EXPECT_EQ(by_title["Work saved by caching" + way]["points"], 5);
}

// Without the papers' scenes a built-in one replaces them, and the page says so.
TEST(Report, FullReportOpensInABrowser)
{
    NEED_CHROMIUM;
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "all", "--quick", "--threads", "2", "--report", folder / "page", "--json"},
                                {{"GNOMON_SCENES", folder / "none"}});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("1 of "), std::string::npos) << "reports its progress";
    const nlohmann::json found = look_at(folder / "page/index.html");
    ASSERT_TRUE(found.is_object());
    EXPECT_EQ(found["faults"], nlohmann::json::array());
    EXPECT_GE(found["charts"].size(), 12u);
    for (const nlohmann::json& chart : found["charts"]) EXPECT_GT(chart["drawn"].get<int>(), 5000) << chart;
    // Wrong results, shadows, indirect light; seven of its methods; shadow textures as printed.
    ASSERT_EQ(found["images"].size(), 11u);
    for (const nlohmann::json& image : found["images"]) expect_comparison_moves(image, 256);

    const nlohmann::json document = outcome.json();
    EXPECT_EQ(document["quick"], true);
    EXPECT_EQ(document["culling"][0]["summary"]["certified"]["wrong_total"], 0);
    expect_frames_by_stage(document["frames"], found["charts"]);
    EXPECT_EQ(nlohmann::json::parse(found["downloads"].back()["text"].get<std::string>()), document);
    const std::string html = bytes_of(folder / "page/index.html");
    EXPECT_EQ(times(html, "BART's Kitchen was not found"), 2u) << "at the top, and in the data";
    EXPECT_LT(html.find("BART's Kitchen was not found"), html.find("The most important results."));
    EXPECT_EQ(times(html, "Figure 6 of the paper"), 1u);
    EXPECT_EQ(times(html, "cached since the first of these frames. The images are identical."), 1u);
    EXPECT_EQ(times(html, "<section "), times(html, "<li>"));
    // Every figure names the command that measured it.
    EXPECT_EQ(times(html, "<figure "), times(html, "<code>gnomon bench ") + times(html, "<code>gnomon render "));
}

TEST(Report, IsRemovedOnFailure)
{
    const ScratchFolder folder;
    expect_failure(run({"bench", "culling", "builtin:cornell", "--frames", "1-99", "--report", folder / "r"}), 2, "99");
    EXPECT_TRUE(names_in(folder.path()).empty());
    std::ofstream(folder / "file") << "x";
    expect_failure(run({"bench", "culling", "builtin:cornell", "--report", folder / "file"}), 4, "file");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});

    RunningProgram program({"bench", "culling", "builtin:kinetic", "--frames", "1-100", "--size", "160x120",
                            "--no-counts", "--report", folder / "r"});
    ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "r"); }));
    program.send(SIGINT);
    EXPECT_EQ(program.wait().code, 130);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});
}

}   // namespace
}   // namespace gnomon::test
