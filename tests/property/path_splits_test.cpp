// SPDX-License-Identifier: Apache-2.0
// Where surfaces both reflect and refract, the rays of a pixel are bounded, and bring the light of those left out.
#include <gtest/gtest.h>

#include "trace/path_splits.h"

namespace gnomon::trace {
namespace {

// What a path leads to among surfaces that all have the same weights.
struct Paths {
    glm::vec3 reflected, refracted;
    float least;
    int rays = 0;
    glm::vec3 ends{0};   // throughput at the last depth

    void follow(const glm::vec3& throughput, std::uint8_t splits, int depth)
    {
        if (depth == 0) {
            ends += throughput;
            return;
        }
        glm::vec3 a = reflected, b = refracted;
        const PathSplits next = split_path(throughput, least, splits, a, b);
        const auto continue_with = [&](const glm::vec3& weight, std::uint8_t number) {
            const glm::vec3 left = throughput * weight;
            if (std::max({left.x, left.y, left.z}) < least) return;
            ++rays;
            follow(left, number, depth - 1);
        };
        continue_with(a, next.reflected), continue_with(b, next.refracted);
    }
};

TEST(PathSplitting, AreBoundedAndKeepTheLight)
{
    constexpr int k_depth = 10;
    Paths bright{glm::vec3(0.5f), glm::vec3(0.5f), 1e-6f};
    bright.follow(glm::vec3(1), 0, k_depth);
    EXPECT_LE(bright.rays, 230);   // 2,046 without a bound
    EXPECT_NEAR(bright.ends.x, 1, 1e-5f);

    // The brighter ray goes on.
    Paths colored{{0.25f, 0, 0}, {0.5f, 0.5f, 0.5f}, 1e-6f};
    colored.follow(glm::vec3(1), 0, k_depth);
    EXPECT_LE(colored.rays, 230);
    EXPECT_NEAR(colored.ends.x / std::pow(0.75f, k_depth), 1, 1e-5f);
    EXPECT_NEAR(colored.ends.y / std::pow(0.5f, k_depth), 1, 1e-5f);
}

// Glass reflects so little that dim paths end before the bound: its images stay as they are.
TEST(PathSplitting, GlassIsBelowTheBound)
{
    Paths glass{glm::vec3(0.04f), glm::vec3(0.96f), 1 / 300.0f};
    glass.follow(glm::vec3(1), 0, 10);
    const int rays = glass.rays;
    int unbounded = 0;
    const auto follow = [&](auto&& self, float throughput, int depth) -> void {
        for (const float weight : {0.04f, 0.96f}) {
            if (depth == 0 || throughput * weight < 1 / 300.0f) continue;
            ++unbounded;
            self(self, throughput * weight, depth - 1);
        }
    };
    follow(follow, 1, 10);
    EXPECT_EQ(rays, unbounded);
}

}   // namespace
}   // namespace gnomon::trace
