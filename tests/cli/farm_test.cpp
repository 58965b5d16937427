// SPDX-License-Identifier: Apache-2.0
// Videos rendered by many machines: finished ones are left alone, outdated frames are rendered again, chunks are
// joined.
#include <fmt/format.h>

#include "gnomon/version.h"
#include "io/image/image_file.h"
#include "run_program.h"
#include "video/mp4.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;
const std::string k_scene = "builtin:cornell";

class Farm : public testing::Test {
 protected:
    void SetUp() override
    {
        if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    }
    std::vector<std::string> arguments(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        std::vector<std::string> all{"render", k_scene,  "-o",    folder / name, "--frames",
                                     "1-12",   "--size", "65x49", "--indirect",  "off"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    Outcome make(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        Outcome outcome = run(arguments(name, more));
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome;
    }
    fs::path frame(const std::string& name, int number) const
    {
        return folder / fmt::format("{}.frames/frame-{:06}.png", name, number);
    }
    // Makes a frame say that something else rendered it; and shows that it is kept only if it is not.
    static void stamp(const fs::path& file, const std::string& text)
    {
        Image8 image = io::read_image(file);
        std::fill(image.data.begin(), image.data.end(), std::uint8_t{0});
        io::write_png(file, image, text);
    }
    static std::string stamp_of(const fs::path& file)
    {
        return io::comment_of_whole_png(file, 65, 49).value_or("none");
    }
    ScratchFolder folder;
};

TEST_F(Farm, ResumeOfAFinishedVideoDoesNothing)
{
    make("a.mp4");
    const auto written = fs::last_write_time(folder / "a.mp4");
    const auto start = std::chrono::steady_clock::now();
    const Outcome again = make("a.mp4", {"--resume", "--json"});
    const std::chrono::duration<double> span = std::chrono::steady_clock::now() - start;
    EXPECT_LT(span.count(), 1 * k_patience);
    EXPECT_EQ(fs::last_write_time(folder / "a.mp4"), written);
    EXPECT_NE(again.err.find("is complete; nothing to do"), std::string::npos) << again.err;
    const auto said = again.json();
    EXPECT_EQ(said["frames"].size(), 12u);
    for (const auto& frame : said["frames"]) EXPECT_EQ(frame["kept"], true) << frame;
    // A chunk of it has nothing to do either, and so has join; none of them needs ffmpeg or leaves anything.
    const Environment no_programs{{"PATH", "/nonexistent"}};
    EXPECT_EQ(run(arguments("a.mp4", {"--resume", "--chunk", "2/3"}), no_programs).code, 0);
    EXPECT_EQ(run({"join", folder / "a.mp4"}, no_programs).code, 0);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
    EXPECT_EQ(fs::last_write_time(folder / "a.mp4"), written);
}

// Without --resume, or of another video, it is rendered again, and the reason is said.
TEST_F(Farm, RendersAFinishedVideoAgainIfItIsAnotherOne)
{
    make("a.mp4");
    const auto fresh = fs::last_write_time(folder / "a.mp4");
    make("a.mp4");
    EXPECT_NE(fs::last_write_time(folder / "a.mp4"), fresh) << "without --resume";
    const std::pair<std::vector<std::string>, std::string> others[] = {
        {{"--light", "point 0 0 0 1 1 1"}, "is of another scene"},
        {{"--light", "point 0 0 0 1 1 1", "--exposure", "1"}, "is rendered with other options"},
        {{"--light", "point 0 0 0 1 1 1", "--exposure", "1", "--frames", "1-3"}, "is of other frames"},
    };
    for (const auto& [options, reason] : others) {
        std::vector<std::string> more = options;
        more.emplace_back("--resume");
        std::vector<std::string> all{"render", k_scene, "-o", folder / "a.mp4", "--size", "65x49", "--indirect", "off"};
        if (options.size() < 5) all.insert(all.end(), {"--frames", "1-12"});
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = run(all);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("a.mp4 " + reason), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find("it is rendered again"), std::string::npos) << outcome.err;
    }
    // A video that was cut off is no finished one.
    const std::string bytes = bytes_of(folder / "a.mp4");
    fs::resize_file(folder / "a.mp4", bytes.size() - 100);
    const Outcome outcome = run({"render", k_scene, "-o", folder / "a.mp4", "--size", "65x49", "--indirect", "off",
                                 "--light", "point 0 0 0 1 1 1", "--exposure", "1", "--frames", "1-3", "--resume"});
    EXPECT_NE(outcome.err.find("a.mp4 is incomplete: it is rendered again"), std::string::npos) << outcome.err;
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes);
}

TEST_F(Farm, RendersFramesOfAnotherVersionInstructionSetOrSceneAgain)
{
    make("whole.mp4");
    make("a.mp4", {"--chunk", "1/1"});
    ASSERT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));
    make("b.mp4", {"--chunk", "1-8"});
    const std::string ours = stamp_of(frame("b.mp4", 1));
    const std::string start = std::string(version()) + " " + std::string("auto") + " ";
    ASSERT_TRUE(ours.starts_with(start)) << ours;
    const std::string hashes = ours.substr(start.size());
    stamp(frame("b.mp4", 2), "0.0.1 " + std::string("auto") + " " + hashes);
    stamp(frame("b.mp4", 3), "0.0.1 " + std::string("auto") + " " + hashes);
    stamp(frame("b.mp4", 5), std::string(version()) + " mmx " + hashes);
    stamp(frame("b.mp4", 7), start + "0123456789abcdef 0123456789abcdef");
    stamp(frame("b.mp4", 8), "");

    // Joining names them and does not mix them with others.
    make("b.mp4", {"--chunk", "9-12"});
    const Outcome refused = run({"join", folder / "b.mp4"});
    EXPECT_EQ(refused.code, 2);
    for (const char* part :
         {"frames 2-3 are rendered by version 0.0.1, not ",
          "frame 5 is rendered with the instruction "
          "set mmx, not ",
          "frame 7 is of another scene", "frame 8 is without a note", "render again with --chunk 2-3"})
        EXPECT_NE(refused.err.find(part), std::string::npos) << part << " in: " << refused.err;
    EXPECT_FALSE(fs::exists(folder / "b.mp4"));

    const Outcome resumed = make("b.mp4", {"--resume", "--json"});
    for (const char* part : {"frames 2-3 of ", "are rendered by version 0.0.1, not ", "frame 5 of ",
                             "is rendered with the instruction set mmx, not ", "frame 7 of ", "is of another scene",
                             "frame 8 of ", "they are rendered again"})
        EXPECT_NE(resumed.err.find(part), std::string::npos) << part << " in: " << resumed.err;
    const nlohmann::json document = resumed.json();
    std::vector<int> kept;
    for (const auto& each : document["frames"])
        if (each.contains("kept")) kept.push_back(each["frame"]);
    EXPECT_EQ(kept, (std::vector<int>{1, 4, 6, 9, 10, 11, 12}));
    EXPECT_EQ(bytes_of(folder / "b.mp4"), bytes_of(folder / "whole.mp4"));
}

// A scene that was edited while its chunks were rendered.
TEST_F(Farm, RendersChunksOfAnEarlierSceneAgain)
{
    const std::vector<std::string> edited{"--light", "point 0 1 0 5 5 5"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.end(), edited.begin(), edited.end());
        return more;
    };
    make("whole.mp4", edited);
    make("a.mp4", {"--chunk", "1/2"});
    make("a.mp4", with({"--chunk", "2/2", "--resume"}));
    expect_failure(run({"join", folder / "a.mp4"}), 2, "frames 1-6 are of another scene");
    const Outcome first = make("a.mp4", with({"--chunk", "1/2", "--resume"}));
    EXPECT_NE(first.err.find("frames 1-6 of "), std::string::npos) << first.err;
    EXPECT_EQ(run({"join", folder / "a.mp4"}).code, 0);
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));
}

TEST_F(Farm, JoinMakesTheSameBytesFromChunksOfAnyKind)
{
    make("whole.mp4");
    for (const char* chunk : {"3/3", "1-3", "2/3", "4-4"}) make("a.mp4", {"--chunk", chunk});
    const Outcome joined = run({"join", folder / "a.mp4", "--json"});
    ASSERT_EQ(joined.code, 0) << joined.err;
    EXPECT_EQ(joined.json()["frames"], 12);
    EXPECT_EQ(joined.json()["complete_before"], false);
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"a.mp4", "whole.mp4"}));
    EXPECT_EQ(run({"join", folder / "a.mp4", "--json"}).json()["complete_before"], true);
}

TEST_F(Farm, JoinNamesWhatIsMissing)
{
    expect_failure(run({"join", folder / "a.mp4"}), 2, "no chunk of this video was rendered");
    expect_failure(run({"join", folder / "a.png"}), 2, "only the chunks of a video");
    make("a.mp4", {"--chunk", "1/4"});
    make("a.mp4", {"--chunk", "3/4"});
    const std::string torn = bytes_of(frame("a.mp4", 8));
    std::ofstream(frame("a.mp4", 8), std::ios::binary) << torn.substr(0, torn.size() / 2);
    expect_failure(run({"join", folder / "a.mp4"}), 2,
                   "frames 4-6, 8 and 10-12 of 1-12 are missing; render again with --chunk 4-6");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4.frames"});
    for (const char* chunk : {"4-6", "7-12"}) make("a.mp4", {"--chunk", chunk, "--resume"});
    EXPECT_EQ(run({"join", folder / "a.mp4"}).code, 0);
}

TEST_F(Farm, ChunkOfFramesLiesWithinTheRange)
{
    for (const char* chunk : {"12-13", "0-3", "5-4", "4", "x", "3/2"}) {
        const Outcome outcome = run(arguments("a.mp4", {"--chunk", chunk}));
        EXPECT_EQ(outcome.code, 2) << chunk << outcome.err;
    }
    EXPECT_TRUE(names_in(folder.path()).empty());
}

// A run that was killed between the video and the removal of its frames leaves both.
TEST_F(Farm, RemovesFramesThatAKilledRunLeftBesideItsVideo)
{
    for (const bool joined : {false, true}) {
        make("a.mp4", {"--chunk", "1/2"}), make("a.mp4", {"--chunk", "2/2"});
        fs::copy(folder / "a.mp4.frames", folder / "kept");
        make("a.mp4", {"--resume"});
        fs::rename(folder / "kept", folder / "a.mp4.frames");
        fs::remove(frame("a.mp4", 3));
        EXPECT_EQ((joined ? run({"join", folder / "a.mp4"}) : make("a.mp4", {"--resume"})).code, 0);
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
        fs::remove(folder / "a.mp4");
    }
}

// The line of docs/guide/farm.md for GNU parallel.
TEST_F(Farm, ParallelChunksMakeTheSameBytes)
{
    if (std::system("parallel --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no GNU parallel";
    make("whole.mp4");
    const std::string line = fmt::format(
        "seq 4 | parallel --jobs 2 '{0}' render {1} -o '{2}' --frames 1-12 --size 65x49 --indirect off --quiet --chunk "
        "{{}}/4 --resume "
        "&& '{0}' join '{2}' --quiet",
        places::program, k_scene, (folder / "a.mp4").string());
    ASSERT_EQ(std::system(line.c_str()), 0) << line;
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));
}

TEST(Mp4, ReadsTheCommentOfItsOwnFilesOnly)
{
    const ScratchFolder folder;
    EXPECT_EQ(video::comment_of_mp4(folder / "none.mp4"), "");
    const std::string nothing[] = {"",
                                   "moov",
                                   std::string(64, '\0'),
                                   std::string(64, '\xff'),
                                   std::string("\0\0\0\x10moov\0\0\0\x08udta", 16),
                                   std::string("\0\0\0\x1cmoov\0\0\0\x14udta\0\0\0\x0cmeta\0\0", 26)};
    for (const std::string& bytes : nothing) {
        std::ofstream(folder / "a.mp4", std::ios::binary) << bytes;
        EXPECT_EQ(video::comment_of_mp4(folder / "a.mp4"), "");
        EXPECT_FALSE(video::is_whole_mp4(folder / "a.mp4"));
    }
}

}   // namespace
}   // namespace gnomon::test
