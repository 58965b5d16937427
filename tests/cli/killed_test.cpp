// SPDX-License-Identifier: Apache-2.0
// A video that is killed at any moment (without handlers or destructors) and resumed equals the video of one
// undisturbed run.
#include <fmt/format.h>

#include <random>

#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;
constexpr int k_frames = 24;

// Kills the same video once at each of `moments` random moments, from before its first frame to after its last, resumes
// it each time, and compares the bytes.
void kill_and_resume(int moments, unsigned seed)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    using Clock = std::chrono::steady_clock;
    const ScratchFolder folder;
    const auto arguments = [&](const std::string& name) {
        return std::vector<std::string>{"render", "builtin:cornell", "-o",        folder / name, "--frames", "1-24",
                                        "--size", "65x49",           "--threads", "2",           "--resume", "--quiet"};
    };
    const auto start = Clock::now();
    const Outcome whole = run(arguments("whole.mp4"));
    ASSERT_EQ(whole.code, 0) << whole.err;
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const std::string bytes = bytes_of(folder / "whole.mp4");
    ASSERT_GT(bytes.size(), 1000u);

    // A moment is a random delay, of at most the time of two frames, after a frame has appeared; a fifth of them after
    // the last frame, while the video is encoded.
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> after(0, k_frames + k_frames / 4);
    std::uniform_real_distribution<double> delay(0, 2 * seconds / k_frames);
    int killed = 0, among_frames = 0, encoding = 0;
    for (int i = 0; i < moments; ++i) {
        const std::string name = "killed-" + std::to_string(i) + ".mp4";
        const fs::path frames = folder / (name + ".frames");
        const int frame = std::min(after(random), k_frames);
        const double seconds_after = delay(random);
        const std::string at = fmt::format("{:.3f} s after frame {}", seconds_after, frame);
        {
            RunningProgram program(arguments(name));
            const std::string file = frame == 0 ? "manifest.json" : fmt::format("frame-{:06}.png", frame);
            ASSERT_TRUE(wait_until([&] { return fs::exists(frames / file) || fs::exists(folder / name); }));
            std::this_thread::sleep_for(std::chrono::duration<double>(seconds_after));
            program.send(SIGKILL);
            const Outcome outcome = program.wait();
            killed += outcome.code == -SIGKILL;
            EXPECT_TRUE(outcome.code == -SIGKILL || outcome.code == 0) << outcome.code << outcome.err;
            EXPECT_EQ(outcome.err, "");
        }
        if (fs::exists(frames)) {
            const std::vector<std::string> left = names_in(frames);
            among_frames += left.size() > 1;
            encoding += left.size() > k_frames + 1u;
        }
        // A file with the video's name is the complete video.
        EXPECT_TRUE(!fs::exists(folder / name) || bytes_of(folder / name) == bytes) << "killed " << at;
        const Outcome resumed = run(arguments(name));
        ASSERT_EQ(resumed.code, 0) << "killed " << at << ": " << resumed.err;
        EXPECT_TRUE(bytes_of(folder / name) == bytes) << "killed " << at;
        EXPECT_FALSE(fs::exists(frames)) << "killed " << at;
        fs::remove(folder / name);
        // A kill within a few instructions can leave the file that tests whether the folder is writable.
        for (const std::string& other : names_in(folder.path()))
            EXPECT_TRUE(other == "whole.mp4" || (other.starts_with(".gnomon-") && fs::is_empty(folder / other)))
                << other << ", killed " << at;
    }
    std::printf("%d moments: %d killed, %d of them with frames there, %d with all frames and a part of the video\n",
                moments, killed, among_frames, encoding);
    EXPECT_GT(killed, moments / 2);
}

TEST(KilledVideo, ResumesToTheSameBytes)
{
    kill_and_resume(5, 1);
}

TEST(KilledVideoFull, ResumesToTheSameBytesAtFiftyMoments)
{
    kill_and_resume(50, 2);
}

}   // namespace
}   // namespace gnomon::test
