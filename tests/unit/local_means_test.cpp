// SPDX-License-Identifier: Apache-2.0
// Means of blocks, as bench indirect prints them.
#include "bench/indirect/local_means.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

using bench::ComparedPoint;
using bench::LocalMeans;

constexpr int k_width = 128;

// Points every 8 pixels of an image of 128 x 64 pixels, each as bright as its reference.
std::vector<ComparedPoint> even_points()
{
    std::vector<ComparedPoint> points;
    for (std::size_t y = 4; y < 64; y += 8)
        for (std::size_t x = 4; x < k_width; x += 8)
            points.push_back({y * k_width + x, glm::vec3(1), glm::vec3(1), glm::vec3(0.01f)});
    return points;
}

bool in_block(const ComparedPoint& point, std::size_t column, std::size_t row)
{
    return point.pixel % k_width / 32 == column && point.pixel / k_width / 32 == row;
}

TEST(LocalMeans, EqualLightDiffersNowhere)
{
    const LocalMeans means = bench::compare_blocks(even_points(), k_width);
    EXPECT_EQ(means.blocks, 8);
    EXPECT_EQ(means.off, 0);
    EXPECT_EQ(means.least, 1);
    EXPECT_EQ(means.greatest, 1);
}

TEST(LocalMeans, FindsABrightAndADarkBlockWhoseMeanIsRight)
{
    std::vector<ComparedPoint> points = even_points();
    for (ComparedPoint& point : points) {
        if (in_block(point, 3, 0)) point.light *= 1.2f;
        if (in_block(point, 0, 1)) point.light *= 0.8f;
    }
    const LocalMeans means = bench::compare_blocks(points, k_width);
    EXPECT_EQ(means.off, 2);
    EXPECT_EQ(means.surely_off, 2);
    EXPECT_NEAR(means.least, 0.8, 1e-6);
    EXPECT_NEAR(means.greatest, 1.2, 1e-6);
}

TEST(LocalMeans, ANoisyReferenceIsNoProof)
{
    std::vector<ComparedPoint> points = even_points();
    for (ComparedPoint& point : points)
        if (in_block(point, 1, 1)) point.light *= 1.2f, point.error = glm::vec3(0.3f);
    const LocalMeans means = bench::compare_blocks(points, k_width);
    EXPECT_EQ(means.off, 1);
    EXPECT_EQ(means.surely_off, 0);   // 16 points of an error of .3: twice .075
}

TEST(LocalMeans, DarkBlocksAreLeftOut)
{
    std::vector<ComparedPoint> points = even_points();
    for (ComparedPoint& point : points)
        if (in_block(point, 2, 1)) point.reference *= 0.04f, point.light *= 0.01f;
    const LocalMeans means = bench::compare_blocks(points, k_width);
    EXPECT_EQ(means.blocks, 7);
    EXPECT_EQ(means.off, 0);
}

}   // namespace
}   // namespace gnomon
