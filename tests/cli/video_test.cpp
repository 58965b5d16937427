// SPDX-License-Identifier: Apache-2.0
// Videos: complete or absent, and the same bytes however they were made.
#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;
const std::string k_scene = "builtin:cornell";

class Video : public testing::Test {
 protected:
    void SetUp() override
    {
        if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    }
    std::vector<std::string> arguments(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        // Quiet, because on a slow machine progress lines would precede the one line of a failure.
        std::vector<std::string> all{"render", k_scene,  "-o",    folder / name, "--frames",
                                     "1-12",   "--size", "65x49", "--quiet"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    void make(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        const Outcome outcome = run(arguments(name, more));
        ASSERT_EQ(outcome.code, 0) << outcome.err;
    }
    ScratchFolder folder;
};

TEST_F(Video, LeavesNoOtherFiles)
{
    make("a.mp4");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
    EXPECT_NE(bytes_of(folder / "a.mp4").find("ftyp"), std::string::npos);
}

TEST_F(Video, SameBytesForAnyThreadCountAndChunks)
{
    make("one.mp4", {"--threads", "1"});
    make("two.mp4", {"--threads", "2"});
    for (const char* chunk : {"2/3", "1/3", "3/3"}) {   // in any order
        make("parts.mp4", {"--chunk", chunk});
        EXPECT_FALSE(fs::exists(folder / "parts.mp4")) << "a chunk renders frames only";
    }
    EXPECT_EQ(names_in(folder / "parts.mp4.frames").size(), 13u) << "12 frames and a manifest";
    const Outcome last = run(arguments("parts.mp4", {"--resume", "--json"}));
    ASSERT_EQ(last.code, 0) << last.err;
    const auto said = last.json();
    EXPECT_EQ(said["frames"].size(), 12u);
    for (const auto& frame : said["frames"]) EXPECT_EQ(frame["ms"], 0) << "rendered again: " << frame;
    EXPECT_EQ(bytes_of(folder / "one.mp4"), bytes_of(folder / "two.mp4"));
    EXPECT_EQ(bytes_of(folder / "one.mp4"), bytes_of(folder / "parts.mp4"));
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"one.mp4", "parts.mp4", "two.mp4"}));
}

TEST_F(Video, ChunksDoNotNeedFfmpeg)
{
    EXPECT_EQ(run(arguments("a.mp4", {"--chunk", "1/6"}), {{"PATH", "/nonexistent"}}).code, 0);
    EXPECT_EQ(names_in(folder / "a.mp4.frames").size(), 3u);
}

TEST_F(Video, SameBytesAfterInterruptionAndResume)
{
    const std::vector<std::string> slow{"--samples", "64"};
    const fs::path frame = folder / "b.mp4.frames/frame-000003.png";
    for (const int signal : {SIGINT, SIGTERM}) {
        RunningProgram program(arguments("b.mp4", {"--samples", "64", "--resume"}));
        ASSERT_TRUE(wait_until([&] { return fs::exists(frame); }));
        program.send(signal);
        const Outcome outcome = program.wait();
        expect_failure(outcome, 130, "interrupted; --resume continues with the frames in");
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"b.mp4.frames"});
        for (const std::string& name : names_in(folder / "b.mp4.frames"))
            EXPECT_TRUE(name.starts_with("frame-") || name == "manifest.json") << name;
        fs::remove(frame);   // so that the next round has to render it again
    }
    make("b.mp4", {"--samples", "64", "--resume"});
    make("whole.mp4", slow);
    EXPECT_EQ(bytes_of(folder / "b.mp4"), bytes_of(folder / "whole.mp4"));
}

TEST_F(Video, LeavesNothingIfInterruptedBeforeTheFirstFrame)
{
    RunningProgram program(
        {"render", k_scene, "-o", folder / "a.mp4", "--size", "1024x1024", "--samples", "256", "--quiet"});
    ASSERT_TRUE(wait_until([&] { return fs::exists(folder / "a.mp4.frames/manifest.json"); }));
    program.send(SIGINT);
    expect_failure(program.wait(), 130, "interrupted");
    EXPECT_TRUE(names_in(folder.path()).empty());
}

// Chunks share a folder: a chunk that ends before the first frame of any keeps it for the others.
TEST_F(Video, InterruptedChunkKeepsTheSharedFolder)
{
    const fs::path frames = folder / "a.mp4.frames", manifest = frames / "manifest.json";
    // One frame each, which takes a while.
    const auto chunk = [&](const char* which) {
        return std::vector<std::string>{"render", k_scene,     "-o",   folder / "a.mp4", "--frames", "1-2",    "--size",
                                        "97x73",  "--samples", "1024", "--chunk",        which,      "--quiet"};
    };
    RunningProgram second(chunk("2/2"));
    ASSERT_TRUE(wait_until([&] { return fs::exists(manifest); }));
    fs::remove(manifest);   // the first chunk writes it again, which shows that it is at work
    RunningProgram first(chunk("1/2"));
    ASSERT_TRUE(wait_until([&] { return fs::exists(manifest); }));
    std::ofstream(frames / ".gnomon-1-1.tmp") << "another chunk's frame, half written";
    second.send(SIGTERM);
    expect_failure(second.wait(), 130, "interrupted");
    EXPECT_EQ(names_in(frames), (std::vector<std::string>{".gnomon-1-1.tmp", "manifest.json"}));
    const Outcome outcome = first.wait();
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(fs::exists(frames / "frame-000001.png"));
}

// The error that ends a video is reported even if its folder has vanished.
TEST_F(Video, ReportsTheErrorEvenIfTheFolderVanished)
{
    RunningProgram program(
        {"render", k_scene, "-o", folder / "a.mp4", "--size", "1024x1024", "--samples", "256", "--quiet"});
    ASSERT_TRUE(wait_until([&] { return fs::exists(folder / "a.mp4.frames/manifest.json"); }));
    fs::remove_all(folder / "a.mp4.frames");
    program.send(SIGINT);
    expect_failure(program.wait(), 130, "interrupted");
}

TEST_F(Video, RendersTruncatedFramesAgain)
{
    make("whole.mp4");
    make("a.mp4", {"--chunk", "1/1"});   // a single chunk is the video itself
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));

    make("b.mp4", {"--chunk", "1/2"});
    const fs::path torn = folder / "b.mp4.frames/frame-000002.png";
    const std::string bytes = bytes_of(torn);
    std::ofstream(torn, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
    make("b.mp4", {"--resume"});
    EXPECT_EQ(bytes_of(folder / "b.mp4"), bytes_of(folder / "whole.mp4"));
}

TEST_F(Video, DoesNotReuseFramesOfAnotherVideo)
{
    make("a.mp4", {"--chunk", "1/2"});
    const auto frames = names_in(folder / "a.mp4.frames");
    // Another exposure or number of samples is detected, and existing files are kept.
    for (const std::vector<std::string>& other :
         {std::vector<std::string>{"--exposure", "1"}, {"--samples", "2"}, {"--max-depth", "1"}}) {
        std::vector<std::string> more = other;
        more.emplace_back("--resume");
        expect_failure(run(arguments("a.mp4", more)), 2, "another size or set of options");
        more = other;
        more.insert(more.end(), {"--chunk", "2/2"});
        expect_failure(run(arguments("a.mp4", more)), 2, "another size or set of options");
    }
    EXPECT_EQ(names_in(folder / "a.mp4.frames"), frames);
    // Without --resume, a video starts from the beginning.
    make("a.mp4", {"--exposure", "1"});
    make("b.mp4", {"--exposure", "1"});
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "b.mp4"));
}

TEST_F(Video, KeepsForeignFiles)
{
    fs::create_directory(folder / "a.mp4.frames");
    std::ofstream(folder / "a.mp4.frames/thesis.txt") << "precious";
    expect_failure(run(arguments("a.mp4")), 2, "thesis.txt");
    EXPECT_EQ(bytes_of(folder / "a.mp4.frames/thesis.txt"), "precious");
}

TEST_F(Video, KeepsFramesAndNoVideoIfTheEncoderFails)
{
    const ScratchFolder programs;
    std::ofstream(programs / "ffmpeg") << "#!/bin/sh\ncase \"$*\" in *encoder=*) echo Encoder libx264; exit 0;; esac\n"
                                          "cat >/dev/null; echo 'the disk is full' >&2; exit 1\n";
    fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
    expect_failure(run(arguments("a.mp4"), {{"PATH", programs.path().string() + ":/usr/bin:/bin"}}), 4,
                   "the disk is full");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4.frames"});
    make("a.mp4", {"--resume"});
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
}

TEST(NumberedSet, SameImagesWithChunksAndResume)
{
    const ScratchFolder folder;
    const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> all{"render", k_scene,  "-o",    folder / name, "--frames",
                                     "5-9",    "--size", "40x30", "--json"};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = run(all);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.json();
    };
    EXPECT_EQ(render("a-{frame:03}.png", {})["frames"].size(), 5u);
    EXPECT_EQ(render("b-{frame:03}.png", {"--chunk", "2/2"})["frames"].size(), 3u);
    const auto document = render("b-{frame:03}.png", {"--resume"});
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_EQ(document["frames"][i]["ms"].get<double>() == 0, i >= 2) << "frame " << i + 5;
    EXPECT_EQ(names_in(folder.path()).size(), 10u);
    for (const char* frame : {"005", "006", "007", "008", "009"})
        EXPECT_EQ(bytes_of(folder / ("a-" + std::string(frame) + ".png")),
                  bytes_of(folder / ("b-" + std::string(frame) + ".png")));
}

TEST(ContactSheet, ShowsTwelveFrames)
{
    const ScratchFolder folder;
    const Outcome outcome = run({"render", k_scene, "-o", folder / "{frame}.png", "--frames", "1-30", "--size", "40x30",
                                 "--contact-sheet", folder / "sheet.png"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string sheet = bytes_of(folder / "sheet.png");
    // 4 columns of 40 and 3 rows of 30 pixels, gaps of 8, and 22 for a line of text.
    EXPECT_EQ(sheet.substr(16, 8), std::string("\0\0\0\xc8\0\0\0\xbc", 8));
}

}   // namespace
}   // namespace gnomon::test
