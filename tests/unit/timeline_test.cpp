// SPDX-License-Identifier: Apache-2.0
// Clips at other frame rates.
#include <gtest/gtest.h>

#include "api/scene_access.h"

#include "gnomon/error.h"
#include "gnomon/scene.h"
#include "scene/scene.h"

namespace gnomon {
namespace {

scene::Timeline clip(double end)
{
    scene::Timeline timeline;
    timeline.end = end;
    timeline.frames = static_cast<int>(std::min(end * 24, scene::k_most_frames - 1.0)) + 1;
    return timeline;
}

TEST(Timeline, CountsFramesAtAnotherRate)
{
    EXPECT_EQ(clip(2).at_rate(10).frames, 21);
    EXPECT_EQ(clip(2).at_rate(0.1).frames, 1);
    EXPECT_EQ(clip(0).at_rate(1000).frames, 1);
    // A clip shorter than a frame has more frames at a higher rate.
    EXPECT_EQ(clip(0.04).frames, 1);
    EXPECT_EQ(clip(0.04).at_rate(1000).frames, 41);
    scene::Timeline own = clip(2);
    own.own_frames = true;
    EXPECT_EQ(own.at_rate(1000).frames, own.frames);
    EXPECT_EQ(own.at_rate(1000).fps, 1000);
}

TEST(Timeline, LimitsTheNumberOfFrames)
{
    for (const double end : {3e6, 1e9, 3e38}) {
        EXPECT_EQ(clip(end).at_rate(1000).frames, scene::k_most_frames) << end;
        auto inside = std::make_shared<scene::Scene>();
        inside->timeline = clip(end);
        EXPECT_THROW(api::public_scene(inside).at_rate(1000), UsageError) << end;
        EXPECT_THROW(api::public_scene(inside).at_rate(700), UsageError) << end;
    }
    auto inside = std::make_shared<scene::Scene>();
    inside->timeline = clip(1e6);
    EXPECT_EQ(api::public_scene(inside).at_rate(1000).frame_count(), scene::k_most_frames);
}

}   // namespace
}   // namespace gnomon
