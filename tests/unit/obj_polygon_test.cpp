// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/random.h"
#include "io/obj/polygon.h"

namespace gnomon::io {
namespace {

double area(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::dvec3& up)
{
    return 0.5 * glm::dot(glm::cross(glm::dvec3(b - a), glm::dvec3(c - a)), up);
}

// A polygon is filled exactly if no triangle is flipped and the areas add up to the polygon's.
void expect_filled(const std::vector<glm::vec3>& points)
{
    PolygonTriangulator triangulator;
    const auto& triangles = triangulator.triangulate(points);
    ASSERT_EQ(triangles.size(), points.size() - 2);
    const glm::dvec3 normal = newell_normal(points);
    double sum = 0;
    for (const glm::uvec3& t : triangles) {
        const double one = area(points[t.x], points[t.y], points[t.z], glm::normalize(normal));
        EXPECT_GE(one, -1e-5 * glm::length(normal));
        sum += one;
    }
    EXPECT_NEAR(sum, 0.5 * glm::length(normal), 1e-4 * glm::length(normal));
}

TEST(ObjPolygon, FillsConcavePolygons)
{
    expect_filled({{0, 0, 0}, {2, 0, 0}, {0.5f, 0.5f, 0}, {0, 2, 0}});   // an arrowhead
    expect_filled({{0.5f, 0.5f, 0}, {0, 2, 0}, {0, 0, 0}, {2, 0, 0}});   // starting at the notch
    expect_filled({{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});   // a U
    expect_filled({{0, 0, 0}, {0, 1, 3}, {0, 1, 0.1f}, {0, 3, 0}, {0, 1, -0.1f}, {0, 1, -3}});
}

TEST(ObjPolygon, FillsStarsInAnyOrientation)
{
    Random random(7);
    for (int trial = 0; trial < 200; ++trial) {
        const int n = 4 + static_cast<int>(random.below(40));
        glm::vec3 s, t;
        const glm::vec3 normal = glm::normalize(
            glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) + glm::vec3(1e-3f));
        make_basis(normal, s, t);
        std::vector<glm::vec3> points;
        for (int i = 0; i < n; ++i) {
            const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(n);
            const float radius = random.uniform(0.3f, 1.0f);
            points.push_back(100.0f * normal + radius * (std::cos(angle) * s + std::sin(angle) * t));
        }
        expect_filled(points);
    }
}

TEST(ObjPolygon, FillsPolygonsWithCollinearCorners)
{
    // A rectangle with corners along its sides, starting in the middle of one.
    expect_filled({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {3, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}, {0, 0, 0}});
}

TEST(ObjPolygon, GivesTwoTrianglesLessThanCorners)
{
    const std::vector<std::vector<glm::vec3>> degenerate = {
        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1, 0, 0}},
        {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},   // a bow tie
        {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}},
    };
    PolygonTriangulator triangulator;
    for (const auto& points : degenerate) {
        const auto& triangles = triangulator.triangulate(points);
        EXPECT_EQ(triangles.size(), points.size() - 2);
        for (const glm::uvec3& t : triangles) EXPECT_LT(std::max({t.x, t.y, t.z}), points.size());
    }
}

TEST(ObjPolygon, FillsHugePolygonsWithoutEarsInTime)
{
    // All corners but one lie on a line, back and forth: every search for an ear fails after a full round.
    std::vector<glm::vec3> points{{0, 1, 0}};
    Random random(1);
    for (int i = 0; i < 400000; ++i) points.emplace_back(random.uniform(-1, 1), 0, 0);
    PolygonTriangulator triangulator;
    EXPECT_EQ(triangulator.triangulate(points).size(), points.size() - 2);
    EXPECT_TRUE(triangulator.exhausted());
}

TEST(ObjPolygon, FillsHugePolygonsInTime)
{
    std::vector<glm::vec3> star;
    const int n = 60000;
    for (int i = 0; i < n; ++i) {
        const float angle = 6.2831853f * static_cast<float>(i) / n;
        const float radius = i % 2 ? 1.0f : 0.5f;
        star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0f);
    }
    PolygonTriangulator triangulator;
    EXPECT_EQ(triangulator.triangulate(star).size(), star.size() - 2);
}

}   // namespace
}   // namespace gnomon::io
