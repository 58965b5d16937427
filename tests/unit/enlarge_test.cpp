// SPDX-License-Identifier: Apache-2.0
// Images of few pixels are enlarged with sharp edges between surfaces.
#ifdef GNOMON_VIEWER
#include "viewer/enlarge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace gnomon::viewer {
namespace {

struct Seen {
    Image8 image;
    std::vector<SeenSurface> surfaces;
};

// An image in which object 1 is dark and object 2 is bright.
Seen seen(int width, int height, const std::function<bool(int, int)>& is_bright)
{
    Seen made;
    made.image.width = width, made.image.height = height, made.image.channels = 3;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool bright = is_bright(x, y);
            for (int channel = 0; channel < 3; ++channel) made.image.data.push_back(bright ? 200 : 40);
            made.surfaces.push_back({bright ? 2u : 1u, glm::vec3(0, 0, 1)});
        }
    return made;
}

TEST(Enlarge, PlainImagesStayPlainAndRampsStayRamps)
{
    for (const int factor : {1, 2, 3, 4}) {
        Seen plain = seen(7, 5, [](int, int) { return true; });
        const Image8 large = enlarged(plain.image, plain.surfaces, factor).image;
        EXPECT_EQ(large.width, 7 * factor);
        EXPECT_EQ(large.height, 5 * factor);
        for (const std::uint8_t value : large.data) ASSERT_EQ(value, 200);
        // A ramp: a cubic B-spline keeps it, away from the rim.
        for (int x = 0; x < 7; ++x)
            for (int y = 0; y < 5; ++y)
                *(plain.image.data.data() + 3 * (y * 7 + x)) = static_cast<std::uint8_t>(20 * x);
        const Image8 ramp = enlarged(plain.image, plain.surfaces, factor).image;
        for (int x = 2 * factor; x < 5 * factor; ++x) {
            const double at = (x + 0.5) / factor - 0.5;
            EXPECT_NEAR(ramp.pixel(x, 2 * factor)[0], 20 * at, 0.6) << factor << ' ' << x;
        }
    }
}

// No place has a colour between those of two surfaces, a slanting border is straight to a fraction of a pixel, and a
// single pixel amid another surface is gone.
TEST(Enlarge, BordersAreSharpLinesWithoutBlocks)
{
    constexpr int k_factor = 4;
    const auto is_beyond = [](double x, double y) { return y > 3.3 + 0.37 * x; };
    const Seen border = seen(20, 16, [&](int x, int y) { return is_beyond(x, y); });
    const Image8 large = enlarged(border.image, border.surfaces, k_factor).image;
    for (int y = 0; y < large.height; ++y)
        for (int x = 0; x < large.width; ++x) {
            const int value = large.pixel(x, y)[0];
            ASSERT_TRUE(value == 40 || value == 200) << value;
            const double px = (x + 0.5) / k_factor - 0.5, py = (y + 0.5) / k_factor - 0.5;
            if (px < 1 || px > 18) continue;
            constexpr double k_off = 0.55;   // pixels of the small image
            const bool surely = is_beyond(px, py - k_off), perhaps = is_beyond(px, py + k_off);
            EXPECT_GE(value, surely ? 200 : 40) << px << ' ' << py;
            EXPECT_LE(value, perhaps ? 200 : 40) << px << ' ' << py;
        }
    const Seen speck = seen(9, 9, [](int x, int y) { return x == 4 && y == 4; });
    for (const std::uint8_t value : enlarged(speck.image, speck.surfaces, k_factor).image.data) ASSERT_EQ(value, 40);
}

// Normals part one object's faces, and not what curves between them.
TEST(Enlarge, FacesOfOneObjectArePartedByTheirNormals)
{
    Seen edge = seen(12, 4, [](int x, int) { return x >= 6; });
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i)
        edge.surfaces[i] = {7, i % 12 < 6 ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1)};
    for (const std::uint8_t value : enlarged(edge.image, edge.surfaces, 3).image.data)
        ASSERT_TRUE(value == 40 || value == 200);
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i) {
        const float angle = 0.3f * static_cast<float>(i % 12);
        edge.surfaces[i].normal = {std::cos(angle), 0, std::sin(angle)};
    }
    const Image8 curved = enlarged(edge.image, edge.surfaces, 3).image;
    int between = 0;
    for (const std::uint8_t value : curved.data) between += value > 60 && value < 180;
    EXPECT_GT(between, 0);
}

// The edge of a shadow is a line as well, and a penumbra goes on from one side to the other.
TEST(Enlarge, ShadowsEndInLines)
{
    Seen edge = seen(12, 4, [](int x, int) { return x >= 6; });
    const auto between = [&] {
        int count = 0;
        for (const std::uint8_t value : enlarged(edge.image, edge.surfaces, 3).image.data)
            count += value != 40 && value != 200;
        return count;
    };
    for (SeenSurface& surface : edge.surfaces) surface = {7, {0, 1, 0}};
    EXPECT_GT(between(), 0) << "one surface";
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i) {
        edge.surfaces[i].lit = i % 12 < 6 ? 3 : 1;
        edge.surfaces[i].unlit = i % 12 < 6 ? 0 : 2;
    }
    EXPECT_EQ(between(), 0) << "the second light is hidden from one half";
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i) {
        const float angle = 0.1f * static_cast<float>(i % 12);
        edge.surfaces[i].normal = {0, std::cos(angle), std::sin(angle)};
    }
    EXPECT_GT(between(), 0) << "it turns away from the light";
    for (SeenSurface& surface : edge.surfaces) surface.normal = {0, 1, 0};
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i)
        if (i % 12 == 5 || i % 12 == 6) edge.surfaces[i].lit = 1, edge.surfaces[i].unlit = 0;
    EXPECT_GT(between(), 0) << "half of the second light is";
}

// A place has the nearness of the surface whose colour it has.
TEST(Enlarge, NearnessGoesWithTheColour)
{
    Seen edge = seen(12, 4, [](int x, int) { return x >= 6; });
    for (std::size_t i = 0; i < edge.surfaces.size(); ++i) edge.surfaces[i].nearness = i % 12 < 6 ? 0.5f : 0.125f;
    for (const int factor : {1, 3}) {
        const EnlargedImage large = enlarged(edge.image, edge.surfaces, factor);
        ASSERT_EQ(large.nearness.size(), static_cast<std::size_t>(12 * factor * 4 * factor));
        for (std::size_t i = 0; i < large.nearness.size(); ++i)
            EXPECT_NEAR(large.nearness[i], large.image.data[3 * i] == 40 ? 0.5f : 0.125f, 1e-6f);
    }
}

TEST(Enlarge, LeavesTheRestToTheScreen)
{
    EXPECT_EQ(enlargement({106, 60}, 12), 4);
    EXPECT_EQ(enlargement({213, 120}, 6), 4);
    EXPECT_EQ(enlargement({426, 240}, 3), 2);
    EXPECT_EQ(enlargement({320, 180}, 2), 2) << "not wider than the view";
    EXPECT_EQ(enlargement({1280, 720}, 1), 1);
}

}   // namespace
}   // namespace gnomon::viewer
#endif
