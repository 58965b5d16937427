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
            [&](const Sphere&) {
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

}   // namespace
}   // namespace gnomon::irradiance_cache
