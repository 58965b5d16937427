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

// A frame of noise takes much longer to encode than a black one.
Frame frame_of(Size size, bool noise = false)
{
    std::vector<float> values(std::size_t{3} * size.width * size.height);
    std::minstd_rand random(1);
    if (noise)
        for (float& value : values) value = static_cast<float>(random() >> 8 & 255) / 255;
    const auto memory = std::make_shared<const std::vector<float>>(std::move(values));
    Frame frame;
    frame.size = size;
    frame.tonemap = ToneMap::none;
    Layer& layer = frame.layers.emplace_back();
    layer.channels = {"R", "G", "B"};
    layer.size = size;
    layer.data = memory->data();
    layer.pixel_stride = 3 * sizeof(float);
    layer.row_stride = layer.pixel_stride * size.width;
    layer.memory = memory;
    return frame;
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
            for (int i = 0; i < images; ++i) EXPECT_TRUE(recorder.add(frame_of({8, 6})));
            EXPECT_FALSE(fs::is_empty(temporary.path()));
            EXPECT_EQ(recorder.stop().empty(), images == 0);
        }
        EXPECT_THROW(recorder.finish(), MissingError);
        EXPECT_TRUE(fs::is_empty(temporary.path()));
        ASSERT_EQ(recorder.start(24), "");   // not stopped explicitly
        recorder.add(frame_of({8, 6}));
    }
    EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST_F(RecorderTest, RefusesImagesOfAnotherSize)
{
    Recorder recorder;
    ASSERT_EQ(recorder.start(24), "");
    EXPECT_TRUE(recorder.add(frame_of({8, 6})));
    EXPECT_FALSE(recorder.add(frame_of({4, 3})));
    EXPECT_TRUE(recorder.add(frame_of({8, 6})));
}

// Memory would fill up with images that arrive faster than they are written.
TEST_F(RecorderTest, ReportsWhenItIsBehind)
{
    Recorder recorder;
    EXPECT_FALSE(recorder.behind());
    ASSERT_EQ(recorder.start(24), "");
    // Encoding noise takes a hundred times longer than handing it over.
    const Frame noise = frame_of({800, 400}, true);
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
