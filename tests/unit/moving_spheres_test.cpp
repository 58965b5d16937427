// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/moving_spheres.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::irradiance_cache {
namespace {

// Points are inside the same spheres as a search of all finds, and few of the others are visited.
TEST(MovingSpheres, EqualALinearSearch)
{
    Random random(4);
    const auto anywhere = [&] {
        return glm::vec3(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10));
    };
    std::vector<Sphere> all;
    MovingSpheres spheres;
    for (const std::size_t together : {1u, 2u, 7u, 300u, 1u}) {
        std::vector<Sphere> some;
        for (std::size_t i = 0; i < together; ++i) some.push_back({anywhere(), random.uniform(0, 2)});
        all.insert(all.end(), some.begin(), some.end());
        spheres.add(some);
    }
    std::size_t inside = 0, visited = 0;
    constexpr int k_points = 2000;
    for (int i = 0; i < k_points; ++i) {
        const glm::vec3 p = anywhere();
        const auto has = [&](const Sphere& s) { return glm::length(p - s.centre) <= s.radius; };
        std::size_t expected = 0, found = 0;
        for (const Sphere& s : all) expected += has(s);
        const bool stopped = spheres.any(
            [&](const Sphere& s) {
                ++visited;
                return has(s);
            },
            [&](const Sphere&, const MovingBox&) {
                ++found;
                return false;
            });
        EXPECT_FALSE(stopped);
        ASSERT_EQ(found, expected) << i;
        inside += found;
    }
    EXPECT_GT(inside, 500u);
    EXPECT_LT(visited, k_points * all.size() / 4);
}

// A way that comes into a box meets it, however the box is turned, sheared, flattened or mirrored. Others do so only if
// they pass close by.
TEST(MovingBox, MeetsTheWaysThatComeIntoIt)
{
    Random random(5);
    const auto anywhere = [&](float far) {
        return glm::vec3(random.uniform(-far, far), random.uniform(-far, far), random.uniform(-far, far));
    };
    int inside = 0, outside = 0;
    for (int i = 0; i < 20'000; ++i) {
        glm::vec3 half = glm::abs(anywhere(1));
        if (i % 3 == 0) half[i % 9 / 3] = 0;
        const glm::vec3 middle = anywhere(1);
        glm::mat4 to_world(1);
        for (int axis = 0; axis < 3; ++axis) to_world[axis] = glm::vec4(anywhere(1), 0);
        to_world[3] = glm::vec4(anywhere(20), 1);
        if (std::abs(glm::determinant(glm::mat3(to_world))) < 0.05f) continue;
        Box3 own;
        own.add(middle - half), own.add(middle + half);
        const Sphere sphere{transform_point(to_world, middle), 2};
        const MovingBox box = MovingBox::around(own, to_world, sphere);

        // Ways through places in and around it.
        const float wide = i % 2 == 0 ? 1.0f : 3.0f;
        glm::vec3 place = middle + wide * half * anywhere(1);
        if (i % 4 == 1) place += 0.3f * anywhere(1);
        const glm::vec3 through = transform_point(to_world, place), from = through + anywhere(8);
        const float far = random.uniform(0.5f, 2);   // it ends before the place, or beyond it
        const glm::vec3 way = through - from;
        // Hold them against the box in double precision.
        const glm::dmat4 to_own = glm::inverse(glm::dmat4(to_world));
        const glm::dvec3 a(to_own * glm::dvec4(from, 1)), b(to_own * glm::dvec4(way, 0));
        const auto meets = [&](double grown) {
            double begin = 0, end = static_cast<double>(far);
            for (int axis = 0; axis < 3; ++axis) {
                const double size = static_cast<double>(half[axis]) + grown;
                const double s = (static_cast<double>(middle[axis]) - size - a[axis]) / b[axis];
                const double t = (static_cast<double>(middle[axis]) + size - a[axis]) / b[axis];
                begin = std::max(begin, std::min(s, t)), end = std::min(end, std::max(s, t));
            }
            return begin <= end;
        };
        const bool found = meets_way(box, from, way, far);
        if (meets(0)) {
            EXPECT_TRUE(found) << i;
            ++inside;
        } else if (!meets(0.03)) {
            EXPECT_FALSE(found) << i;
            ++outside;
        }
        // Grown, it is met by ways that pass that close by.
        const glm::vec3 aside = 0.99f * glm::normalize(anywhere(1));
        if (meets(0)) {
            EXPECT_TRUE(meets_way(box, from + 0.5f * aside, way, far, 0.5f)) << i;
        }
    }
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 2000);
}

TEST(MovingBox, OfAnObjectThatIsFlattenedToNothingMeetsAll)
{
    Box3 own;
    own.add(glm::vec3(-1)), own.add(glm::vec3(1));
    const glm::mat4 flat(glm::vec4(0), glm::vec4(0), glm::vec4(0), glm::vec4(3, 2, 1, 1));
    const MovingBox box = MovingBox::around(own, flat, {{3, 2, 1}, 0});
    EXPECT_TRUE(meets_way(box, glm::vec3(9), {0, 1, 0}, 1));
    EXPECT_TRUE(meets_way(MovingBox(), glm::vec3(9), {0, 1, 0}, k_infinity));
}

}   // namespace
}   // namespace gnomon::irradiance_cache
