// SPDX-License-Identifier: Apache-2.0
// When the viewer's window draws, how large images in motion are, and how long inputs waited.
#ifdef GNOMON_VIEWER
#include "viewer/window_pace.h"

#include <gtest/gtest.h>

#include "viewer/latency.h"
#include "viewer/motion_size.h"

namespace gnomon::viewer {
namespace {

using std::chrono::milliseconds;
constexpr WindowPace::Clock::time_point k_start{std::chrono::seconds(10)};

TEST(WindowPace, ImagesAreDrawnAtOnceAndInputsAfterAPause)
{
    WindowPace pace;
    EXPECT_TRUE(pace.draws(false, k_start)) << "the window's first frame";
    pace.drawn(k_start, k_start + milliseconds(10));
    EXPECT_FALSE(pace.pending());
    EXPECT_FALSE(pace.draws(false, k_start + milliseconds(500))) << "nothing happened";
    pace.touch();
    EXPECT_FALSE(pace.draws(false, k_start + milliseconds(12)));
    EXPECT_TRUE(pace.draws(true, k_start + milliseconds(12)));
    EXPECT_NEAR(pace.left(k_start + milliseconds(12)).count(), 0.028, 1e-6) << "three times as long as it took";
    EXPECT_TRUE(pace.draws(false, k_start + milliseconds(40)));
}

TEST(WindowPace, AViewThatMovedWaitsForLessTime)
{
    WindowPace pace;
    pace.drawn(k_start, k_start + milliseconds(10));
    pace.move_view(true);
    EXPECT_TRUE(pace.pending());
    EXPECT_FALSE(pace.draws(false, k_start + milliseconds(19)));
    EXPECT_TRUE(pace.draws(false, k_start + milliseconds(20)));
    pace.move_view(false);
    EXPECT_FALSE(pace.draws(false, k_start + milliseconds(500))) << "the window shows it";
}

TEST(WindowPace, FramesFollowAnInputWithoutWaiting)
{
    WindowPace pace;
    pace.touch();
    int frames = 0;
    while (pace.settles()) pace.begin_frame(), ++frames;
    EXPECT_EQ(frames, WindowPace::k_settling);
    EXPECT_TRUE(pace.pending()) << "the last of them is drawn";
    pace.drawn(k_start, k_start + milliseconds(900));
    EXPECT_FALSE(pace.pending());
    pace.touch_once();
    EXPECT_FALSE(pace.settles());
    EXPECT_TRUE(pace.draws(false, k_start + milliseconds(1001))) << "a slow screen is drawn ten times a second";
}

// Images that take too long become coarse at once, and finer step by step.
TEST(MotionSize, FollowsTheTimeThatImagesTake)
{
    MotionSize size;
    const auto settle = [&](double fixed, double whole) {   // whole: of an image with all pixels
        int images = 0;
        for (int calm = 0; calm < 10; ++images) {
            const int before = size.divisor();
            size.add(before, {.ms = fixed + whole / (before * before), .fixed_ms = fixed}, MotionSize::k_held_ms);
            calm = size.divisor() == before ? calm + 1 : 0;
            EXPECT_LT(images, 100) << "it changes for ever";
            if (images >= 100) break;
        }
        return size.divisor();
    };
    EXPECT_EQ(settle(0, 5), 1) << "all pixels";
    // Where something else is shown, the first image is coarse, and the second as fine as the first one allows.
    size.restart();
    EXPECT_EQ(size.divisor(), MotionSize::k_divisors.back());
    size.add(size.divisor(), {.ms = 2}, MotionSize::k_held_ms);
    EXPECT_EQ(size.divisor(), 4) << "18 ms, where 3 takes 32 of the 29.75 ms";
    const int coarse = settle(2, 600);
    EXPECT_LE(2 + 600.0 / (coarse * coarse), MotionSize::k_held_ms);
    EXPECT_GE(2 + 600.0 / ((coarse - 2) * (coarse - 2)), MotionSize::k_spare * MotionSize::k_held_ms - 2);
    EXPECT_EQ(settle(0, 1e6), MotionSize::k_divisors.back());
    // Where any image takes long, few pixels would gain little.
    EXPECT_LE(settle(200, 600), 4);
    const int now = size.divisor();
    size.add(now + 1, {.ms = 1000}, MotionSize::k_held_ms);
    EXPECT_EQ(size.divisor(), now) << "an image of another size";
}

TEST(MotionSize, LimitsTheRaysOfBouncedLightByTheirCost)
{
    const double allowed = MotionSize::k_light * MotionSize::k_held_ms;
    for (const double ms_per_ray : {1e-3, 1e-4}) {
        MotionSize size;
        for (int i = 0; i < 50; ++i)
            size.add(size.divisor(),
                     {.ms = 10, .light_ms = ms_per_ray * static_cast<double>(size.rays()), .rays = size.rays()},
                     MotionSize::k_held_ms);
        EXPECT_NEAR(ms_per_ray * static_cast<double>(size.rays()), allowed, 0.3 * allowed);
        const std::uint64_t before = size.rays();
        size.add(size.divisor(), {.ms = 10, .light_ms = 0.1, .rays = 5}, MotionSize::k_held_ms);
        EXPECT_EQ(size.rays(), before) << "few rays were needed, and say nothing";
    }
}

TEST(Latency, CountsFromTheFirstInputToTheImageThatShowsIt)
{
    Latency latency;
    EXPECT_EQ(latency.summary().inputs, 0u);
    latency.show(7, k_start);
    latency.note(k_start);
    latency.note(k_start + milliseconds(5));   // goes with the one before
    latency.ask(8);
    latency.note(k_start + milliseconds(10));
    latency.show(7, k_start + milliseconds(12));
    EXPECT_EQ(latency.summary().inputs, 0u) << "no image shows it yet";
    latency.ask(9);
    latency.show(9, k_start + milliseconds(30));
    EXPECT_EQ(latency.summary().inputs, 2u);
    EXPECT_NEAR(latency.summary().longest_ms, 30, 1e-6);
    EXPECT_NEAR(latency.summary().median_ms, 30, 1e-6);
    latency.note(k_start);
    latency.ask(10);
    latency.forget();
    latency.show(11, k_start + milliseconds(900));
    EXPECT_EQ(latency.summary().inputs, 2u);
}

// An image that is moved shows all inputs so far; the images that follow show nothing new of them.
TEST(Latency, EndsWhereAnImageIsMoved)
{
    Latency latency;
    latency.note(k_start);
    latency.ask(1);
    latency.note(k_start + milliseconds(5));
    latency.show_all(k_start + milliseconds(20));
    EXPECT_EQ(latency.summary().inputs, 2u);
    EXPECT_NEAR(latency.summary().longest_ms, 20, 1e-6);
    latency.ask(2);
    latency.show(2, k_start + milliseconds(90));
    latency.show_all(k_start + milliseconds(90));
    EXPECT_EQ(latency.summary().inputs, 2u);
}

}   // namespace
}   // namespace gnomon::viewer
#endif
