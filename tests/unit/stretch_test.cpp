// SPDX-License-Identifier: Apache-2.0
// What the viewer's window does with an image and a clip.
#include "viewer/stretch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "viewer/clip_pace.h"

namespace gnomon::viewer {
namespace {

Image8 image_of(int width, int height)
{
    Image8 image;
    image.width = width, image.height = height, image.channels = 3;
    for (int i = 0; i < 3 * width * height; ++i) image.data.push_back(static_cast<std::uint8_t>(37 * i % 251));
    return image;
}

TEST(Stretch, AnImageOfTheSameSizeIsCopied)
{
    const Image8 image = image_of(23, 11);
    Stretcher stretcher;
    const std::vector<std::uint8_t>& bgra = stretcher.stretched(image, {23, 11});
    ASSERT_EQ(bgra.size(), 23u * 11u * 4u);
    for (std::size_t i = 0; i < 23u * 11u; ++i) {
        EXPECT_EQ(bgra[4 * i], image.data[3 * i + 2]);
        EXPECT_EQ(bgra[4 * i + 1], image.data[3 * i + 1]);
        EXPECT_EQ(bgra[4 * i + 2], image.data[3 * i]);
        EXPECT_EQ(bgra[4 * i + 3], 255);
    }
}

// A ramp stays one, up and down, and goes from its first to its last value.
TEST(Stretch, ARampStaysOne)
{
    Image8 image;
    image.width = 8, image.height = 6, image.channels = 3;
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) image.data.push_back(static_cast<std::uint8_t>(10 + 20 * x + 10 * y));
    Stretcher stretcher;
    for (const Size size : {Size{37, 29}, Size{5, 3}, Size{8, 100}, Size{1, 1}}) {
        const std::vector<std::uint8_t>& bgra = stretcher.stretched(image, size);
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                const auto in = [](int at, int from, int to) {
                    return std::clamp((at + 0.5) * from / to - 0.5, 0.0, from - 1.0);
                };
                const double expected = 10 + 20 * in(x, 8, size.width) + 10 * in(y, 6, size.height);
                const std::size_t at = 4 * static_cast<std::size_t>(y * size.width + x);
                EXPECT_NEAR(bgra[at], expected, 1.25) << x << ' ' << y;
            }
    }
}

// While the user moves the view, following the clip takes a part of the time at most.
TEST(ClipPace, FollowingTheClipTakesAPartOfTheTime)
{
    using std::chrono::milliseconds;
    ClipPace pace;
    ClipPace::Clock::time_point now{};
    EXPECT_TRUE(pace.goes_on(now));
    pace.went_on(now);
    EXPECT_TRUE(pace.goes_on(now)) << "nothing is known of what it takes";
    pace.took(20);
    pace.went_on(now);
    EXPECT_FALSE(pace.goes_on(now + milliseconds(79)));
    EXPECT_TRUE(pace.goes_on(now + milliseconds(80)));
    pace.took(0.1);
    pace.went_on(now);
    EXPECT_TRUE(pace.goes_on(now + milliseconds(1)));
}

}   // namespace
}   // namespace gnomon::viewer
