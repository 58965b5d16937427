// SPDX-License-Identifier: Apache-2.0
// --shadow-culling paper and --overlay shadow-states, from the user's side.
#include <algorithm>

#include "frame/state_overlay.h"
#include "io/image/image_file.h"
#include "run_program.h"

namespace gnomon::test {
namespace {

const std::string k_scene = "builtin:kinetic";
using Words = std::vector<std::string>;

Words render(const std::string& out, const Words& more)
{
    Words words{"render", k_scene, "-o", out, "--size", "64x48"};
    words.insert(words.end(), more.begin(), more.end());
    // Bounced light takes most of the time, and no overlay of shadows depends on it.
    if (std::find(words.begin(), words.end(), "--indirect") == words.end())
        words.insert(words.end(), {"--indirect", "off"});
    return words;
}

// The number of pixels of exactly that colour.
std::size_t count_of(const std::filesystem::path& png, const frame::Rgb8& color)
{
    const Image8 image = io::read_image(png);
    std::size_t count = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) count += std::equal(color.begin(), color.end(), image.pixel(x, y));
    return count;
}

TEST(Overlay, SingleImageIsWarmedUp)
{
    const ScratchFolder folder;
    const std::string out = folder / "states.png";
    const Outcome outcome = run(render(out, {"--frame", "1", "--overlay", "shadow-states", "--json"}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json document = outcome.json(), shadow = document["frames"][0]["shadow"];
    EXPECT_EQ(document["frames"].size(), 1u);
    EXPECT_EQ(shadow["rays_wrong"], 0);
    EXPECT_GT(shadow["rays_skipped"].get<int>(), shadow["rays"].get<int>() / 4);
    EXPECT_NE(outcome.err.find("0 of "), std::string::npos) << outcome.err;
    const Image8 image = io::read_image(out);
    EXPECT_EQ(document["width"], image.width);
    EXPECT_EQ(document["height"], image.height);
    EXPECT_GT(image.width, 2 * 64) << "a panel for each light";

    // Without warm-up nothing is known.
    const Outcome cold = run(render(out, {"--frame", "1", "--overlay", "shadow-states", "--warm-up", "0", "--json"}));
    EXPECT_EQ(cold.json()["frames"][0]["shadow"]["rays_skipped"], 0);
}

TEST(Overlay, SingleLightIsOnePanelWithLegend)
{
    const ScratchFolder folder;
    const std::string all = folder / "all.png", one = folder / "one.png";
    ASSERT_EQ(run(render(all, {"--frame", "9", "--overlay", "shadow-states"})).code, 0);
    ASSERT_EQ(run(render(one, {"--frame", "9", "--overlay", "shadow-states", "--overlay-light", "0"})).code, 0);
    const Image8 panel = io::read_image(one), panels = io::read_image(all);
    EXPECT_LT(panel.width, panels.width);
    const Size size{64, 48};
    const frame::PanelPlace at = frame::panel_place(size, 1, 0), first = frame::panel_place(size, 6, 0);
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < 3 * size.width; ++x)
            ASSERT_EQ(panel.pixel(at.left, at.top + y)[x], panels.pixel(first.left, first.top + y)[x]);
    EXPECT_GT(count_of(one, frame::state_color(trace::StateMark::none)), 20u) << "the legend's square at least";
}

TEST(Overlay, PaperCullingCountsAndShowsWrongPixels)
{
    const ScratchFolder folder;
    const std::string out = folder / "{frame:02}.png";
    const Outcome outcome =
        run(render(out, {"--frames", "40-44", "--overlay", "shadow-states", "--shadow-culling", "paper", "--json"}));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json frames = outcome.json()["frames"];
    EXPECT_EQ(frames[0]["shadow"]["rays_wrong"], 0) << "every ray is traced";
    const std::size_t square = count_of(folder / "40.png", frame::k_wrong_color);   // the legend's square
    EXPECT_GT(square, 0u);
    int wrong = 0;
    for (const auto& frame : frames) {
        const int here = frame["shadow"]["rays_wrong"];
        wrong += here;
        const std::size_t glaring = count_of(frame["file"].get<std::string>(), frame::k_wrong_color) - square +
                                    count_of(frame["file"].get<std::string>(), frame::k_wrong_behind_color) - square;
        EXPECT_LE(glaring, static_cast<std::size_t>(here));
        EXPECT_EQ(glaring > 0, here > 0);
    }
    EXPECT_GT(wrong, 0);
    EXPECT_NE(outcome.err.find(std::to_string(wrong) + " of "), std::string::npos) << outcome.err;
}

TEST(Overlay, VideosAreRepeatable)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    const std::string video = folder / "states.mp4";
    const Words words = render(video, {"--frames", "40-43", "--overlay", "shadow-states"});
    ASSERT_EQ(run(words).code, 0);
    const std::string bytes = bytes_of(video);
    ASSERT_EQ(run(words).code, 0);
    EXPECT_EQ(bytes, bytes_of(video));
    EXPECT_EQ(names_in(folder.path()), Words{"states.mp4"});
}

TEST(Overlay, WrongUsageIsOneLine)
{
    const ScratchFolder folder;
    const std::string out = folder / "a.png";
    expect_failure(run(render(out, {"--overlay", "shadow-states", "--shadow-culling", "off"})), 2,
                   "shadow culling off");
    expect_failure(run(render(out, {"--overlay-light", "0"})), 2, "--overlay shadow-states");
    expect_failure(run(render(out, {"--overlay", "shadow-states", "--overlay-light", "6"})), 2, "numbered from 0");
    expect_failure(run(render(out, {"--overlay", "shadow-states", "--lights", "0"})), 2, "has none");
    expect_failure(run({"render", k_scene, "-o", out, "--overlay", "shadow-states", "--size", "30000x8000"}), 2,
                   "--overlay-light");
    expect_failure(run(render(out, {"--overlay", "redrawn"})), 2, "needs the rasteriser");
    expect_failure(run(render(out, {"--overlay", "clusters"})), 2, "quadtree");
    expect_failure(run(render(out, {"--overlay", "clusters", "--indirect", "quadtree", "--overlay-light", "0"})), 2,
                   "--overlay shadow-states");
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(PaperCulling, WarnsThatItIsInexactAndThatChunksMayDiffer)
{
    const ScratchFolder folder;
    const std::string out = folder / "{frame:02}.png";
    const Words paper{"--frames", "40-45", "--shadow-culling", "paper"};
    const auto with = [&](Words more) {
        more.insert(more.begin(), paper.begin(), paper.end());
        return run(render(out, more));
    };
    const Outcome whole = with({});
    ASSERT_EQ(whole.code, 0) << whole.err;
    EXPECT_NE(whole.err.find("warning: --shadow-culling paper is approximate"), std::string::npos) << whole.err;
    EXPECT_EQ(whole.err.find("--chunk"), std::string::npos) << whole.err;
    const std::string last = bytes_of(folder / "45.png");

    // A chunk starts without history, and the program warns about it.
    const Outcome part = with({"--chunk", "2/2"});
    ASSERT_EQ(part.code, 0) << part.err;
    EXPECT_NE(part.err.find("images can differ"), std::string::npos) << part.err;
    EXPECT_NE(bytes_of(folder / "45.png"), last);
    // With its history it is the same again.
    ASSERT_EQ(with({"--chunk", "2/2", "--warm-up", "3"}).code, 0);
    EXPECT_EQ(bytes_of(folder / "45.png"), last);
    ASSERT_EQ(with({"--threads", "3"}).code, 0);
    EXPECT_EQ(bytes_of(folder / "45.png"), last);
    EXPECT_EQ(with({"--quiet"}).err, "");
}

// Frames with another history are never reused.
TEST(PaperCulling, DoesNotResumeAVideoWithAnotherHistory)
{
    const ScratchFolder folder;
    const std::string video = folder / "a.mp4";
    ASSERT_EQ(run(render(video, {"--frames", "40-43", "--chunk", "1/2"})).code, 0);
    for (const Words& other : {Words{"--shadow-culling", "paper"}, Words{"--overlay", "shadow-states"}}) {
        Words words = render(video, {"--frames", "40-43", "--chunk", "2/2"});
        words.insert(words.end(), other.begin(), other.end());
        expect_failure(run(words), 2, "a.mp4.frames");
    }
    EXPECT_EQ(run(render(video, {"--frames", "40-43", "--chunk", "2/2", "--shadow-culling", "off"})).code, 0);
}

}   // namespace
}   // namespace gnomon::test
