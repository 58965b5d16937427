// SPDX-License-Identifier: Apache-2.0
#include "video/encoder.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "support.h"
#include "video/process.h"

namespace gnomon::io {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// A square that moves over a ramp; sizes are odd, and names contain characters special to a shell or a pattern.
std::vector<fs::path> make_frames(const test::ScratchFolder& folder, int count)
{
    std::vector<fs::path> frames;
    for (int i = 0; i < count; ++i) {
        Image8 image(65, 49, 3);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                for (int c = 0; c < 3; ++c)
                    image.pixel(x, y)[c] =
                        static_cast<std::uint8_t>(x / 8 == i % 8 && y / 8 == 2 ? 255 : (x * 3 + y * (c + 1)) % 200);
        frames.push_back(folder / ("a '%d' frame; $(x) " + std::to_string(i) + ".png"));
        write_png(frames.back(), image);
    }
    return frames;
}

// The output of `ffprobe` for a video.
std::string probe(const fs::path& video, const std::string& entries)
{
    video::Process ffprobe({"ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=" + entries, "-of",
                            "default=noprint_wrappers=1:nokey=1", video.string()});
    EXPECT_EQ(ffprobe.wait(), 0) << ffprobe.errors();
    return ffprobe.output();
}

class ScopedPath {
 public:
    explicit ScopedPath(const std::string& value) : before_(std::getenv("PATH")) { ::setenv("PATH", value.c_str(), 1); }
    ~ScopedPath() { ::setenv("PATH", before_.c_str(), 1); }

 private:
    std::string before_;
};

void expect_no_video(const test::ScratchFolder& folder)
{
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.path()))
        EXPECT_EQ(entry.path().extension(), ".png") << entry.path();
}

TEST(VideoEncoder, WritesAllFramesAtTheFrameRateAndIsRepeatable)
{
    if (!video::have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    test::ScratchFolder folder;
    const std::vector<fs::path> frames = make_frames(folder, 9);
    video::encode_video(frames, 39.95, folder / "-a video.mp4", {});
    video::encode_video(frames, 39.95, folder / "b.mp4", {});
    EXPECT_EQ(bytes_of(folder / "-a video.mp4"), bytes_of(folder / "b.mp4"));
    EXPECT_EQ(probe(folder / "b.mp4", "width,height,pix_fmt,r_frame_rate,nb_read_frames"),
              "64\n48\nyuv420p\n799/20\n9\n");
    const std::string video = bytes_of(folder / "b.mp4");
    EXPECT_LT(video.find("moov"), video.find("mdat")) << "the index comes first, so that players can start at once";
}

TEST(VideoEncoder, EncodesASingleFrame)
{
    if (!video::have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    test::ScratchFolder folder;
    video::encode_video(make_frames(folder, 1), 24, folder / "one.mp4", {});
    EXPECT_EQ(probe(folder / "one.mp4", "nb_read_frames"), "1\n");
}

TEST(VideoEncoder, ReportsMissingFfmpeg)
{
    test::ScratchFolder folder;
    const std::vector<fs::path> frames = make_frames(folder, 2);
    const ScopedPath path(folder.path().string());
    EXPECT_FALSE(video::have_ffmpeg());
    EXPECT_THROW(video::encode_video(frames, 24, folder / "a.mp4", {}), MissingError);
    expect_no_video(folder);
}

// Replaces ffmpeg by a script of one line.
void install_script(const fs::path& folder, const std::string& line)
{
    const fs::path program = folder / "ffmpeg";
    std::ofstream(program) << "#!/bin/sh\n" << line << "\n";
    fs::permissions(program, fs::perms::owner_all);
}

std::string failure_with(const std::string& line)
{
    test::ScratchFolder folder, programs;
    const std::vector<fs::path> frames = make_frames(folder, 40);
    install_script(programs.path(), line);
    const ScopedPath path(programs.path().string() + ":/usr/bin:/bin");
    std::string message;
    try {
        video::encode_video(frames, 24, folder / "a.mp4", {});
        ADD_FAILURE() << "nothing thrown with " << line;
    } catch (const MissingError& error) {
        message = error.what();
    }
    expect_no_video(folder);
    return message;
}

TEST(VideoEncoder, QuotesAFailingFfmpeg)
{
    EXPECT_NE(failure_with("echo no room >&2; echo >&2; echo 'Conversion failed!' >&2; exit 1").find("no room"),
              std::string::npos);
    EXPECT_NE(failure_with("cat >/dev/null; echo late >&2; exit 3").find("late"), std::string::npos);
    EXPECT_NE(failure_with("exit 0").find("ffmpeg could not write"), std::string::npos) << "it wrote nothing";
    EXPECT_NE(failure_with("kill -9 $$").find("signal 9"), std::string::npos);
}

TEST(VideoEncoder, CanBeInterrupted)
{
    test::ScratchFolder folder, programs;
    const std::vector<fs::path> frames = make_frames(folder, 3);
    install_script(programs.path(), "exec sleep 60");
    const ScopedPath path(programs.path().string() + ":/usr/bin:/bin");
    int calls = 0;
    EXPECT_THROW(video::encode_video(frames, 24, folder / "a.mp4", [&](const ProgressStep&) { return ++calls < 20; }),
                 InterruptedError);
    expect_no_video(folder);
    // Before the rendering, too.
    calls = 0;
    EXPECT_THROW(video::have_ffmpeg([&](const ProgressStep&) { return ++calls < 20; }), InterruptedError);
}

TEST(Process, WritingToAnEndedProgramReturnsFalse)
{
    video::Process program({"true"});
    const std::vector<std::uint8_t> much(1 << 22, 'x');
    EXPECT_FALSE(program.write(much));
    EXPECT_EQ(program.wait(), 0);
}

TEST(Process, PassesArgumentsUnchanged)
{
    video::Process program({"printf", "%s|", "a b", "$(x)", "'", ""});
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.output(), "a b|$(x)|'||");
    EXPECT_THROW(video::Process({"no-such-program-anywhere"}), MissingError);
}

TEST(Process, PassesInputToTheProgram)
{
    video::Process program({"wc", "-c"});
    const std::vector<std::uint8_t> much(1 << 20, 'x');
    EXPECT_TRUE(program.write(much));
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.output(), "1048576\n");
}

}   // namespace
}   // namespace gnomon::io
