// SPDX-License-Identifier: Apache-2.0
// The vectorised kernels of the irradiance cache against plain loops.
#include "irradiance_cache/light_tree/point_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using namespace irradiance_cache;
using irradiance_cache::NodeId;

struct World {
    std::shared_ptr<const scene::Scene> scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state{scene, scene->timeline.time_of(3)};
    ray::RayScene rays{state};
    Tasks tasks{1};
    LightTree tree{state, rays, LightTreeOptions{}, tasks};

    // Random nodes with flux, with random weights.
    std::vector<SeenNode> some(std::uint32_t count, unsigned seed) const
    {
        std::mt19937 random(seed);
        std::vector<SeenNode> seen;
        while (seen.size() < count) {
            const auto node = static_cast<NodeId>(random() % tree.size());
            if (tree.static_flux().at(node) == glm::vec3(0)) continue;
            seen.push_back(pack_seen(node, std::ldexp(1.0f + static_cast<float>(random() % 1000) / 1000, -4)));
        }
        seen.resize((count + k_seen_step - 1) / k_seen_step * k_seen_step, 0);
        return seen;
    }
};

TEST(PointKernels, PackedNodeKeepsNumberAndApproximateWeight)
{
    std::mt19937 random(7);
    for (int i = 0; i < 100000; ++i) {
        const NodeId node = random() & ((1u << k_node_bits) - 1);
        const float weight =
            std::ldexp(1 + static_cast<float>(random() % 4096) / 4096, static_cast<int>(random() % 120) - 60);
        const SeenNode seen = pack_seen(node, weight);
        ASSERT_EQ(seen_node(seen), node);
        ASSERT_NEAR(seen_weight(seen) / weight, 1, 1.0f / 256) << weight;
        ASSERT_NE(seen, 0u) << "0 is padding";
    }
    EXPECT_GT(seen_weight(pack_seen(1, 1e-30f)), 0);
    EXPECT_TRUE(std::isfinite(seen_weight(pack_seen(1, 1e30f))));
}

TEST(PointKernels, SumEqualsPlainLoop)
{
    const World world;
    const glm::vec3 origin(0.1f, -0.9f, 0.2f);
    for (const std::uint32_t count : {0u, 1u, 15u, 16u, 17u, 203u}) {
        const std::vector<SeenNode> seen = world.some(count, count);
        glm::vec3 light[3];
        sum_seen(world.tree, seen.data(), static_cast<std::uint32_t>(seen.size()), origin, light);
        glm::dvec3 sum[3] = {};
        double size = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const NodeId node = seen_node(seen[k]);
            const glm::dvec3 to(world.tree.samples().at(node) - origin), flux(world.tree.static_flux().at(node));
            for (int c = 0; c < 3; ++c)
                sum[c] += flux[c] * static_cast<double>(seen_weight(seen[k])) * glm::normalize(to);
            size += glm::length(flux) * static_cast<double>(seen_weight(seen[k]));
        }
        for (int c = 0; c < 3; ++c)
            for (int axis = 0; axis < 3; ++axis)
                EXPECT_NEAR(static_cast<double>(light[c][axis]), sum[c][axis], 1e-5 * size) << count;
    }
}

TEST(PointKernels, CutApproximatesAllLeaves)
{
    const World world;
    std::mt19937 random(11);
    const auto number = [&] { return static_cast<float>(random() % 2000) / 1000 - 1; };
    std::vector<NodeId> nodes;
    CutScratch scratch;
    std::vector<float> weights;
    double sum = 0, brute_sum = 0, worst = 0, below = 0;
    for (int i = 0; i < 40; ++i) {
        const glm::vec3 origin = 0.9f * glm::vec3(number(), number(), number());
        const glm::vec3 normal = glm::normalize(glm::vec3(number(), number(), number()) + glm::vec3(1e-3f));
        cut_tree(world.tree, {}, origin, normal, nodes, weights, scratch);
        double light = 0, brute = 0;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const auto part = static_cast<double>(weights[k] * world.tree.quad(nodes[k] / 4).flux[nodes[k] % 4]);
            light += part;
            if (glm::dot(world.tree.samples().at(nodes[k]) - origin, normal) <= 0) below += part;
        }
        for (NodeId id = 0; id < world.tree.size(); ++id) {
            if (world.tree.children(id) != scene::none) continue;
            const VirtualLightQuad& quad = world.tree.quad(id / 4);
            const NodeId lane = id % 4;
            if (!(quad.flux[lane] > 0)) continue;
            const glm::dvec3 to(glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - origin);
            const double d2 = glm::dot(to, to);
            const double r = glm::dot(to, glm::dvec3(normal)) / std::sqrt(d2);
            const double e = -glm::dot(to, glm::dvec3(quad.nx[lane], quad.ny[lane], quad.nz[lane])) / std::sqrt(d2);
            if (r <= 0 || e <= 0) continue;
            brute += static_cast<double>(quad.flux[lane]) * r * e / (k_pi * d2 + static_cast<double>(quad.area[lane]));
        }
        sum += light, brute_sum += brute;
        worst = std::max(worst, std::abs(light - brute) / brute);
        EXPECT_LT(nodes.size(), 2000u);
    }
    EXPECT_NEAR(sum / brute_sum, 1, 0.01);
    EXPECT_LT(worst, 0.06);
    EXPECT_LT(below / sum, 0.002) << "lost: the sample of the node is below the horizon";
}

TEST(PointKernels, FindsEachUnevenPatchAroundAPoint)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("spheres?objects=60&dynamic=0"));
    const scene::SceneState state{scene, scene->timeline.time_of(1)};
    const ray::RayScene rays{state};
    Tasks tasks{1};
    LightTreeOptions options;
    options.patches.bounces = 2;
    const LightTree tree{state, rays, options, tasks};
    ASSERT_TRUE(tree.patch_light());
    const std::span<const patches::Patch> patches = tree.patch_light()->patches().patches();
    std::vector<NodeId> parent_of(tree.size() / 4, scene::none);   // by quad
    for (NodeId id = tree.first_patch(); id < tree.size(); ++id)
        if (tree.children(id) != scene::none) parent_of[tree.children(id)] = id;
    const auto is_below = [&](NodeId above, NodeId node) {
        while (node != scene::none && node != above) node = parent_of[node / 4];
        return above != scene::none && node == above;
    };
    MarkedNodes but;
    but.resize(tree.size());
    std::vector<NodeId> found, stack;
    std::size_t all = 0, marked = 0;
    for (std::size_t p = 0; p < patches.size(); p += 1 + patches.size() / 50) {
        const glm::vec3 origin = patches[p].position + 0.5f * patches[p].radius * glm::vec3(0.6f, -0.3f, 0.4f);
        // Leave out one of them, and another's parent with all below.
        const NodeId left_out = tree.node_of(static_cast<patches::PatchId>(p));
        const NodeId parent = p % 2 == 0 ? parent_of[left_out / 4] : scene::none;
        but.mark(left_out);
        if (parent != scene::none) but.mark(parent);
        find_uneven(tree, origin, but, found, stack);
        but.unmark(left_out);
        if (parent != scene::none) but.unmark(parent);
        std::vector<NodeId> expected;
        for (patches::PatchId other = 0; other < patches.size(); ++other) {
            const NodeId node = tree.node_of(other);
            const patches::Patch& patch = patches[other];
            if (!(tree.quad(node / 4).flux[node % 4] > 0) || !(glm::dot(patch.normal, patch.normal) < 0.98f)) continue;
            if (!(PatchLight::k_uneven_reach * patch.radius > glm::length(patch.position - origin))) continue;
            if (node == left_out || is_below(parent, node))
                ++marked;
            else
                expected.push_back(node);
        }
        std::ranges::sort(found);
        std::ranges::sort(expected);
        EXPECT_EQ(found, expected) << p;
        all += expected.size();
    }
    EXPECT_GT(all, 50u);
    EXPECT_GT(marked, 10u);
}

TEST(PointKernels, FindsNodesThatDynamicObjectsMayChange)
{
    const World world;
    ASSERT_TRUE(world.tree.any_differs()) << "the ball occludes some light";
    std::mt19937 random(3);
    const auto number = [&] { return static_cast<float>(random() % 2000) / 1000 - 1; };
    std::size_t found = 0, tested = 0;
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 origin(number(), number(), number());
        const auto count = static_cast<std::uint32_t>(random() % 100);
        const std::vector<SeenNode> seen = world.some(count, static_cast<unsigned>(round));
        MovingSpheres dynamic_objects;
        std::vector<Sphere> each;
        for (std::uint32_t group = 0; group < 3; ++group) {
            std::vector<Sphere> together;
            const glm::vec3 middle(number(), number(), number());
            for (int m = 0; m < 4; ++m)
                together.push_back({middle + 0.1f * glm::vec3(number(), number(), number()), 0.05f});
            each.insert(each.end(), together.begin(), together.end());
            dynamic_objects.add(std::move(together));
        }
        std::vector<ChangedNode> changed;
        find_changed(world.tree, seen.data(), count, origin, dynamic_objects, changed);
        std::size_t next = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const NodeId node = seen_node(seen[k]);
            const glm::dvec3 to(world.tree.samples().at(node) - origin);
            double margin = 1;   // how clearly it passes
            for (const Sphere& sphere : each) {
                const glm::dvec3 at(sphere.centre - origin);
                const double along = std::clamp(glm::dot(at, to) / glm::dot(to, to), 0.0, 1.0);
                margin = std::min(margin, glm::length(at - along * to) - static_cast<double>(sphere.radius));
            }
            const bool differs = world.tree.flux().at(node) != world.tree.static_flux().at(node);
            const bool listed = next < changed.size() && changed[next].place == k;
            if (listed && std::abs(margin) > 1e-4) {
                EXPECT_EQ(changed[next].crossed, margin < 0);
            }
            if (listed) ++next;
            ++tested;
            found += listed;
            if (std::abs(margin) > 1e-4) {
                EXPECT_EQ(listed, differs || margin < 0) << round << " " << k;
            }
        }
        EXPECT_EQ(next, changed.size());
    }
    EXPECT_GT(found, 20u);
    EXPECT_LT(found, tested);
}

// Spheres are met by all ways here, so that boxes decide: as meets_way() does, to the bit.
TEST(PointKernels, HoldsNodesAgainstBoxes)
{
    const World world;
    std::mt19937 random(4);
    const auto number = [&] { return static_cast<float>(random() % 2000) / 1000 - 1; };
    std::size_t crossed = 0, tested = 0;
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 origin(number(), number(), number());
        const auto count = static_cast<std::uint32_t>(random() % 100);
        const std::vector<SeenNode> seen = world.some(count, static_cast<unsigned>(round));
        MovingSpheres dynamic_objects;
        std::vector<MovingBox> each;
        for (int object = 0; object < 3; ++object) {
            glm::mat4 to_world(1);
            for (int axis = 0; axis < 3; ++axis) to_world[axis] = glm::vec4(number(), number(), number(), 0);
            to_world[3] = glm::vec4(number(), number(), number(), 1);
            Box3 own;
            own.add(glm::vec3(-0.8f, -0.2f, 0)), own.add(glm::vec3(0.8f, 0.2f, 0));
            each.push_back(MovingBox::around(own, to_world, {glm::vec3(to_world[3]), 1}));
            dynamic_objects.add(std::vector<MovingSpheres::Object>{{{glm::vec3(0), 100}, each.back()}});
        }
        std::vector<ChangedNode> changed;
        find_changed(world.tree, seen.data(), count, origin, dynamic_objects, changed);
        std::size_t next = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const glm::vec3 to = world.tree.samples().at(seen_node(seen[k])) - origin;
            const bool expected =
                std::ranges::any_of(each, [&](const MovingBox& box) { return meets_way(box, origin, to, 1); });
            const bool listed = next < changed.size() && changed[next].place == k;
            EXPECT_EQ(listed && changed[next].crossed, expected) << round << " " << k;
            if (listed) ++next;
            ++tested, crossed += expected;
        }
    }
    EXPECT_GT(crossed, tested / 50);
    EXPECT_LT(crossed, tested / 4);
}

TEST(LightTree, DynamicLightsFollowTheBall)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state(scene, scene->timeline.time_of(1));
    ray::RayScene rays(state);
    Tasks tasks(1);
    LightTree tree(state, rays, {}, tasks);
    const auto middle = [&] {
        glm::vec3 sum(0);
        for (const DynamicVirtualLight& light : tree.dynamic_lights()) sum += light.position;
        return sum / static_cast<float>(tree.dynamic_lights().size());
    };
    ASSERT_FALSE(tree.dynamic_lights().empty());
    for (const DynamicVirtualLight& light : tree.dynamic_lights()) {
        EXPECT_GT(light.flux.z, light.flux.x) << "a blue ball";
        EXPECT_GT(glm::length(light.normal), 0.8f);
        EXPECT_LE(glm::length(light.normal), 1.0001f);
        EXPECT_LT(light.area, 0.2f) << "half of its surface at most";
    }
    const glm::vec3 before = middle();
    state.advance(scene->timeline.time_of(21));
    rays.update(state);
    tree.update(state, rays, tasks);
    const glm::vec3 moved = middle() - before;
    EXPECT_NEAR(moved.x, 0.4f, 0.05f);   // 20 frames of (0.02, -0.01, 0)
    EXPECT_NEAR(moved.y, -0.2f, 0.05f);
}

}   // namespace
}   // namespace gnomon
