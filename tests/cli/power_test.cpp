// SPDX-License-Identifier: Apache-2.0
// What the program has finished survives a loss of power (losing_power.cpp), and a video goes on from it.
#include <fmt/format.h>

#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;

class LossOfPower : public testing::Test {
 protected:
    void SetUp() override
    {
        if (k_sanitized) GTEST_SKIP() << "a sanitizer's runtime must be loaded first";
    }
    std::vector<std::string> arguments(const std::string& name) const
    {
        return {"render", "builtin:cornell", "-o", folder / name, "--frames", "1-4", "--size", "33x24", "--quiet"};
    }
    std::string image(const std::string& name, int frame) const
    {
        return bytes_of(folder / fmt::format("{}-{}.png", name, frame));
    }
    ScratchFolder folder;
};

// Power fails at a rename, counted from 1, or when the program ends.
Environment losing_power(int at = 0)
{
    Environment environment{{"LD_PRELOAD", places::losing_power}};
    if (at > 0) environment["GNOMON_POWER_FAILS_AT"] = std::to_string(at);
    return environment;
}

TEST_F(LossOfPower, LeavesFinishedImages)
{
    ASSERT_EQ(run(arguments("whole-{frame}.png")).code, 0);
    EXPECT_EQ(run(arguments("third-{frame}.png"), losing_power(3)).code, -SIGKILL);
    EXPECT_EQ(run(arguments("end-{frame}.png"), losing_power()).code, 0);
    for (int frame = 1; frame <= 4; ++frame) {
        ASSERT_GT(image("whole", frame).size(), 100u);
        EXPECT_EQ(image("third", frame), frame < 3 ? image("whole", frame) : "") << frame;
        EXPECT_EQ(image("end", frame), image("whole", frame)) << frame;
    }

    // Without syncs nothing would be left.
    Environment forgetful = losing_power();
    forgetful["GNOMON_SYNCS_DO_NOTHING"] = "1";
    EXPECT_EQ(run(arguments("none-{frame}.png"), forgetful).code, 0);
    for (int frame = 1; frame <= 4; ++frame) EXPECT_EQ(image("none", frame), "") << frame;
}

TEST_F(LossOfPower, LetsAVideoGoOn)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    ASSERT_EQ(run(arguments("whole.mp4")).code, 0);
    const std::string whole = bytes_of(folder / "whole.mp4");
    ASSERT_GT(whole.size(), 1000u);

    constexpr int k_renames = 7;   // the manifest, again with the exposure, four frames and the video
    for (int at = 1; at <= k_renames; ++at) {
        const std::string name = fmt::format("{}.mp4", at);
        EXPECT_EQ(run(arguments(name), losing_power(at)).code, -SIGKILL) << at;
        EXPECT_FALSE(fs::exists(folder / name)) << at;
        const fs::path frames = folder / (name + ".frames");
        ASSERT_TRUE(fs::is_directory(frames)) << at;
        for (int frame = 1; frame < std::min(at - 2, 5); ++frame)
            EXPECT_GT(bytes_of(frames / fmt::format("frame-{:06}.png", frame)).size(), 100u) << at;
        std::vector<std::string> resume = arguments(name);
        resume.emplace_back("--resume");
        const Outcome resumed = run(resume);
        EXPECT_EQ(resumed.code, 0) << resumed.err;
        EXPECT_EQ(bytes_of(folder / name), whole) << at;
        EXPECT_FALSE(fs::exists(frames));
    }
    EXPECT_EQ(run(arguments("end.mp4"), losing_power()).code, 0);
    EXPECT_EQ(bytes_of(folder / "end.mp4"), whole);
}

}   // namespace
}   // namespace gnomon::test
