// SPDX-License-Identifier: Apache-2.0
// CountingKdTree against brute force, against Embree, and against freshly built trees.
#include "ray/kdtree/kdtree.h"

#include <gtest/gtest.h>

#include "io/load.h"
#include "ray/origin.h"
#include "ray_helpers.h"
#include "scene/builtin/builtin.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon::test {
namespace {

using ray::Against;
using ray::CountingKdTree;
using ray::Hit;
using ray::KdCounts;
using ray::RayScene;
using ray::Sides;
using scene::SceneState;

constexpr Sides k_sides[] = {Sides::both, Sides::front};

/// Unordered triangles: long, small, parallel to an axis plane, intersecting, and some with no area.
scene::Mesh soup(scene::MaterialId material, std::uint64_t seed, std::uint32_t count, float reach)
{
    scene::Mesh mesh;
    Random random(seed);
    const auto point = [&](float r) {
        const float x = random.uniform(-r, r), y = random.uniform(-r, r);
        return glm::vec3(x, y, random.uniform(-r, r));
    };
    for (std::uint32_t t = 0; t < count; ++t) {
        const glm::vec3 centre = point(reach);
        const float size = t % 10 == 0 ? reach : 0.1f * reach;
        const int axis = static_cast<int>(random.below(3));
        for (int i = 0; i < 3; ++i) {
            glm::vec3 p = centre + point(size);
            if (t % 4 == 1) p[axis] = std::round(centre[axis]);   // many in the same planes
            if (t % 50 == 7 && i == 2) p = mesh.positions.back();
            mesh.positions.push_back(p);
            mesh.texcoords[0].emplace_back(random.uniform(), random.uniform());
        }
        mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
    }
    mesh.parts = {{material, 0, count}};
    return mesh;
}

/// Soups of every material, some static, some moving.
std::shared_ptr<const scene::Scene> make_soups(std::uint64_t seed)
{
    scene::Scene scene;
    add_materials(scene);
    Random random(seed);
    for (scene::MaterialId m = 0; m < material_count; ++m) {
        scene.meshes.push_back(soup(m, seed * 10 + m, 60 + random.below(200), 4));
        const scene::NodeId shelf = scene.add_node("", scene::none, random_placement(random, 2));
        add_object(scene, m, shelf);
        add_object(scene, m, shelf, random_placement(random, 4));
        const scene::NodeId anchor = scene.add_node("", shelf);
        scene.nodes[anchor].transform = std::make_shared<SwayTrack>(glm::dvec3(0), seed * 100 + m, 2);
        if (m % 2 == 0) add_object(scene, m, anchor, glm::scale(glm::dmat4(1), glm::dvec3(0.4)));
    }
    return finished(scene);
}

/// Rays along the axes in the planes of triangles and splits, and from such planes in any direction.
ray::RayQueue awkward_rays(std::uint64_t seed, std::size_t count)
{
    Random random(seed);
    ray::RayQueue rays;
    for (std::size_t i = 0; i < count; ++i) {
        glm::vec3 from, along(0);
        for (int axis = 0; axis < 3; ++axis) from[axis] = std::round(random.uniform(-6, 6));
        along[static_cast<int>(random.below(3))] = random.below(2) ? 1.0f : -1.0f;
        if (i % 2) along[static_cast<int>(random.below(3))] = random.uniform(-1, 1);
        if (i % 5 == 0) along.x = -0.0f;
        rays.push(from, 0, along, i % 3 ? k_infinity : 5.0f);
    }
    return rays;
}

Answers trace_tree(const CountingKdTree& tree, const ray::RayQueue& rays, KdCounts& counts)
{
    Answers answers;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3 o = rays.origin(i), d = rays.direction(i);
        const float tnear = rays.tnear[i], tfar = rays.tfar[i];
        for (const Sides sides : k_sides)
            (sides == Sides::both ? answers.both : answers.front)
                .push_back(tree.closest(o, tnear, d, tfar, sides, counts));
        answers.occluded.push_back(tree.occluded(o, tnear, d, tfar, Against::everything, counts));
        answers.occluded_static.push_back(tree.occluded(o, tnear, d, tfar, Against::static_only, counts));
        answers.occluded_dynamic.push_back(tree.occluded(o, tnear, d, tfar, Against::dynamic_only, counts));
    }
    return answers;
}

Answers trace_all(const CountingKdTree& tree, const ray::RayQueue& rays)
{
    Answers answers;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3 o = rays.origin(i), d = rays.direction(i);
        const float tnear = rays.tnear[i], tfar = rays.tfar[i];
        answers.both.push_back(tree.closest_of_all(o, tnear, d, tfar, Sides::both));
        answers.front.push_back(tree.closest_of_all(o, tnear, d, tfar, Sides::front));
        answers.occluded.push_back(tree.occluded_by_any(o, tnear, d, tfar, Against::everything));
        answers.occluded_static.push_back(tree.occluded_by_any(o, tnear, d, tfar, Against::static_only));
        answers.occluded_dynamic.push_back(tree.occluded_by_any(o, tnear, d, tfar, Against::dynamic_only));
    }
    return answers;
}

/// The number of rays whose results differ by more than the rounding of different formulas: hit or miss, or the
/// distance.
struct Differences {
    std::size_t closest = 0, occluded = 0;
};

Differences against_embree(const Answers& tree, const Answers& embree)
{
    Differences d;
    const auto differ = [](const Hit& a, const Hit& b) {
        if ((a.object == scene::none) != (b.object == scene::none)) return true;
        return a.object != scene::none && std::abs(a.t - b.t) > 1e-4f * std::max(1.0f, std::abs(a.t));
    };
    for (std::size_t i = 0; i < tree.both.size(); ++i) {
        d.closest += differ(tree.both[i], embree.both[i]) || differ(tree.front[i], embree.front[i]);
        d.occluded += tree.occluded[i] != embree.occluded[i] || tree.occluded_static[i] != embree.occluded_static[i] ||
                      tree.occluded_dynamic[i] != embree.occluded_dynamic[i];
    }
    return d;
}

/// Build options: the defaults; single triangles; coarse with every upper split accepted; deep.
std::vector<ray::KdOptions> ways_to_build()
{
    std::vector<ray::KdOptions> ways(4);
    for (auto* tree : {&ways[1].still, &ways[1].moving}) tree->from_hierarchy = false;
    for (auto* tree : {&ways[2].still, &ways[2].moving})
        tree->group_split_gain = 1, tree->groups_above = 0, tree->open_groups = 3, tree->exact_below = 0,
        tree->bins = 3, tree->clip = false;
    for (auto* tree : {&ways[3].still, &ways[3].moving})
        tree->leaf = 1, tree->test_cost = 50, tree->clip = true, tree->exact_below = 100000, tree->depth_base = 100;
    return ways;
}

TEST(KdTree, EqualsBruteForce)
{
    bool groups_split = false;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
        for (const auto& scene : {make_soups(seed), make_random_scene(seed)}) {
            const SceneState state(scene, 0.3 * static_cast<double>(seed));
            const RayScene rays(state);
            for (const ray::RayQueue& queue : {random_rays(seed, 700), awkward_rays(seed, 300)}) {
                Answers all;
                for (const ray::KdOptions& options : ways_to_build()) {
                    const CountingKdTree tree(state, rays, options);
                    if (all.both.empty()) all = trace_all(tree, queue);
                    EXPECT_GT(count_hits(all), 30u);
                    KdCounts counts;
                    EXPECT_EQ(differences(trace_tree(tree, queue, counts), all), 0u) << "seed " << seed;
                    const auto s = tree.statistics();
                    groups_split = groups_split || s.still.group_splits > 0;
                    EXPECT_LT(counts.tests, queue.size() * 5 * (s.still.triangles + s.moving.triangles) / 4);
                }
            }
        }
    EXPECT_TRUE(groups_split);
}

TEST(KdTree, FindsTheNearestHitOfOneTreeOnly)
{
    std::size_t hidden = 0, unlike = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const SceneState state(make_soups(seed), 0.3);
        const RayScene rays(state);
        const CountingKdTree tree(state, rays);
        const ray::RayQueue queue = random_rays(seed + 20, 700);
        ray::Hits embree;
        embree.resize(queue.size());
        rays.closest(queue, 0, queue.size(), embree, Sides::both, Against::static_only);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const glm::vec3 o = queue.origin(i), d = queue.direction(i);
            const float tnear = queue.tnear[i], tfar = queue.tfar[i];
            KdCounts counts;
            Hit best;
            best.t = tfar;
            for (const Against part : {Against::static_only, Against::dynamic_only}) {
                const Hit hit = tree.closest(o, tnear, d, tfar, Sides::both, counts, part);
                EXPECT_TRUE(same_bits(hit, tree.closest_of_all(o, tnear, d, tfar, Sides::both, part)));
                if (hit.object == scene::none) continue;
                EXPECT_EQ(state.scene().objects[hit.object].dynamic, part == Against::dynamic_only);
                if (part == Against::static_only)
                    unlike += embree.object[i] == scene::none ||
                              std::abs(hit.t - embree.t[i]) > 1e-4f * std::max(1.0f, hit.t);
                hidden += best.object != scene::none && best.t < hit.t;
                if (best.object == scene::none || hit.t < best.t) best = hit;
            }
            EXPECT_TRUE(same_bits(best, tree.closest(o, tnear, d, tfar, Sides::both, counts)));
        }
    }
    EXPECT_LE(unlike, 1u) << "as Embree, except at edges of holes";
    EXPECT_GT(hidden, 20u) << "dynamic objects behind static ones";
}

/// A planar square of n x n cells at z = 0.3.
scene::Mesh sheet(int n)
{
    scene::Mesh mesh;
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x)
            mesh.positions.emplace_back(0.1f * static_cast<float>(x), 0.1f * static_cast<float>(y), 0.3f);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x + 1, y + 1));
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y + 1), at(x, y + 1));
        }
    mesh.parts = {{two_sided, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

// Splits lie at corners and edges: rays through them must find all triangles there, on whichever side of the split.
TEST(KdTree, EqualsBruteForceOnSplitPlanes)
{
    constexpr int n = 20;
    scene::Scene scene;
    add_materials(scene);
    scene.meshes.push_back(sheet(n));
    add_object(scene, 0);
    add_object(scene, 0, scene::none,
               translation(0, 0, 1));   // behind the sheet, so that a missed triangle changes the result
    const std::vector<glm::vec3> corners = scene.meshes[0].positions;
    const SceneState state(finished(scene), 0);
    const RayScene rays(state);
    Random random(5);
    ray::RayQueue queue;
    for (const glm::vec3& corner : corners)
        for (const float half : {0.0f, 0.05f}) {   // and the middles of edges
            const glm::vec3 to = corner + glm::vec3(half, 0, 0);
            queue.push({to.x, to.y, -1}, 0, {0, 0, 1}, k_infinity);
            const float x = random.uniform(-1, 3), y = random.uniform(-1, 3);
            for (const glm::vec3& from : {glm::vec3(x, y, -1.7f), glm::vec3(to.x, y, -0.9f), glm::vec3(x, to.y, 2.1f)})
                queue.push(from, 0, to - from, k_infinity);
        }
    for (const ray::KdOptions& options : ways_to_build()) {
        const CountingKdTree tree(state, rays, options);
        const Answers all = trace_all(tree, queue);
        EXPECT_GT(count_hits(all), 3000u);
        KdCounts counts;
        EXPECT_EQ(differences(trace_tree(tree, queue, counts), all), 0u);
    }
}

TEST(KdTree, AgreesWithEmbreeAndThePortableRayTracer)
{
    for (const Arithmetic arithmetic : {Arithmetic::native, Arithmetic::portable}) {
        std::size_t traced = 0, closest = 0, occluded = 0;
        for (std::uint64_t seed = 1; seed <= 6; ++seed)
            for (const auto& scene : {make_soups(seed), make_random_scene(seed)}) {
                const SceneState state(scene, 0.3 * static_cast<double>(seed));
                const RayScene rays(state, MemoryLimit{}, arithmetic);
                const CountingKdTree tree(state, rays);
                const ray::RayQueue queue = random_rays(seed + 50, 3000);
                KdCounts counts;
                const Differences d = against_embree(trace_tree(tree, queue, counts), trace_singly(rays, queue));
                traced += queue.size(), closest += d.closest, occluded += d.occluded;
            }
        RecordProperty("closest_differences", static_cast<int>(closest));
        RecordProperty("occluded_differences", static_cast<int>(occluded));
        // Rays through the borders of holes, and through edges of moving objects (tested in object space), may differ.
        EXPECT_LE(closest, traced / 10000) << "of " << traced;
        EXPECT_LE(occluded, traced / 10000) << "of " << traced;
    }
}

TEST(KdTree, UpdateEqualsAFreshTreeInBitsAndCounts)
{
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const auto scene = make_random_scene(seed);
        const ray::RayQueue queue = random_rays(seed, 500);
        SceneState state(scene, 0);
        RayScene rays(state);
        CountingKdTree followed(state, rays);
        KdCounts first_counts;
        const Answers first = trace_tree(followed, queue, first_counts);
        for (const double time : {0.7, 2.5, 4.9, 0.1}) {
            state.advance(time);
            rays.update(state);
            followed.update(state, rays);
            const SceneState at_once(scene, time);
            const RayScene fresh_rays(at_once);
            const CountingKdTree fresh(at_once, fresh_rays);
            KdCounts a, b;
            const Answers answers = trace_tree(followed, queue, a);
            EXPECT_EQ(differences(answers, trace_tree(fresh, queue, b)), 0u) << "seed " << seed << ", time " << time;
            EXPECT_EQ(a.nodes, b.nodes);
            EXPECT_EQ(a.tests, b.tests);
            EXPECT_GT(differences(first, answers), 10u) << "nothing moved";
        }
        // Static geometry was built once.
        EXPECT_EQ(followed.statistics().still.builds, 1u);
        EXPECT_EQ(followed.statistics().moving.builds, 5u);
        state.advance(0.1);
        rays.update(state);
        followed.update(state, rays);
        EXPECT_EQ(followed.statistics().moving.builds, 5u) << "rebuilt although nothing moved";
    }
}

TEST(KdTree, FollowsUserOverridesAndVanishingObjects)
{
    scene::Scene scene = scene_with_balls();
    const scene::NodeId still = add_object(scene, 0);
    add_object(scene, 0, scene::none, translation(4, 0, 0));
    const scene::NodeId blinking = add_object(scene, 0, scene::none, translation(-4, 0, 0));
    scene.nodes[blinking].visibility = visibility({2, 3}, {false, true});
    SceneState state(finished(scene), 0);
    RayScene rays(state);
    CountingKdTree tree(state, rays);
    const auto expect_at = [&](std::initializer_list<std::pair<float, scene::ObjectId>> places) {
        for (const auto& [x, object] : places) {
            KdCounts counts;
            const glm::vec3 from(x + 0.013f, 0.017f, 50);
            EXPECT_EQ(tree.closest(from, 0, {0, 0, -1}, 1000, Sides::both, counts).object, object) << x;
            EXPECT_EQ(tree.occluded(from, 0, {0, 0, -1}, 1000, Against::everything, counts), object != scene::none);
        }
    };
    const auto go_to = [&](double time) {
        state.advance(time);
        rays.update(state);
        tree.update(state, rays);
    };
    expect_at({{0, 0}, {4, 1}, {-4, 2}});
    go_to(2.5);
    expect_at({{0, 0}, {4, 1}, {-4, scene::none}});
    EXPECT_EQ(tree.statistics().still.builds, 1u);
    const glm::dmat4 aside = translation(-8, 0, 0);
    state.override_transform(still, &aside);
    go_to(2.6);
    expect_at({{0, scene::none}, {4, 1}, {-8, 0}, {-4, scene::none}});
    EXPECT_EQ(tree.statistics().still.builds, 2u);
    state.override_transform(still, nullptr);
    go_to(3.5);
    expect_at({{0, 0}, {4, 1}, {-8, scene::none}, {-4, 2}});
    EXPECT_EQ(tree.statistics().still.builds, 2u) << "the object is dynamic now";
}

TEST(KdTree, RaysAgainstDynamicObjectsVisitNoStaticNodes)
{
    // Hundreds of static balls around a moving one: rays that miss its box end immediately.
    scene::Scene scene = scene_with_balls();
    Random random(1);
    for (int i = 0; i < 300; ++i) add_object(scene, 0, scene::none, random_placement(random, 10));
    const scene::NodeId dynamic_object = add_object(scene, 0);
    scene.nodes[dynamic_object].transform = std::make_shared<SwayTrack>(glm::dvec3(0), 1);
    const SceneState state(finished(scene), 0);
    const RayScene rays(state);
    const CountingKdTree tree(state, rays);
    KdCounts beside, everything;
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 from(-12, 4 + 0.05f * static_cast<float>(i), random.uniform(-9, 9));
        EXPECT_FALSE(tree.occluded(from, 0, {1, 0, 0}, 30, Against::dynamic_only, beside));
        tree.occluded(from, 0, {1, 0, 0}, 30, Against::everything, everything);
    }
    EXPECT_EQ(beside.nodes, 200u) << "the root and its dynamic child";
    EXPECT_EQ(beside.tests, 0u);
    EXPECT_GT(everything.nodes, 1000u);
    EXPECT_GT(everything.tests, 100u);
}

TEST(KdTree, SplitsAtBoundsOfSceneGraphNodes)
{
    // Two distant clusters, each below a node of its own: one plane at a node's bounds separates them.
    scene::Scene scene = scene_with_balls();
    Random random(1);
    for (const double x : {-100.0, 100.0}) {
        const scene::NodeId cluster = scene.add_node("cluster", scene::none, translation(x, 0, 0));
        for (int i = 0; i < 40; ++i) add_object(scene, 0, cluster, random_placement(random, 3));
    }
    const SceneState state(finished(scene), 0);
    const RayScene rays(state);
    ray::KdOptions options;
    options.still.open_groups = 2;
    options.still.groups_above = 100;
    EXPECT_GT(CountingKdTree(state, rays, options).statistics().still.group_splits, 0u);
    options.still.from_hierarchy = false;
    EXPECT_EQ(CountingKdTree(state, rays, options).statistics().still.group_splits, 0u);
}

TEST(KdTree, OneTreeOverEverythingEqualsBruteForce)
{
    for (const ray::KdLayout layout : {ray::KdLayout::hierarchy, ray::KdLayout::mixed})
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const auto scene = make_random_scene(seed);
            const ray::RayQueue queue = random_rays(seed, 400);
            SceneState state(scene, 0);
            RayScene rays(state);
            ray::KdOptions options;
            options.layout = layout;
            CountingKdTree tree(state, rays, options);
            for (const double time : {0.0, 0.7, 4.9}) {
                state.advance(time);
                rays.update(state);
                tree.update(state, rays);
                std::size_t hits = 0;
                for (std::size_t i = 0; i < queue.size(); ++i)
                    for (const Against against : {Against::everything, Against::static_only, Against::dynamic_only}) {
                        KdCounts counts;
                        const glm::vec3 o = queue.origin(i), d = queue.direction(i);
                        const bool found = tree.occluded(o, queue.tnear[i], d, queue.tfar[i], against, counts);
                        ASSERT_EQ(found, tree.occluded_by_any(o, queue.tnear[i], d, queue.tfar[i], against))
                            << "seed " << seed << ", ray " << i;
                        hits += found;
                    }
                EXPECT_GT(hits, 50u);
            }
            EXPECT_EQ(tree.statistics().moving.nodes, 0u);
        }
}

TEST(KdTree, ByFrameRaysAgainstDynamicObjectsIgnoreThoseAtRest)
{
    // One ball moves until time 1, another always. In all three layouts, each is asked only while it is dynamic.
    scene::Scene scene = scene_with_balls();
    add_object(scene, 0, scene::none, translation(8, 0, 0));
    const scene::NodeId always = add_object(scene, 0), until_one = add_object(scene, 0);
    scene.nodes[always].transform = std::make_shared<SwayTrack>(glm::dvec3(0), 1);
    scene.nodes[until_one].transform = std::make_shared<JumpTrack>(1, translation(-8, 0, 0), translation(-4, 0, 0));
    const auto made = finished(scene);
    for (const ray::KdLayout layout : {ray::KdLayout::separate, ray::KdLayout::hierarchy, ray::KdLayout::mixed}) {
        SceneState state(made, 0);
        RayScene rays(state);
        ray::KdOptions options;
        options.layout = layout;
        options.mobility_by_frame = true;
        CountingKdTree tree(state, rays, options);
        const auto go_to = [&](double time) {
            state.advance(time);
            rays.update(state);
            tree.update(state, rays);
        };
        const auto hit = [&](float x, bool in_clip) {
            KdCounts counts;
            const glm::vec3 from(x + 0.013f, 0.017f, 50);
            return in_clip ? tree.occluded(from, 0, {0, 0, -1}, 1000, Against::dynamic_only, counts)
                           : tree.occluded_by_dynamic(from, 0, {0, 0, -1}, 1000, counts);
        };
        go_to(0);
        EXPECT_FALSE(hit(-8, false)) << "at rest";
        EXPECT_TRUE(hit(-8, true)) << "may move in the clip";
        EXPECT_FALSE(hit(8, true)) << "never moves";
        go_to(1.5);
        EXPECT_TRUE(hit(-4, false)) << "jumped in this frame";
        for (int i = 1; i <= 8; ++i) go_to(1.5 + 0.01 * i);
        EXPECT_FALSE(hit(-4, false)) << "has rested";
        EXPECT_TRUE(hit(-4, true));
        EXPECT_TRUE(tree.is_dynamic(1));
        EXPECT_FALSE(tree.is_dynamic(2));
        KdCounts counts;
        EXPECT_TRUE(tree.occluded({-3.987f, 0.017f, 50}, 0, {0, 0, -1}, 1000, Against::everything, counts));
    }
}

TEST(KdTree, EmptySceneHasNoHits)
{
    scene::Scene scene;
    add_materials(scene);
    const SceneState state(finished(scene), 0);
    const RayScene rays(state);
    const CountingKdTree tree(state, rays);
    KdCounts counts;
    EXPECT_FALSE(tree.occluded({0, 0, 0}, 0, {1, 0, 0}, 1, Against::everything, counts));
    EXPECT_EQ(tree.closest({0, 0, 0}, 0, {1, 0, 0}, 7, Sides::both, counts).object, scene::none);
    EXPECT_EQ(tree.closest({0, 0, 0}, 0, {1, 0, 0}, 7, Sides::both, counts).t, 7.0f);
    EXPECT_EQ(counts.tests, 0u);
}

/// Rays from random places inside a scene's bounds to others, and from the surfaces they hit to the lights.
struct SceneRays {
    ray::RayQueue seen, shadow;
};

SceneRays rays_in(const SceneState& state, const RayScene& rays, std::uint64_t seed, std::size_t count)
{
    SceneRays result;
    Random random(seed);
    const Box3 box = rays.bounds();
    const auto point = [&] {
        const float x = random.uniform(), y = random.uniform();
        return box.low + glm::vec3(x, y, random.uniform()) * box.size();
    };
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 from = point(), along = point() - from;
        result.seen.push(from, 0, along, k_infinity);
        const Hit hit = rays.closest_single(from, 0, along, k_infinity, Sides::front);
        if (hit.object == scene::none) continue;
        glm::vec3 p[3];
        rays.geometry(hit.object).corners(hit.triangle, p);
        const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        if (!(glm::length(cross) > 0)) continue;
        const glm::vec3 normal = glm::normalize(glm::dot(cross, along) < 0 ? cross : -cross);
        const glm::vec3 start = from + hit.t * along + 4 * ray::origin_lift(p) * normal;
        for (scene::LightId l = 0; l < state.scene().lights.size(); ++l) {
            const glm::vec3 light = glm::vec3(state.light(l).position);
            result.shadow.push(start, 0, light - start, 1);
        }
    }
    return result;
}

void expect_agreement_with_embree(const std::shared_ptr<const scene::Scene>& scene, double time, std::size_t count)
{
    const SceneState state(scene, time);
    const RayScene rays(state);
    const CountingKdTree tree(state, rays);
    const SceneRays traced = rays_in(state, rays, 7, count);
    std::size_t closest = 0, occluded = 0;
    for (const ray::RayQueue* queue : {&traced.seen, &traced.shadow}) {
        KdCounts counts;
        const Differences d = against_embree(trace_tree(tree, *queue, counts), trace_singly(rays, *queue));
        closest += d.closest, occluded += d.occluded;
    }
    const std::size_t all = traced.seen.size() + traced.shadow.size();
    testing::Test::RecordProperty("rays", static_cast<int>(all));
    testing::Test::RecordProperty("closest_differences", static_cast<int>(closest));
    testing::Test::RecordProperty("occluded_differences", static_cast<int>(occluded));
    EXPECT_LE(closest, all / 2000) << "of " << all;
    EXPECT_LE(occluded, all / 2000) << "of " << all;
}

TEST(KdTree, AgreesWithEmbreeInBuiltInScenes)
{
    for (const char* name : {"kinetic", "spheres?objects=30"})
        expect_agreement_with_embree(std::make_shared<const scene::Scene>(scene::make_builtin(name)), 1.0, 1500);
}

TEST(KdTree, AgreesWithEmbreeInKitchen)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    expect_agreement_with_embree(std::make_shared<const scene::Scene>(io::load_scene(file)), 5.0, 2000);
}

}   // namespace
}   // namespace gnomon::test
