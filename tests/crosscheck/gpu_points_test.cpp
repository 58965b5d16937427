// SPDX-License-Identifier: Apache-2.0
// Cuts and sums of cache points on the device against those on the CPU, and the irradiance of whole frames by both.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <algorithm>
#include <map>
#include <random>

#include "base/bits.h"
#include "irradiance_cache/irradiance_cache.h"
#include "irradiance_cache/vulkan/gpu_points.h"
#include "scene/view.h"
#include "seen_points.h"
#include "world.h"

namespace gnomon {
namespace {

using namespace irradiance_cache;
using irradiance_cache::NodeId;
using test::World;

class GpuPointsTest : public test::VulkanTest {};

constexpr double k_nodes_that_differ = 1e-3;   // fraction of the nodes of cuts: error bounds at the threshold
constexpr double k_weight_tolerance = 1e-4;    // relative, of weights
constexpr double k_sum_tolerance = 1e-5;       // relative to the sum of all lengths
// If the device traces the rays: of all light, and of the points that differ by more than a fraction of their own.
constexpr double k_grazing_light = 1e-4, k_grazing_points = 0.01, k_grazing_change = 1e-3;
// Relative to a frame's mean irradiance. Where rounding decides whether a node is divided, a cache point has another
// cut, and the pixels around it differ by what the division changes.
constexpr double k_light_tolerance = 2e-5, k_cut_tolerance = 1.5e-3;   // on average, at most

std::vector<CutRequest> some_requests(const World& world, std::size_t count)
{
    std::vector<IndirectPoint> points = test::seen_points(world, 64);
    std::shuffle(points.begin(), points.end(), std::mt19937(5));
    const CutOptions options;
    std::vector<CutRequest> requests;
    for (std::size_t i = 0; i < std::min(count, points.size()); ++i)
        requests.push_back({points[i].position + 1e-3f * points[i].normal, i % 3 ? options.error : 0.2f,
                            points[i].normal, i % 3 ? options.estimate : 0.05f});
    return requests;
}

TEST_F(GpuPointsTest, CutsEqualCpuCuts)
{
    for (const char* name : {"cornell", "kinetic"}) {
        World world(name, 30, 2);
        LightTree tree(world.state, world.rays, {}, world.tasks);
        GpuPoints device(device_);
        device.begin_frame(tree, {});
        const std::vector<CutRequest> requests = some_requests(world, 400);
        PointCuts cuts;
        device.cut(requests, {}, cuts);
        std::size_t all = 0, differ = 0, far = 0;
        std::vector<NodeId> nodes;
        CutScratch scratch;
        std::vector<float> weights;
        for (std::size_t p = 0; p < requests.size(); ++p) {
            CutOptions options;
            options.error = requests[p].error, options.estimate = requests[p].estimate;
            cut_tree(tree, options, requests[p].origin, requests[p].normal, nodes, weights, scratch);
            std::map<NodeId, float> weight_of;
            for (std::size_t k = 0; k < nodes.size(); ++k) weight_of[nodes[k]] = weights[k];
            all += nodes.size();
            std::size_t common = 0;
            for (std::uint32_t k = cuts.first[p]; k < cuts.first[p + 1]; ++k) {
                const auto found = weight_of.find(cuts.node[k]);
                if (found == weight_of.end()) continue;
                ++common;
                const double w = static_cast<double>(found->second);
                far += std::abs(static_cast<double>(cuts.weight[k]) - w) > k_weight_tolerance * w;
            }
            differ += nodes.size() - common + (cuts.first[p + 1] - cuts.first[p] - common);
        }
        EXPECT_GT(all, 10 * requests.size()) << name;
        EXPECT_LE(static_cast<double>(differ), k_nodes_that_differ * static_cast<double>(all)) << name;
        EXPECT_LE(static_cast<double>(far), k_nodes_that_differ * static_cast<double>(all)) << name;
        EXPECT_LE(device.long_cuts(), 2u) << name;   // of thousands
    }
}

TEST_F(GpuPointsTest, LongCutsAreMadeByTheCpu)
{
    World world("cornell", 3, 2);
    LightTree tree(world.state, world.rays, {}, world.tasks);
    GpuPoints device(device_);
    device.begin_frame(tree, {});
    std::vector<CutRequest> requests = some_requests(world, 8);
    for (std::size_t p = 0; p < requests.size(); ++p) requests[p].error = p % 2 ? 1e-5f : 4e-3f;
    PointCuts cuts;
    device.cut(requests, {}, cuts);
    EXPECT_GT(device.long_cuts(), 0u);
    EXPECT_LT(device.long_cuts(), requests.size());
    for (std::size_t p = 0; p < requests.size(); ++p) {
        CutOptions options;
        options.error = requests[p].error;
        options.estimate = requests[p].estimate;
        std::vector<NodeId> nodes;
        CutScratch scratch;
        std::vector<float> weights;
        cut_tree(tree, options, requests[p].origin, requests[p].normal, nodes, weights, scratch);
        const std::uint32_t count = cuts.first[p + 1] - cuts.first[p];
        if (nodes.size() > GNOMON_CUT_ROOM + 10) {
            ASSERT_EQ(count, nodes.size());
            EXPECT_TRUE(std::equal(nodes.begin(), nodes.end(), cuts.node.begin() + cuts.first[p]));
        }
    }
}

// After lists were replaced, sums use the new lists and the current flux, without paths that cross dynamic objects.
TEST_F(GpuPointsTest, SumsEqualCpuSums)
{
    World world("cornell", 3, 2);
    LightTree tree(world.state, world.rays, {}, world.tasks);
    MovingSpheres dynamic_objects;
    dynamic_objects.add({{{0.3f, -0.5f, 0.2f}, 0.25f}, {{-0.4f, 0.1f, -0.1f}, 0.1f}});
    GpuPoints device(device_);
    device.begin_frame(tree, dynamic_objects);
    std::mt19937 random(11);
    const std::vector<CutRequest> requests = some_requests(world, 200);
    std::vector<SumRequest> points(requests.size());
    std::vector<std::vector<SeenNode>> seen(points.size());
    std::size_t crossings = 0, dark = 0;
    for (int round = 0; round < 6; ++round) {
        if (round > 0) {
            world.go(3 + 4 * round);   // the flux of some leaves changes
            tree.update(world.state, world.rays, world.tasks);
            device.begin_frame(tree, dynamic_objects);
        }
        // Replace the lists of a third of the points.
        std::vector<SeenNode> sent;
        std::vector<KeptNodes> lists;
        std::vector<std::size_t> of;
        for (std::size_t p = 0; p < points.size(); ++p) {
            if (round > 0 && random() % 3 != 0) continue;
            if (points[p].seen.count > 0) device.forget(points[p].seen);
            points[p].origin = requests[p].origin;
            seen[p].clear();
            const std::size_t count = random() % 90;
            while (seen[p].size() < count) {
                const auto node = static_cast<NodeId>(random() % tree.size());
                if (tree.static_flux().at(node) != glm::vec3(0))
                    seen[p].push_back(pack_seen(node, std::ldexp(1.0f + static_cast<float>(random() % 997) / 997, -6)));
            }
            sent.insert(sent.end(), seen[p].begin(), seen[p].end());
            sent.resize((sent.size() + k_seen_step - 1) / k_seen_step * k_seen_step, 0);
            lists.push_back({0, static_cast<std::uint32_t>(count)});
            of.push_back(p);
        }
        device.keep(sent, lists);
        for (std::size_t k = 0; k < of.size(); ++k) points[of[k]].seen = lists[k];
        PointSums sums;
        device.sum(points, sums);

        ASSERT_EQ(sums.light.size(), points.size());
        auto crossed = sums.crossed.begin();
        for (std::size_t p = 0; p < points.size(); ++p) {
            std::vector<ChangedNode> changed;
            std::vector<SeenNode> padded = seen[p];
            padded.resize((padded.size() + k_seen_step - 1) / k_seen_step * k_seen_step, 0);
            find_changed(tree, padded.data(), points[p].seen.count, points[p].origin, dynamic_objects, changed);
            std::vector<bool> crosses(seen[p].size(), false);
            for (const ChangedNode& node : changed) crosses[node.place] = node.crossed;
            glm::dvec3 sum[3] = {};
            double size = 0;
            for (std::size_t k = 0; k < seen[p].size(); ++k) {
                const NodeId node = seen_node(seen[p][k]);
                const glm::dvec3 flux(tree.flux().at(node));
                dark += flux == glm::dvec3(0);
                if (crosses[k] && flux != glm::dvec3(0)) {
                    ASSERT_NE(crossed, sums.crossed.end());
                    EXPECT_EQ(crossed->point, p);
                    EXPECT_EQ(crossed->place, k);
                    EXPECT_EQ(crossed->seen, seen[p][k]);
                    ++crossed, ++crossings;
                    continue;
                }
                const glm::dvec3 to(tree.samples().at(node) - points[p].origin);
                const double weight = static_cast<double>(seen_weight(seen[p][k]));
                for (int c = 0; c < 3; ++c) sum[c] += flux[c] * weight * glm::normalize(to);
                size += glm::length(flux) * weight;
            }
            for (int c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis)
                    ASSERT_NEAR(static_cast<double>(sums.light[p].of[c][axis]), sum[c][axis],
                                k_sum_tolerance * size + 1e-12)
                        << round << ", point " << p;
        }
        EXPECT_EQ(crossed, sums.crossed.end());
    }
    EXPECT_GT(crossings, 500u);
    EXPECT_GT(dark, 0u) << "no leaf is occluded by a dynamic object: the test is too weak";
}

TEST_F(GpuPointsTest, GrowsTheListOfCrossedPaths)
{
    World world("cornell", 3, 2);
    LightTree tree(world.state, world.rays, {}, world.tasks);
    MovingSpheres dynamic_objects;
    dynamic_objects.add({{{0, 0, 0}, 100.0f}});   // everything is inside
    GpuPoints device(device_);
    device.begin_frame(tree, dynamic_objects);
    NodeId lit = 0;
    while (tree.flux().at(lit) == glm::vec3(0)) ++lit;
    constexpr std::uint32_t k_length = 1600, k_points = 20;
    std::vector<SeenNode> sent(k_length, pack_seen(lit, 0.5f));
    std::vector<KeptNodes> list{{0, k_length}};
    device.keep(sent, list);
    const std::vector<SumRequest> points(k_points, {glm::vec3(0.1f), list[0]});
    PointSums sums;
    device.sum(points, sums);
    ASSERT_EQ(sums.crossed.size(), std::size_t{k_length} * k_points);
    for (std::size_t i = 0; i < sums.crossed.size(); ++i) {
        ASSERT_EQ(sums.crossed[i].point, i / k_length);
        ASSERT_EQ(sums.crossed[i].place, i % k_length);
    }
    for (const PointSums::Light& light : sums.light) EXPECT_EQ(light.of[0], glm::vec3(0));
}

// The irradiance at the surfaces that a camera sees, in the last of some frames.
struct Lighting {
    std::shared_ptr<vk::Device> device;   // null: CPU only
    int threads = 2;
    std::size_t memory = 16u << 20;
    std::uint64_t most_rays = 0;
    bool traces = false;   // the device traces rays, too
    Arithmetic arithmetic = Arithmetic::portable;

    std::vector<glm::vec3> operator()(const char* name, const std::vector<int>& frames, int side = 96) const
    {
        World world(name, frames.front(), threads, arithmetic);
        CacheOptions options;
        options.memory = options.ample_memory = memory;
        IrradianceCache visible(world.state, world.rays, options, world.tasks);
        std::unique_ptr<gpu_scene::GpuScene> scene;
        GpuPoints* engine = nullptr;
        if (device) {
            auto made = std::make_unique<GpuPoints>(device);
            engine = made.get();
            visible.use_device(std::move(made));
        }
        if (traces) {
            scene = std::make_unique<gpu_scene::GpuScene>(device, world.state);
            engine->trace_with(std::make_unique<ray::DeviceRays>(device, *scene, world.state), *scene);
        }
        visible.limit_rays(most_rays);
        const auto follow = [&] {
            if (!traces) return;
            vk::Commands commands(device);
            scene->update(commands, world.state);
            engine->rays()->update(commands, *scene, world.state);
            commands.submit();
        };
        std::vector<glm::vec3> light;
        for (std::size_t f = 0; f < frames.size(); ++f) {
            if (f > 0) world.go(frames[f]);
            if (f > 0) follow();
            light_frame(world, visible, side, light);
            for (int more = 0; visible.lacks_points() && more < 300; ++more) {
                world.go(frames[f]);
                follow();
                light_frame(world, visible, side, light);
            }
        }
        return light;
    }

 private:
    static void light_frame(World& world, IrradianceCache& visible, int side, std::vector<glm::vec3>& light)
    {
        visible.update(world.state, world.rays, world.tasks);
        std::vector<std::unique_ptr<IrradianceCache::Batch>> batches;
        for (int t = 0; t < world.tasks.threads(); ++t) batches.push_back(visible.make_batch());
        const std::vector<IndirectPoint> points = test::seen_points(world, side);
        light.assign(points.size(), glm::vec3(-1));
        constexpr std::size_t k_some = 512;
        visible.for_each((points.size() + k_some - 1) / k_some, batches, world.tasks,
                         [&](std::size_t part, int worker) {
                             const std::size_t first = part * k_some, count = std::min(k_some, points.size() - first);
                             return visible.shade(*batches[static_cast<std::size_t>(worker)],
                                                  {points.data() + first, count}, light.data() + first);
                         });
        visible.end_frame(batches);
    }
};

// By the brightest colour.
struct Difference {
    double mean, most;   // relative to the mean of the first
};

Difference difference(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b)
{
    EXPECT_EQ(a.size(), b.size());
    double sum = 0, all = 0, most = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        sum += static_cast<double>(a[i].x + a[i].y + a[i].z) / 3;
        const glm::vec3 off = glm::abs(a[i] - b[i]);
        const auto largest = static_cast<double>(std::max({off.x, off.y, off.z}));
        most = std::max(most, largest), all += largest;
    }
    return {all / sum, most / (sum / static_cast<double>(a.size()))};
}

TEST_F(GpuPointsTest, IrradianceIsCloseToCpu)
{
    for (const char* name : {"cornell", "kinetic"}) {   // a ball and its shadow; a sky, leaves, many dynamic objects
        const std::vector<glm::vec3> by_cpu = Lighting{}(name, {20, 21}), by_device = Lighting{device_}(name, {20, 21});
        const Difference off = difference(by_cpu, by_device);
        EXPECT_LE(off.mean, k_light_tolerance) << name;
        EXPECT_LE(off.most, k_cut_tolerance) << name;
    }
}

TEST_F(GpuPointsTest, SameBytesAfterAnyFramesAndForAnyThreadCount)
{
    for (const char* name : {"cornell", "kinetic"}) {
        const std::vector<glm::vec3> cold = Lighting{device_, 1}(name, {8}, 64);
        if (std::string(name) == "cornell") {
            EXPECT_TRUE(same_bits(cold, Lighting{device_, 3}(name, {6, 7, 8}, 64)));
        }
        EXPECT_TRUE(same_bits(cold, Lighting{device_, 2, 1 << 12}(name, {20, 3, 8}, 64))) << name << ": memory limit";
        EXPECT_FALSE(same_bits(cold, Lighting{device_, 1}(name, {7}, 64))) << name << ": dynamic objects move";
    }
}

// Rays that graze an edge may differ: at few points, for one of their nodes or directions of the sky. Where that is a
// lattice point, all pixels around it change, each by a fraction of what the ray brings.
TEST_F(GpuPointsTest, IrradianceByDeviceRaysIsCloseToCpu)
{
    if (!ray::DeviceRays::supported(*device_)) GTEST_SKIP() << "the device traces no rays";
    for (const char* name : {"cornell", "kinetic"}) {
        // Rays along edges where surfaces meet are decided by rounding, which devices do as Embree does.
        Lighting cpu;
        cpu.arithmetic = Arithmetic::native;
        const std::vector<glm::vec3> by_cpu = cpu(name, {20, 21}, 64);
        Lighting by_rays{device_};
        by_rays.traces = true, by_rays.arithmetic = Arithmetic::native;
        const std::vector<glm::vec3> by_device = by_rays(name, {20, 21}, 64);
        ASSERT_EQ(by_device.size(), by_cpu.size());
        double sum = 0, off = 0;
        std::size_t differ = 0;
        for (std::size_t i = 0; i < by_device.size(); ++i) {
            const auto a = static_cast<double>(by_cpu[i].y), b = static_cast<double>(by_device[i].y);
            sum += a, off += std::abs(a - b);
            differ += std::abs(a - b) > k_grazing_change * std::max(a, b) + 1e-6;
        }
        EXPECT_LE(off, k_grazing_light * sum) << name;
        EXPECT_LE(static_cast<double>(differ), k_grazing_points * static_cast<double>(by_device.size())) << name;
        EXPECT_TRUE(same_bits(by_device, by_rays(name, {21}, 64))) << name << ": same bytes without earlier frames";
    }
}

TEST_F(GpuPointsTest, LimitedRaysConvergeToTheFullFrame)
{
    const std::vector<glm::vec3> all = Lighting{device_}("cornell", {3}),
                                 few = Lighting{device_, 2, 16u << 20, 1 << 14}("cornell", {3});
    EXPECT_TRUE(same_bits(all, few));
}

}   // namespace
}   // namespace gnomon

#else
TEST(GpuPointsTest, LeftOut)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
