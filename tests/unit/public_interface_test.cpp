// SPDX-License-Identifier: Apache-2.0
// Misuse of the public interface: an exception with a reason, and never a crash.
#include <gtest/gtest.h>

#include <limits>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

RenderOptions small()
{
    RenderOptions options;
    options.size = {8, 8};
    return options;
}

TEST(PublicInterface, MovedFromRenderersThrow)
{
    // NOLINTBEGIN(bugprone-use-after-move, performance-move-const-arg): this is the behaviour under test
    Scene scene = load("builtin:cornell");
    const Scene taken = std::move(scene);
    EXPECT_EQ(scene.frame_count(), taken.frame_count());   // copies share all data

    Renderer renderer(small()), other = std::move(renderer);
    EXPECT_THROW(renderer.render(taken, 1), UsageError);
    EXPECT_THROW(renderer.options(), UsageError);
    EXPECT_THROW(renderer.device(), UsageError);
    const test::ScratchFolder folder;
    VideoJob job;
    job.out = folder / "a.png";
    EXPECT_THROW(render_video(taken, renderer, job), UsageError);
    renderer = std::move(other);
    EXPECT_NO_THROW(renderer.render(taken, 1));
    // NOLINTEND(bugprone-use-after-move, performance-move-const-arg)
}

TEST(PublicInterface, RefusesInvalidNumbers)
{
    constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    for (const double exposure : {nan, inf, -inf, 101.0, -1e6}) {
        RenderOptions options = small();
        options.exposure = exposure;
        EXPECT_THROW(Renderer{options}, UsageError) << exposure;
    }
    for (const double seconds : {nan, inf, -1.0, 1e-320, 1e300}) {
        RenderOptions options = small();
        options.turntable_seconds = seconds;
        EXPECT_THROW(Renderer{options}, UsageError) << seconds;
    }
    const test::ScratchFolder folder;
    Renderer renderer(small());
    const Scene scene = load("builtin:cornell");
    for (const double fps : {nan, inf, 0.0, -1.0, 1e-4, 1e7}) {
        VideoJob job;
        job.out = folder / "a.mp4";
        job.fps = fps;
        int frames = 0;
        EXPECT_THROW(render_video(scene, renderer, job, {}, [&](const FrameRecord&) { ++frames; }), UsageError) << fps;
        EXPECT_EQ(frames, 0);
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PublicInterface, RefusesContradictingOptions)
{
    RenderOptions options = small();
    options.overlay = Overlay::clusters;
    options.indirect = Indirect::quadtree;
    options.reference.emplace();
    EXPECT_THROW(Renderer{options}, UsageError);
}

TEST(PublicInterface, RefusesInvalidThreadCountsOfComparisons)
{
    const test::ScratchFolder folder;
    const auto image = folder / "a.png";
    Renderer(small()).render(load("builtin:cornell"), 1).write(image);
    CompareOptions options;
    for (const int threads : {-1, 1025, std::numeric_limits<int>::max()}) {
        options.threads = threads;
        EXPECT_THROW(compare(image, image, options), UsageError) << threads;
    }
}

}   // namespace
}   // namespace gnomon
