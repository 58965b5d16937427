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

// Shadows of clusters: rays for every pair give the same light as remembered modes and boxes of dynamic objects, while
// an object moves.
TEST(LightGather, RememberedModesOfPathsEqualRaysToEveryCluster)
{
    for (const bool separate : {false, true}) {
        World world("cornell");
        LightMapOptions small;
        small.side = 128;
        small.separate_trees = separate;
        LightMap map(world.state, world.rays, small, world.tasks);
        visibility::DynamicBounds dynamic(world.state, world.rays);
        PathModes modes;
        ShadowCounters first, later;
        std::uint64_t dark = 0;
        for (int frame = 1; frame <= 5; ++frame) {
            world.go(frame);
            map.update(world.state, world.rays, world.tasks);
            dynamic.update(world.state, world.rays);
            Clusters clusters;
            find_clusters(map, {7, 6}, clusters);
            Receivers remembered = wall_receivers(8), plain = wall_receivers(8), unshadowed = wall_receivers(8);
            ShadowScratch scratch, other;
            modes.begin_frame();
            modes.follow(clusters);
            modes.resize(remembered.size());
            std::vector<PathModes::Row*> rows(remembered.x.size(), nullptr);
            for (std::size_t i = 0; i < remembered.size(); ++i)
                rows[i] = modes.of(i, {remembered.x[i], remembered.y[i], remembered.z[i]},
                                   {remembered.nx[i], remembered.ny[i], remembered.nz[i]});
            gather_with_shadows(clusters, remembered, 0, remembered.x.size(), world.rays, {rows, &dynamic}, scratch);
            gather_with_shadows(clusters, plain, 0, plain.x.size(), world.rays, {}, other);
            gather(clusters, unshadowed);
            EXPECT_EQ(scratch.counters.pairs, other.counters.pairs);
            EXPECT_EQ(other.counters.rays, other.counters.pairs);
            EXPECT_EQ(other.counters.left_out + other.counters.rays_dynamic, 0u);
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
            (frame == 1 ? first : later) += scratch.counters;
        }
        EXPECT_GT(dark, 100u);
        EXPECT_EQ(first.rays, first.pairs);
        // Later, most pairs need no ray. Clusters of static objects with a tree of their own are asked for once.
        EXPECT_LT(later.rays, later.pairs / (separate ? 20 : 6));
        EXPECT_LT(later.rays_dynamic, later.pairs / 4);
        EXPECT_GT(later.left_out, later.pairs / 2);
        EXPECT_GE(later.cast() + later.left_out, later.pairs);
    }
}

// A static block that the user moves: what it did to paths is forgotten, also that of pixels.
TEST(LightGather, MovedStaticObjectsMakePathsUnknown)
{
    World world("cornell");
    scene::ObjectId block = scene::none;   // the last one found: not a wall
    for (scene::ObjectId o = 0; o < world.scene->objects.size(); ++o)
        if (!world.scene->objects[o].dynamic) block = o;
    MapLightOptions options;
    options.shadows = true;
    options.map.separate_trees = true;
    options.map.side = 128;
    options.levels.limit = 6;
    options.grid = 0;
    const Receivers walls = wall_receivers(8);
    std::vector<MapReceiver> points;
    for (std::size_t i = 0; i < walls.size(); ++i)
        points.push_back({{walls.x[i], walls.y[i], walls.z[i]},
                          {walls.nx[i], walls.ny[i], walls.nz[i]},
                          0.01f,
                          {static_cast<int>(i) % 16, static_cast<int>(i) / 16}});
    const auto shade = [&](MapLight& light) {
        std::vector<glm::vec3> result(points.size());
        std::vector<std::unique_ptr<MapLight::Batch>> batches;
        batches.push_back(std::make_unique<MapLight::Batch>());
        light.begin_image(16, 16);
        light.shade(*batches[0], points, result.data());
        light.end_frame(batches);
        return result;
    };
    MapLight kept(world.state, world.rays, options, world.tasks);
    std::uint64_t rays[4] = {};
    for (int frame = 1; frame <= 3; ++frame) {
        if (frame == 3) {
            glm::dmat4 there = world.state.world(world.scene->objects[block].node);
            there[3] += glm::dvec4(0.3, 0.3, -0.2, 0);
            world.state.override_transform(world.scene->objects[block].node, &there);
        }
        world.go(frame);
        kept.begin_frame(world.state, world.rays, world.tasks);
        const std::vector<glm::vec3> light = shade(kept);
        rays[frame] = kept.counters().shadow.rays;
        MapLight fresh(world.state, world.rays, options, world.tasks);
        ASSERT_EQ(light, shade(fresh)) << frame;
    }
    EXPECT_GT(rays[1], 10000u);
    EXPECT_LT(rays[2], rays[1] / 20);
    EXPECT_GT(rays[3], rays[1] / 2);
}

// Of two points in one pixel the first one is remembered, without a fault in the other one.
TEST(LightGather, OnePointOfAPixelIsRemembered)
{
    World world("cornell");
    MapLightOptions options;
    options.shadows = true;
    options.map.side = 128;
    options.grid = 0;
    const Receivers walls = wall_receivers(6);
    std::vector<MapReceiver> points;
    for (std::size_t i = 0; i < walls.size(); ++i)
        points.push_back({{walls.x[i], walls.y[i], walls.z[i]},
                          {walls.nx[i], walls.ny[i], walls.nz[i]},
                          0.01f,
                          {static_cast<int>(i / 2) % 16, static_cast<int>(i / 2) / 16}});
    MapLight with(world.state, world.rays, options, world.tasks),
        without(world.state, world.rays, options, world.tasks);
    for (int frame = 1; frame <= 3; ++frame) {
        world.go(frame);
        MapLight::Batch a, b;
        std::vector<glm::vec3> remembered(points.size()), plain(points.size());
        with.begin_frame(world.state, world.rays, world.tasks);
        without.begin_frame(world.state, world.rays, world.tasks);
        with.begin_image(16, 16);
        with.shade(a, points, remembered.data());
        without.shade(b, points, plain.data());
        ASSERT_EQ(remembered, plain) << frame;
        if (frame > 1) {
            EXPECT_LT(a.shadows.counters.cast(), b.shadows.counters.cast() * 3 / 4) << frame;
            EXPECT_GT(a.shadows.counters.cast(), b.shadows.counters.cast() / 4) << frame;
        }
    }
}

// Clusters of separate trees follow the light of all texels more closely from frame to frame than those of one tree, in
// which a mean of object and wall moves as the object passes. The error is the same.
TEST(LightGather, SeparateTreesFlickerLess)
{
    World world("cornell");
    LightMapOptions one, two;
    one.side = two.side = 256;
    two.separate_trees = true;
    LightMap of_one(world.state, world.rays, one, world.tasks), of_two(world.state, world.rays, two, world.tasks);
    std::vector<glm::vec3> before[3];
    double flicker[2] = {}, error[2] = {};
    std::size_t clusters[2] = {};
    for (int frame = 1; frame <= 5; ++frame) {
        world.go(frame);
        of_one.update(world.state, world.rays, world.tasks);
        of_two.update(world.state, world.rays, world.tasks);
        Receivers lit[3] = {wall_receivers(12), wall_receivers(12), wall_receivers(12)};
        Clusters cut;
        all_texels(of_one, cut);
        gather(cut, lit[2]);
        for (int k = 0; k < 2; ++k) {
            find_clusters(k ? of_two : of_one, {7, 6}, cut);
            clusters[k] += cut.size();
            gather(cut, lit[k]);
            error[k] += nrmse(lit[k], lit[2]);
        }
        for (int k = 2; k >= 0; --k) {
            for (std::size_t i = 0; frame > 1 && k < 2 && i < lit[k].size(); ++i) {
                const glm::vec3 change = lit[k].irradiance(i) - before[k][i],
                                true_change = lit[2].irradiance(i) - before[2][i];
                for (int c = 0; c < 3; ++c) flicker[k] += std::abs(static_cast<double>(change[c] - true_change[c]));
            }
        }
        for (int k = 0; k < 3; ++k) {
            before[k].clear();
            for (std::size_t i = 0; i < lit[k].size(); ++i) before[k].push_back(lit[k].irradiance(i));
        }
    }
    EXPECT_GT(flicker[0], 0);
    EXPECT_LT(flicker[1], 0.5 * flicker[0]);
    EXPECT_LT(error[1], 1.02 * error[0]);
    EXPECT_LT(clusters[1], clusters[0] * 11 / 10);
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
    // A receiver that is tilted and stands aside: Lambert's sum over the edges. All of the light is above its horizon.
    const glm::dvec3 corners[] = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    for (const double height : {1.5, 3.0}) {
        const glm::dvec3 at(0.3, height, 0.2), normal = glm::normalize(glm::dvec3(0.5, -1, 0.2));
        double sum = 0;
        for (int k = 0; k < 4; ++k) {
            const glm::dvec3 a = glm::normalize(corners[k] - at), b = glm::normalize(corners[(k + 1) % 4] - at);
            ASSERT_GT(glm::dot(a, normal), 0);
            sum += std::acos(glm::dot(a, b)) * glm::dot(normal, glm::normalize(glm::cross(a, b)));
        }
        const glm::vec3 e = gather_one(lights, glm::vec3(at), glm::vec3(normal));
        EXPECT_NEAR(static_cast<double>(e.x) / (std::abs(sum) / (2 * k_pi)), 1, 5e-3) << height;
    }
}

}   // namespace
}   // namespace gnomon
