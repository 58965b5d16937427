// SPDX-License-Identifier: Apache-2.0
// Errors from the system: exit codes 3 and 4, one line, and no file left. (Tests may run as root, who has all
// permissions: paths below a file or in /proc are refused for everyone.)
#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;
const std::string k_scene = "builtin:cornell";

TEST(SystemErrors, UnwritableFolder)
{
    const ScratchFolder folder;
    std::ofstream(folder / "file") << "x";
    for (const std::string& out :
         {(folder / "missing/a.png").string(), (folder / "file/a.png").string(), std::string("/proc/a.png")})
        expect_failure(run({"render", k_scene, "-o", out, "--size", "8x8"}), 4, "cannot write");
    expect_failure(run({"render", k_scene, "-o", folder / "file/{frame}.png", "--size", "8x8"}), 4,
                   "cannot make the folder");
    expect_failure(run({"render", k_scene, "-o", folder / "a.png", "--contact-sheet", "/proc/b.png"}), 4,
                   "/proc/b.png");
    expect_failure(run({"info", k_scene, "--json=" + (folder / "missing/a.json").string()}), 4, "cannot write");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});
}

TEST(SystemErrors, UnwritableFolderForVideo)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    expect_failure(run({"render", k_scene, "-o", "/proc/a.mp4", "--size", "8x8"}), 4, "/proc/a.mp4");
}

TEST(SystemErrors, MissingFfmpegIsFoundBeforeRendering)
{
    const ScratchFolder folder;
    expect_failure(run({"render", k_scene, "-o", folder / "a.mp4"}, {{"PATH", "/nonexistent"}}), 4, "ffmpeg");
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(SystemErrors, MissingScene)
{
    const ScratchFolder folder;
    expect_failure(run({"info", folder / "no.aff"}), 3, "no.aff");
    expect_failure(run({"render", folder / "no.aff", "-o", folder / "a.png"}), 3, "no.aff");
    std::ofstream(folder / "bad.aff") << "v\n";
    expect_failure(run({"render", folder / "bad.aff", "-o", folder / "a.png"}), 3, "bad.aff");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"bad.aff"});
}

TEST(SystemErrors, FullStandardOutput)
{
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"info", k_scene, "--json", "--quiet"}, {"--help"}, {"devices"}}) {
        const Outcome outcome = RunningProgram(arguments, {}, "/dev/full").wait();
        EXPECT_EQ(outcome.code, 4);
        EXPECT_EQ(outcome.err, "gnomon: cannot write to standard output: No space left on device\n");
    }
}

// A file opened later must not get the descriptor of a closed stream, nor its text.
TEST(SystemErrors, ClosedStandardOutput)
{
    const ScratchFolder folder;
    const fs::path json = folder / "a.json";
    const auto program = [&](const std::vector<std::string>& more) {
        std::vector<std::string> all{"info", k_scene, "--json=" + json.string()};
        all.insert(all.end(), more.begin(), more.end());
        return RunningProgram(all, {}, {}, [] { ::close(STDOUT_FILENO); }).wait();
    };
    EXPECT_EQ(program({}).code, 4);
    EXPECT_FALSE(fs::exists(json));
    EXPECT_EQ(program({"--quiet"}).code, 0);
    EXPECT_EQ(nlohmann::json::parse(bytes_of(json))["frames"], 40);
}

// A parent that ignores SIGCHLD, or has closed descriptors, does not prevent a video.
TEST(VideoOutput, DoesNotDependOnInheritedSignalsAndDescriptors)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    RunningProgram program({"render", k_scene, "-o", folder / "a.mp4", "--size", "8x8", "--frames", "1-2", "--quiet"},
                           {}, {}, [] {
                               ::signal(SIGCHLD, SIG_IGN);
                               ::close(STDIN_FILENO);
                           });
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
}

TEST(ImageOutput, HasTheRequestedSizeAndReplacesTheOldFile)
{
    const ScratchFolder folder;
    std::ofstream(folder / "a.png") << "old";
    const Outcome outcome = run({"render", k_scene, "-o", folder / "a.png", "--size", "33x17", "--quiet"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "");
    const std::string png = bytes_of(folder / "a.png");
    ASSERT_GT(png.size(), 24u);
    EXPECT_EQ(png.substr(16, 8), std::string("\0\0\0\x21\0\0\0\x11", 8));
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.png"});
}

TEST(ImageOutput, SameBytesForAnyThreadCount)
{
    const ScratchFolder folder;
    for (const char* threads : {"1", "2", "3"})
        ASSERT_EQ(run({"render", k_scene, "-o", folder / (threads + std::string(".png")), "--size", "101x67", "--frame",
                       "7", "--threads", threads})
                      .code,
                  0);
    EXPECT_EQ(bytes_of(folder / "1.png"), bytes_of(folder / "2.png"));
    EXPECT_EQ(bytes_of(folder / "1.png"), bytes_of(folder / "3.png"));
}

TEST(ImageOutput, EveryOptionChangesTheImage)
{
    const ScratchFolder folder;
    const std::vector<std::vector<std::string>> variants = {
        {},
        {"--frame", "30"},
        {"--exposure", "-1"},
        {"--exposure", "-2.5"},
        {"--tonemap", "agx"},
        {"--tonemap", "aces"},
        {"--tonemap", "none"},
        {"--lights", "0"},
        {"--light", "point 0 0.5 0 1 0.5 0.2"},
        {"--light", "point 0 0.5 0 1 0.5 0.2", "--light", "spot 0 0.9 0 0 -1 0 40 3 3 3"},
        {"--turntable", "4", "--frame", "12"},
        {"--samples", "4"},
    };
    std::map<std::string, std::size_t> seen;
    for (std::size_t i = 0; i < variants.size(); ++i) {
        std::vector<std::string> arguments{"render", k_scene, "-o", folder / "a.png", "--size", "64x64"};
        arguments.insert(arguments.end(), variants[i].begin(), variants[i].end());
        const Outcome outcome = run(arguments);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const auto [other, fresh] = seen.emplace(bytes_of(folder / "a.png"), i);
        EXPECT_TRUE(fresh) << testing::PrintToString(variants[i]) << " looks the same as "
                           << testing::PrintToString(variants[other->second]);
    }
}

}   // namespace
}   // namespace gnomon::test
