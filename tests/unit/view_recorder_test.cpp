// SPDX-License-Identifier: Apache-2.0
// What the viewer writes, and what it leaves behind.
#ifdef GNOMON_VIEWER
#include "viewer/recorder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "gnomon/error.h"
#include "support.h"

namespace gnomon::viewer {
namespace {

namespace fs = std::filesystem;

// An ffmpeg that has the encoder, and fails.
fs::path with_failing_ffmpeg(const fs::path& folder)
{
    const fs::path file = folder / "ffmpeg";
    std::ofstream(file) << "#!/bin/sh\ncase \"$*\" in *-h*encoder=*) echo Encoder libx264;; *) exit 1;; esac\n";
    fs::permissions(file, fs::perms::owner_all);
    return folder;
}

struct RecorderTest : testing::Test {
    const test::ScratchFolder programs, temporary;
    const test::ScopedVariable path{"PATH", with_failing_ffmpeg(programs.path()).string() + ":" + std::getenv("PATH")};
    const test::ScopedVariable place{"TMPDIR", temporary.path().string()};
};

TEST_F(RecorderTest, RemovesItsFramesIfNoVideoIsMade)
{
    {
        Recorder recorder;
        for (const int images : {2, 0, 1}) {
            ASSERT_EQ(recorder.start(24), "");
            for (int i = 0; i < images; ++i) EXPECT_TRUE(recorder.add(Image8(8, 6, 3)));
            EXPECT_FALSE(fs::is_empty(temporary.path()));
            EXPECT_EQ(recorder.stop().empty(), images == 0);
        }
        EXPECT_THROW(recorder.finish(), MissingError);
        EXPECT_TRUE(fs::is_empty(temporary.path()));
        ASSERT_EQ(recorder.start(24), "");   // not stopped explicitly
        recorder.add(Image8(8, 6, 3));
    }
    EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST_F(RecorderTest, RefusesImagesOfAnotherSize)
{
    Recorder recorder;
    ASSERT_EQ(recorder.start(24), "");
    EXPECT_TRUE(recorder.add(Image8(8, 6, 3)));
    EXPECT_FALSE(recorder.add(Image8(4, 3, 3)));
    EXPECT_TRUE(recorder.add(Image8(8, 6, 3)));
}

// Memory would fill up with images that arrive faster than they are written.
TEST_F(RecorderTest, ReportsWhenItIsBehind)
{
    Recorder recorder;
    EXPECT_FALSE(recorder.behind());
    ASSERT_EQ(recorder.start(24), "");
    // Encoding noise takes a hundred times longer than handing it over.
    Image8 noise(800, 400, 3);
    std::minstd_rand random(1);
    for (std::uint8_t& byte : noise.data) byte = static_cast<std::uint8_t>(random() >> 8);
    int images = 0;
    for (; images < 100 && !recorder.behind(); ++images) recorder.add(noise);
    EXPECT_LT(images, 100);
    EXPECT_GT(images, 3);
    recorder.finish();
    EXPECT_FALSE(recorder.behind());
}

}   // namespace
}   // namespace gnomon::viewer
#endif
