// SPDX-License-Identifier: Apache-2.0
// The rectangles in which two images differ.
#include "image/changed_rectangles.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::image {
namespace {

bool contains(const PixelRectangle& r, int x, int y)
{
    return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
}

bool differs(const ImageF& a, const ImageF& b, int x, int y)
{
    return !std::equal(a.pixel(x, y), a.pixel(x, y) + a.channels, b.pixel(x, y));
}

// Every differing pixel lies in exactly one rectangle, and no edge of a rectangle is without one.
void expect_exact(const ImageF& a, const ImageF& b, const std::vector<PixelRectangle>& rectangles)
{
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) {
            int inside = 0;
            for (const PixelRectangle& r : rectangles) inside += contains(r, x, y);
            EXPECT_LE(inside, 1) << x << " " << y;
            if (differs(a, b, x, y)) {
                EXPECT_EQ(inside, 1) << x << " " << y;
            }
        }
    for (const PixelRectangle& r : rectangles) {
        ASSERT_TRUE(r.x >= 0 && r.y >= 0 && r.width > 0 && r.height > 0);
        ASSERT_TRUE(r.x + r.width <= a.width && r.y + r.height <= a.height);
        bool left = false, right = false, top = false, bottom = false;
        for (int y = r.y; y < r.y + r.height; ++y)
            left = left || differs(a, b, r.x, y), right = right || differs(a, b, r.x + r.width - 1, y);
        for (int x = r.x; x < r.x + r.width; ++x)
            top = top || differs(a, b, x, r.y), bottom = bottom || differs(a, b, x, r.y + r.height - 1);
        EXPECT_TRUE(left && right && top && bottom);
    }
}

TEST(ChangedRectangles, OfKnownDifferences)
{
    Tasks tasks(2);
    const ImageF before(70, 50, 3);
    EXPECT_TRUE(changed_rectangles(before, before, tasks).empty());
    EXPECT_TRUE(changed_rectangles(before, {}, tasks).empty());

    ImageF now = before;
    now.pixel(69, 49)[2] = 1;
    EXPECT_EQ(changed_rectangles(before, now, tasks), (std::vector<PixelRectangle>{{69, 49, 1, 1}}));
    // A block over several tiles is one rectangle.
    for (int y = 10; y < 40; ++y)
        for (int x = 5; x < 45; ++x) now.pixel(x, y)[1] = 2;
    EXPECT_EQ(changed_rectangles(before, now, tasks), (std::vector<PixelRectangle>{{5, 10, 40, 30}, {69, 49, 1, 1}}));
    // A sign of zero is a bit.
    now = before;
    now.pixel(0, 0)[0] = -0.0f;
    EXPECT_EQ(changed_rectangles(before, now, tasks), (std::vector<PixelRectangle>{{0, 0, 1, 1}}));
    // Another size, or no image at all: everything.
    const std::vector<PixelRectangle> whole{{0, 0, 70, 50}};
    EXPECT_EQ(changed_rectangles({}, now, tasks), whole);
    EXPECT_EQ(changed_rectangles(ImageF(50, 70, 3), now, tasks), whole);
}

TEST(ChangedRectangles, AreExactForRandomDifferencesAndAnyThreadCount)
{
    Random random(7);
    Tasks one(1), three(3);
    for (int i = 0; i < 60; ++i) {
        const int width = 1 + static_cast<int>(random.below(100)), height = 1 + static_cast<int>(random.below(80));
        const ImageF before(width, height, 3);
        ImageF now = before;
        for (std::uint32_t n = random.below(12); n > 0; --n) {
            const int x0 = static_cast<int>(random.below(static_cast<std::uint32_t>(width)));
            const int y0 = static_cast<int>(random.below(static_cast<std::uint32_t>(height)));
            for (int y = y0; y < std::min(height, y0 + static_cast<int>(random.below(30))); ++y)
                for (int x = x0; x < std::min(width, x0 + static_cast<int>(random.below(30))); ++x)
                    now.pixel(x, y)[random.below(3)] = 1;
        }
        const std::vector<PixelRectangle> rectangles = changed_rectangles(before, now, one);
        expect_exact(before, now, rectangles);
        EXPECT_EQ(changed_rectangles(before, now, three), rectangles);
    }
}

}   // namespace
}   // namespace gnomon::image
