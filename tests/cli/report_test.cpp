// SPDX-License-Identifier: Apache-2.0
// A report page in a browser: Chromium, headless and without a network, must open it without a complaint and draw all
// of it.
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

// Listens from the start, looks when all is drawn, and leaves what it found in an element of its own.
constexpr const char* k_listen = R"(<script>
window.faults = [];
window.addEventListener('error', event => faults.push(event.message));
console.error = console.warn = (...words) => faults.push(words.join(' '));
</script>)";
constexpr const char* k_look = R"(<script>
const found = {faults: window.faults, charts: [], pictures: [], downloads: []};
for (const canvas of document.querySelectorAll('canvas')) {
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  const colors = new Set();
  let drawn = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] === 0) continue;
    ++drawn;
    if (data[i + 3] === 255) colors.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
  }
  const chart = Chart.getChart(canvas);
  found.charts.push({drawn, width: canvas.width, colors: colors.size, title: chart.options.plugins.title.text,
    lines: chart.data.datasets.length, points: chart.data.datasets[0].data.length,
    tick: chart.scales.y.ticks[0].label});
}
for (const figure of document.querySelectorAll('figure.pictures')) {
  const range = figure.querySelector('input[type=range]');
  range.value = 25;
  range.dispatchEvent(new Event('input'));
  const box = figure.querySelector('.show-difference');
  box.click();
  found.pictures.push({clip: figure.querySelector('.left').style.clipPath,
    sizes: [...figure.querySelectorAll('img')].map(image => image.naturalWidth),
    different: getComputedStyle(figure.querySelector('img.difference')).display});
}
for (const data of document.querySelectorAll('script.attachment')) {
  const link = document.getElementById(data.dataset.link);
  found.downloads.push({name: link.download, blob: link.href.startsWith('blob:'), text: data.textContent});
}
const result = document.createElement('pre');
result.id = 'found';
result.textContent = 'FOUND' + btoa(unescape(encodeURIComponent(JSON.stringify(found)))) + 'END';
document.body.append(result);
</script>)";

std::string from_base64(const std::string& text)
{
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (const char c : text) {
        const std::size_t value = letters.find(c);
        if (value == std::string::npos) break;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
    }
    return bytes;
}

// Opens a page with eyes in it; what they saw, and in `complaints` what the browser had to say.
nlohmann::json look_at(const std::filesystem::path& page, std::string& complaints)
{
    const ScratchFolder folder;
    std::string html = bytes_of(page);
    const std::string head = "<head>";
    html.insert(html.find(head) + head.size(), k_listen);
    html.insert(html.rfind("</body>"), k_look);
    std::ofstream(folder / "page.html", std::ios::binary) << html;
    const std::string dom = folder / "dom", err = folder / "err";
    const std::string command =
        "timeout 120 chromium --headless --no-sandbox --disable-gpu --no-first-run --window-size=1100,900 "
        "--host-resolver-rules='MAP * ~NOTFOUND' --virtual-time-budget=10000 --enable-logging=stderr "
        "--user-data-dir='" +
        (folder / "profile").string() + "' --dump-dom 'file://" + (folder / "page.html").string() + "' >'" + dom +
        "' 2>'" + err + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << bytes_of(err);
    std::istringstream lines(bytes_of(err));
    for (std::string line; std::getline(lines, line);)
        if (line.find("CONSOLE") != std::string::npos) complaints += line + "\n";
    const std::string text = bytes_of(dom);
    const std::size_t begin = text.find("FOUND", text.find("id=\"found\"")), end = text.find("END", begin);
    if (begin == std::string::npos || end == std::string::npos) {
        ADD_FAILURE() << "the page's scripts did not run to their end: " << bytes_of(err);
        return {};
    }
    return nlohmann::json::parse(from_base64(text.substr(begin + 5, end - begin - 5)));
}

TEST(Report, OfCullingOpensInABrowser)
{
    NEED_CHROMIUM;
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "culling", "builtin:cornell", "--frames", "3-8", "--size", "64x48", "--json",
                                 "--report", folder / "new/report"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(names_in(folder / "new/report"), std::vector<std::string>{"index.html"});
    std::string complaints;
    const nlohmann::json found = look_at(folder / "new/report/index.html", complaints);
    EXPECT_EQ(complaints, "");
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
    ASSERT_EQ(found["pictures"].size(), 1u);
    EXPECT_EQ(found["pictures"][0]["clip"], "inset(0px 75% 0px 0px)");
    EXPECT_EQ(found["pictures"][0]["sizes"], (nlohmann::json{64, 64, 64}));
    EXPECT_EQ(found["pictures"][0]["different"], "block");
    ASSERT_EQ(found["downloads"].size(), 1u);
    EXPECT_EQ(found["downloads"][0]["blob"], true);
    EXPECT_EQ(nlohmann::json::parse(found["downloads"][0]["text"].get<std::string>()), outcome.json());
}

TEST(Report, ShowsThePapersValuesAndTheCommand)
{
    const ScratchFolder folder;
    ASSERT_EQ(
        run({"bench", "culling", "builtin:cornell", "--frames", "1-3", "--size", "24x16", "--report", folder / "a b"})
            .code,
        0);
    const std::string html = bytes_of(folder / "a b/index.html");
    for (const char* printed : {">19.8<", ">59.5 (frame 20)<", ">24.5<", ">59.8 (frame 19)<", ">0.173<", ">7.4<",
                                ">19.5 (frame 31)<", ">9.5<", ">29.6 (frame 41)<", ">0.149<"})
        EXPECT_EQ(times(html, printed), 1u) << printed;
    const std::string command = "<code>gnomon bench culling builtin:cornell --frames 1-3 --size 24x16 --report '";
    EXPECT_GT(times(html, "<figure "), 10u);
    EXPECT_EQ(times(html, "<figure "), times(html, command)) << "a name with a blank is quoted";
}

// Without the papers' scenes a built-in one stands in, and the page says so.
TEST(Report, OfEverythingOpensInABrowser)
{
    NEED_CHROMIUM;
    const ScratchFolder folder;
    const Outcome outcome = run({"bench", "all", "--quick", "--threads", "2", "--report", folder / "page", "--json"},
                                {{"GNOMON_SCENES", folder / "none"}});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("1 of 6: "), std::string::npos) << "says what it is doing";
    std::string complaints;
    const nlohmann::json found = look_at(folder / "page/index.html", complaints);
    EXPECT_EQ(complaints, "");
    ASSERT_TRUE(found.is_object());
    EXPECT_EQ(found["faults"], nlohmann::json::array());
    EXPECT_GE(found["charts"].size(), 12u);
    for (const nlohmann::json& chart : found["charts"]) EXPECT_GT(chart["drawn"].get<int>(), 5000) << chart;
    ASSERT_EQ(found["pictures"].size(), 10u);   // wrong results, shadows, indirect light; seven of its methods
    for (const nlohmann::json& picture : found["pictures"]) {
        EXPECT_EQ(picture["clip"], "inset(0px 75% 0px 0px)");
        EXPECT_EQ(picture["sizes"], (nlohmann::json{256, 256, 256}));
        EXPECT_EQ(picture["different"], "block");
    }

    const nlohmann::json document = outcome.json();
    EXPECT_EQ(document["quick"], true);
    EXPECT_EQ(document["culling"][0]["summary"]["certified"]["wrong_total"], 0);
    EXPECT_EQ(document["frames"].size(), 5u);
    EXPECT_EQ(nlohmann::json::parse(found["downloads"].back()["text"].get<std::string>()), document);
    const std::string html = bytes_of(folder / "page/index.html");
    EXPECT_EQ(times(html, "BART's Kitchen is not there"), 1u);
    EXPECT_EQ(times(html, "remembered since the first of these frames. Not a pixel differs."), 1u);
    EXPECT_EQ(times(html, "<section "), times(html, "<li>"));
    // Every figure names what measured it.
    EXPECT_EQ(times(html, "<figure "), times(html, "<code>gnomon bench ") + times(html, "<code>gnomon render "));
}

TEST(Report, IsNotLeftBehindByAFailure)
{
    const ScratchFolder folder;
    expect_failure(run({"bench", "culling", "builtin:cornell", "--frames", "1-99", "--report", folder / "r"}), 2, "99");
    EXPECT_TRUE(names_in(folder.path()).empty());
    std::ofstream(folder / "file") << "x";
    expect_failure(run({"bench", "culling", "builtin:cornell", "--report", folder / "file"}), 4, "file");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});

    RunningProgram program(
        {"bench", "culling", "builtin:kinetic", "--frames", "1-100", "--no-counts", "--report", folder / "r"});
    ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "r"); }));
    program.send(SIGINT);
    EXPECT_EQ(program.wait().code, 130);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});
}

}   // namespace
}   // namespace gnomon::test
