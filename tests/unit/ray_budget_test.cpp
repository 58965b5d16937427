// SPDX-License-Identifier: Apache-2.0
// How many new cache points a frame with a limit of rays may evaluate, and what stands for the others.
#include "irradiance_cache/ray_budget.h"

#include <gtest/gtest.h>

#include <cmath>

#include "irradiance_cache/points/rough_light.h"

namespace gnomon::irradiance_cache {
namespace {

// Evaluates what a frame grants of ever more points, as tiles ask for them.
// @return  rays
std::uint64_t spend_frame(RayBudget& budget, std::uint64_t rays_of_a_point)
{
    budget.begin_frame();
    std::uint64_t rays = 0;
    for (int tile = 0; tile < 100; ++tile) {
        const std::size_t granted = budget.grant(500);
        budget.settle(granted, granted * rays_of_a_point);
        rays += granted * rays_of_a_point;
    }
    return rays;
}

TEST(RayBudget, AFrameKeepsToItsLimitOnceItKnowsWhatPointsCost)
{
    constexpr std::uint64_t k_limit = 20'000;
    for (const std::uint64_t cost : {20, 300, 2000}) {
        RayBudget budget;
        budget.limit(k_limit);
        EXPECT_LT(spend_frame(budget, cost), 3 * k_limit) << "the first one only guesses";
        const std::uint64_t rays = spend_frame(budget, cost);
        EXPECT_LT(rays, k_limit + 5 * cost) << cost;
        EXPECT_GT(rays, k_limit / 2) << cost;
        EXPECT_TRUE(budget.any_deferred());
    }
}

TEST(RayBudget, TilesShareAFrame)
{
    RayBudget budget;
    budget.limit(100'000);
    budget.begin_frame();
    const std::size_t first = budget.grant(10'000), second = budget.grant(10'000);
    EXPECT_GT(first, 0u);
    EXPECT_GT(2 * second, first);
}

TEST(RayBudget, EveryFrameEvaluatesSomething)
{
    RayBudget budget;
    budget.limit(1);
    for (int frame = 0; frame < 3; ++frame) EXPECT_GT(spend_frame(budget, 1000), 0u);
}

TEST(RayBudget, WithoutALimitAllIsGranted)
{
    RayBudget budget;
    budget.begin_frame();
    EXPECT_EQ(budget.grant(1'000'000), 1'000'000u);
    EXPECT_TRUE(budget.pay(1'000'000));
    EXPECT_FALSE(budget.any_deferred());
}

TEST(RayBudget, WhatIsPaidIsNotLeftForPoints)
{
    RayBudget budget;
    budget.limit(10'000);
    budget.begin_frame();
    while (budget.pay(32)) {
    }
    EXPECT_TRUE(budget.any_deferred());
    EXPECT_LE(budget.grant(500), 4u);
}

// ---- RoughLight

RoughLight in_a_room()
{
    Box3 bounds;
    bounds.add(glm::vec3(0));
    bounds.add(glm::vec3(10));
    return RoughLight(bounds);
}

TEST(RoughLight, IsThatOfPixelsAroundThatFaceTheSameWay)
{
    const glm::vec3 up(0, 1, 0), down(0, -1, 0), at(5, 0, 5);
    RoughLight rough = in_a_room();
    EXPECT_TRUE(rough.empty());
    EXPECT_EQ(rough.at(at, up), glm::vec3(0));
    rough.note({{at, up, glm::vec3(4)}, {at, down, glm::vec3(1)}});
    EXPECT_FALSE(rough.empty());
    EXPECT_GT(rough.at(at, up).x, 3.2f);
    EXPECT_LT(rough.at(at, down).x, 1.8f);
    // Elsewhere, it is the mean of all.
    EXPECT_NEAR(rough.at(glm::vec3(0), up).x, 2.5f, 1e-4f);
}

TEST(RoughLight, ChangesEvenlyAlongASurface)
{
    const glm::vec3 up(0, 1, 0);
    RoughLight rough = in_a_room();
    std::vector<RoughLight::Sample> samples;
    for (int z = 0; z < 100; ++z)
        for (int x = 0; x < 100; ++x) samples.push_back({0.1f * glm::vec3(x, 0, z), up, glm::vec3(x < 50 ? 0 : 10)});
    rough.note(samples);
    float before = rough.at({1, 0, 5}, up).x;
    for (float x = 1; x < 9; x += 0.01f) {
        const float here = rough.at({x, 0, 5}, up).x;
        EXPECT_NEAR(here, before, 1);
        EXPECT_GE(here, before - 1e-4f);
        before = here;
    }
    EXPECT_NEAR(before, 10, 0.1f);
}

TEST(RoughLight, ChangesEvenlyAroundACurve)
{
    const glm::vec3 up(0, 1, 0), right(1, 0, 0), at(5, 0, 5);
    RoughLight rough = in_a_room();
    rough.note({{at, up, glm::vec3(4)}, {at, right, glm::vec3(1)}});
    float before = rough.at(at, up).x;
    EXPECT_GT(before, 3.2f);
    for (float angle = 0; angle < 1.57f; angle += 0.01f) {
        const float here = rough.at(at, {std::sin(angle), std::cos(angle), 0}).x;
        EXPECT_NEAR(here, before, 0.1f) << angle;
        before = here;
    }
    EXPECT_LT(before, 1.8f);
}

TEST(RoughLight, FollowsWhatPixelsReceive)
{
    const glm::vec3 up(0, 1, 0), at(5, 0, 5);
    RoughLight rough = in_a_room();
    for (int frame = 0; frame < 12; ++frame) rough.note({{at, up, glm::vec3(frame < 4 ? 1 : 3)}});
    EXPECT_NEAR(rough.at(at, up).x, 3, 0.02f);
}

}   // namespace
}   // namespace gnomon::irradiance_cache
