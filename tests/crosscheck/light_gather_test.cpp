// SPDX-License-Identifier: Apache-2.0
// Sums over light maps against their reference implementations: SIMD against scalar, the compacted cut against the
// published cut, clusters and samples against the sum over all texels.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "base/bits.h"
#include "base/random.h"
#include "light_quadtree/map_light.h"
#include "world.h"

namespace gnomon {
namespace {

using namespace light_quadtree;
using test::World;

// Points in the box, not on a particular surface.
Receivers random_receivers(std::size_t count)
{
    Random random(7);
    Receivers receivers;
    receivers.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const glm::vec3 n(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        receivers.set(i, 0.98f * p, glm::normalize(n + glm::vec3(1e-3f)));
    }
    return receivers;
}

// Points on the walls, floor and ceiling.
Receivers wall_receivers(int a_side)
{
    Receivers receivers;
    receivers.resize(4 * static_cast<std::size_t>(a_side) * static_cast<std::size_t>(a_side));
    std::size_t i = 0;
    for (int y = 0; y < a_side; ++y)
        for (int x = 0; x < a_side; ++x) {
            const float u = (static_cast<float>(x) + 0.5f) * 2 / static_cast<float>(a_side) - 1,
                        v = (static_cast<float>(y) + 0.5f) * 2 / static_cast<float>(a_side) - 1;
            receivers.set(i++, {u, -1, v}, {0, 1, 0});
            receivers.set(i++, {u, 1, v}, {0, -1, 0});
            receivers.set(i++, {-1, u, v}, {1, 0, 0});
            receivers.set(i++, {1, u, v}, {-1, 0, 0});
        }
    return receivers;
}

TEST(LightGather, SimdEqualsScalarToTheBit)
{
    World world("cornell");
    const LightMap map(world.state, world.rays, {}, world.tasks);
    Clusters clusters;
    find_clusters(map, {7, 5}, clusters);
    Receivers receivers = random_receivers(1000);
    gather(clusters, receivers);
    int lit = 0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const glm::vec3 one = gather_one(clusters, {receivers.x[i], receivers.y[i], receivers.z[i]},
                                         {receivers.nx[i], receivers.ny[i], receivers.nz[i]});
        ASSERT_EQ(receivers.irradiance(i), one) << i;
        lit += one != glm::vec3(0);
    }
    EXPECT_GT(lit, 500);
}

// Clusters and samples with each instruction set that the processor and the build support.
TEST(LightGather, SameBitsForEveryInstructionSet)
{
    World world("cornell");
    const LightMap map(world.state, world.rays, {}, world.tasks);
    Clusters clusters;
    find_clusters(map, {7, 5}, clusters);
    Receivers gathered = random_receivers(500), sampled = random_receivers(500);
    const auto light = [&] {
        RsmPlaces places;
        gather(clusters, gathered);
        sample_map(map, {100, 1}, sampled, 0, sampled.x.size(), places);
        std::vector<float> found;
        for (const Receivers* receivers : {&gathered, &sampled})
            for (std::size_t i = 0; i < receivers->size(); ++i)
                for (int c = 0; c < 3; ++c) found.push_back(receivers->irradiance(i)[c]);
        return found;
    };
    const auto choose = [](std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().DeInit();
    };
    const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    ASSERT_GE(targets.size(), 2u) << "a single instruction set leaves nothing to compare";
    const std::vector<float> best = light();
    for (const std::int64_t target : targets) {
        choose(target);
        const std::vector<float> found = light();
        EXPECT_TRUE(same_bits(found, best)) << hwy::TargetName(target);
    }
    choose(0);
}

TEST(LightGather, SampledSumsEqualScalarOnesUpToRounding)
{
    World world("cornell");
    const LightMap map(world.state, world.rays, {}, world.tasks);
    Receivers receivers = random_receivers(300);
    RsmPlaces places;
    const RsmOptions options{100, 0.3f};
    sample_map(map, options, receivers, 0, receivers.x.size(), places);
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const glm::vec3 one = sample_map_one(map, options, {receivers.x[i], receivers.y[i], receivers.z[i]},
                                             {receivers.nx[i], receivers.ny[i], receivers.nz[i]});
        // Weights are multiplied in another order, which rounds once or twice more.
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(receivers.irradiance(i)[c], one[c], 2e-6f * (1e-3f + one[c])) << i;
    }
}

TEST(LightGather, CompactedCutEqualsThePublishedCut)
{
    for (const char* name : {"cornell", "kinetic"}) {
        World world(name);
        for (const float margin : {0.0f, 0.5f}) {
            LightMapOptions small;
            small.side = 128;
            small.validity.margin = margin;
            const LightMap map(world.state, world.rays, small, world.tasks);
            for (const int level : {7, 6, 5, 4, 3, 1}) {
                Clusters clusters;
                find_clusters(map, {7, level}, clusters);
                Receivers receivers = random_receivers(20);
                gather(clusters, receivers);
                for (std::size_t i = 0; i < receivers.size(); ++i) {
                    const glm::vec3 p(receivers.x[i], receivers.y[i], receivers.z[i]);
                    const glm::vec3 n(receivers.nx[i], receivers.ny[i], receivers.nz[i]);
                    ASSERT_EQ(receivers.irradiance(i), gather_as_printed(map, {7, level}, p, n))
                        << name << level << ", margin " << margin;
                }
            }
        }
    }
}

// At level 1 with thresholds that nothing passes, every texel of a map of 512 x 512 is a cluster.
TEST(LightGather, FinestLevelEqualsTheSumOverAllTexels)
{
    World world("cornell");
    LightMapOptions strict;
    strict.validity = {0, 1};
    const LightMap map(world.state, world.rays, strict, world.tasks);
    Clusters all, finest;
    all_texels(map, all);
    find_clusters(map, {7, 1}, finest);
    EXPECT_GT(all.size(), 100000u);
    EXPECT_EQ(finest.size(), all.size());
    Receivers truth = wall_receivers(4), test = wall_receivers(4);
    gather(all, truth);
    gather(finest, test);
    EXPECT_LT(nrmse(test, truth), 1e-4);   // the order of the sum differs
}

// Within the margin of validity, a node and the nodes below it share the light; none is lost or doubled.
TEST(LightGather, SharesKeepTheLightOfTheMap)
{
    World world("cornell");
    Clusters all, cut;
    std::size_t split = 0;
    for (const float margin : {0.0f, 0.3f, 1.0f}) {
        LightMapOptions options;
        options.side = 256;
        options.validity.margin = margin;
        const LightMap map(world.state, world.rays, options, world.tasks);
        all_texels(map, all);
        find_clusters(map, {7, 5}, cut);
        double whole = 0, found = 0;
        for (const float r : all.r) whole += static_cast<double>(r);
        for (const float r : cut.r) found += static_cast<double>(r);
        EXPECT_NEAR(found / whole, 1, 1e-4) << margin;
        for (std::size_t id = 0; id < map.nodes().size(); ++id) {
            const bool partly = map.share(id) != 0 && map.share(id) != k_whole_share;
            if (margin == 0)
                EXPECT_FALSE(partly);
            else
                split += partly;
        }
    }
    EXPECT_GT(split, 50u);
}

// Shadows of clusters: rays for every pair give the same light as remembered modes, while an object moves.
TEST(LightGather, RememberedModesOfPathsEqualRaysToEveryCluster)
{
    World world("cornell");
    LightMapOptions small;
    small.side = 128;
    LightMap map(world.state, world.rays, small, world.tasks);
    PathModes modes;
    std::uint64_t known = 0, dark = 0;
    for (int frame = 1; frame <= 5; ++frame) {
        world.state.advance(world.state.scene().timeline.time_of(frame));
        world.rays.update(world.state);
        map.update(world.state, world.rays, world.tasks);
        Clusters clusters;
        find_clusters(map, {7, 6}, clusters);
        Receivers remembered = wall_receivers(8), plain = wall_receivers(8), unshadowed = wall_receivers(8);
        ShadowScratch scratch, other;
        modes.follow(clusters, remembered);
        gather_with_shadows(clusters, remembered, 0, remembered.x.size(), world.rays, &modes, scratch);
        gather_with_shadows(clusters, plain, 0, plain.x.size(), world.rays, nullptr, other);
        gather(clusters, unshadowed);
        EXPECT_EQ(scratch.counters.rays, other.counters.rays);
        for (std::size_t i = 0; i < plain.size(); ++i) {
            ASSERT_EQ(remembered.irradiance(i), plain.irradiance(i)) << frame << ", " << i;
            // The same rays one by one, in the same order.
            if (i % 16 == 0) {
                glm::vec3 sum(0);
                const glm::vec3 at(plain.x[i], plain.y[i], plain.z[i]), n(plain.nx[i], plain.ny[i], plain.nz[i]);
                for (std::size_t c = 0; c < clusters.size(); ++c)
                    if (cluster_visible(clusters, c, at, n, world.rays)) add_light(clusters, c, at, n, sum);
                ASSERT_EQ(plain.irradiance(i), sum) << frame << ", " << i;
            }
            for (int c = 0; c < 3; ++c) {
                ASSERT_LE(plain.irradiance(i)[c], unshadowed.irradiance(i)[c] * 1.0001f);
                dark += plain.irradiance(i)[c] < 0.99f * unshadowed.irradiance(i)[c];
            }
        }
        const std::uint64_t remembered_paths = scratch.counters.rays_skipped + scratch.counters.rays_dynamic_only;
        if (frame == 1)
            EXPECT_EQ(remembered_paths, 0u);
        else
            known += remembered_paths;
        EXPECT_EQ(other.counters.rays_skipped, 0u);
    }
    EXPECT_GT(known, 1000u);
    EXPECT_GT(dark, 100u);
}

TEST(LightGather, ErrorFallsWithFinerLevelsAndThresholds)
{
    World world("cornell");
    LightMapOptions small;
    small.side = 256;
    Clusters all, some;
    Receivers truth = wall_receivers(24), test = wall_receivers(24);
    {
        const LightMap map(world.state, world.rays, small, world.tasks);
        all_texels(map, all);
        gather(all, truth);
        double before = 1;
        for (const int level : {6, 5, 4}) {
            find_clusters(map, {7, level}, some);
            gather(some, test);
            const double error = nrmse(test, truth);
            EXPECT_LT(error, before) << level;
            before = error;
        }
        EXPECT_LT(before, 0.1);
    }
    double before = 10;
    for (const Validity validity : {Validity{0.45f, 0.3f}, Validity{0.25f, 0.6f}, Validity{0.05f, 0.9f}}) {
        small.validity = validity;
        const LightMap map(world.state, world.rays, small, world.tasks);
        find_clusters(map, {7, 4}, some);
        gather(some, test);
        const double error = nrmse(test, truth);
        EXPECT_LE(error, before) << validity.depth_threshold;
        before = error;
    }
}

TEST(LightGather, ErrorFallsWithMoreSamples)
{
    World world("cornell");
    LightMapOptions small;
    small.side = 256;
    const LightMap map(world.state, world.rays, small, world.tasks);
    Clusters all;
    all_texels(map, all);
    Receivers truth = wall_receivers(16), test = wall_receivers(16);
    gather(all, truth);
    RsmPlaces places;
    double before = 10;
    for (const int samples : {64, 512, 8192}) {
        // The disk covers the map wherever its centre is: the limit of many samples is the full sum.
        sample_map(map, {samples, 1.42f}, test, 0, test.x.size(), places);
        const double error = nrmse(test, truth);
        EXPECT_LT(error, before) << samples;
        before = error;
    }
    EXPECT_LT(before, 0.15);
}

// A square light seen from above: Lambert's formula for the form factor of a parallel square.
TEST(LightGather, AgreesWithAnAnalyticFormFactor)
{
    constexpr int k_side = 64;
    Clusters lights;
    LightNode light;
    light.area = 4.0f / (k_side * k_side);
    light.flux = glm::vec3(light.area);   // radiant exitance 1
    light.normal = {0, 1, 0};
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            light.position = {(static_cast<float>(x) + 0.5f) * 2 / k_side - 1, 0,
                              (static_cast<float>(y) + 0.5f) * 2 / k_side - 1};
            lights.push(light, 0, 6);
        }
    for (const double height : {0.5, 1.0, 3.0}) {
        const double a = 1 / height, root = std::sqrt(1 + a * a);
        const double factor = 4 / k_pi * (a / root) * std::atan(a / root);   // four corners, both terms equal
        const glm::vec3 e = gather_one(lights, {0, static_cast<float>(height), 0}, {0, -1, 0});
        EXPECT_NEAR(static_cast<double>(e.x) / factor, 1, 2e-3) << height;
    }
}

}   // namespace
}   // namespace gnomon
