// SPDX-License-Identifier: Apache-2.0
#include "scene/convex_hull.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"

namespace gnomon::scene {
namespace {

std::vector<glm::dvec2> disc(int count, Random& random)
{
    std::vector<glm::dvec2> points;
    while (static_cast<int>(points.size()) < count) {
        const glm::dvec2 p(random.uniform(-1, 1), random.uniform(-1, 1));
        if (glm::length(p) < 1) points.push_back(glm::dvec2(30, -4) + glm::dvec2(3, 0.5) * p);
    }
    return points;
}

double farthest(const std::vector<glm::dvec2>& points, const glm::dvec2& direction)
{
    double most = -1e9;
    for (const glm::dvec2& p : points) most = std::max(most, glm::dot(p, direction));
    return most;
}

TEST(ConvexHull, ReachesAsFarAsItsPoints)
{
    Random random(3);
    const std::vector<glm::dvec2> points = disc(2000, random);
    std::vector<glm::dvec2> hull = points;
    reduce_to_hull(hull);
    EXPECT_LT(hull.size(), 100u);
    for (int i = 0; i < 64; ++i) {
        const glm::dvec2 direction(std::cos(0.1 * i), std::sin(0.1 * i));
        EXPECT_EQ(farthest(hull, direction), farthest(points, direction)) << i;
    }
}

TEST(ConvexHull, InnerPolygonLiesWithinAndLeavesLittleOut)
{
    Random random(4);
    std::vector<glm::dvec2> hull = disc(2000, random);
    reduce_to_hull(hull);
    const InnerPolygon polygon(hull);
    int inside = 0;
    const std::vector<glm::dvec2> others = disc(20'000, random);
    for (const glm::dvec2& p : others) {
        if (!polygon.contains(p)) continue;
        ++inside;
        std::vector<glm::dvec2> with = hull;
        with.push_back(p);
        for (int i = 0; i < 16; ++i) {
            const glm::dvec2 direction(std::cos(0.4 * i), std::sin(0.4 * i));
            ASSERT_LT(farthest(with, direction), farthest(hull, direction) + 2e-5);
        }
    }
    EXPECT_GT(inside, 19'000);
    EXPECT_FALSE(polygon.contains({30, -5}));
    EXPECT_FALSE(polygon.contains({33.1, -4}));
}

TEST(ConvexHull, NothingIsWithinAPolygonWithoutArea)
{
    std::vector<glm::dvec2> line{{0, 0}, {1, 1}, {2, 2}, {3, 3}};
    reduce_to_hull(line);
    EXPECT_EQ(line.size(), 2u);
    EXPECT_FALSE(InnerPolygon(line).contains({1, 1}));
    EXPECT_FALSE(InnerPolygon().contains({0, 0}));
}

}   // namespace
}   // namespace gnomon::scene
