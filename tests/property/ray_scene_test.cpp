// SPDX-License-Identifier: Apache-2.0
// RayScene: packets against single rays, and an updated scene against a freshly built one.
#include "ray/ray_scene.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "base/tasks.h"
#include "ray_helpers.h"
#include "scene_helpers.h"

namespace gnomon::test {
namespace {

using scene::SceneState;

TEST(RayQueue, HasRoomForAWholePacketAtAnyIndex)
{
    for (const std::size_t reserved : {0, 1, 15, 16, 17, 100}) {
        ray::RayQueue queue;
        queue.reserve(reserved);
        for (std::size_t last = 0; last < 200; ++last) {
            queue.push(glm::vec3(0), 0, glm::vec3(0, 0, 1), 1);
            for (const auto* a :
                 {&queue.ox, &queue.oy, &queue.oz, &queue.tnear, &queue.dx, &queue.dy, &queue.dz, &queue.tfar})
                ASSERT_GE(a->size(), last + ray::k_packet_pad);
        }
    }
}

TEST(RayScene, PacketsEqualSingleRays)
{
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const SceneState state(make_random_scene(seed), 0.3 * static_cast<double>(seed));
        const ray::RayScene rays(state);
        const ray::RayQueue queue = random_rays(seed, 4003);   // the last packet is not full
        const Answers single = trace_singly(rays, queue);
        EXPECT_GT(count_hits(single), 500u);
        EXPECT_EQ(differences(trace(rays, queue), single), 0u) << "seed " << seed;
        EXPECT_EQ(differences(trace(rays, queue, 37), single), 0u) << "in pieces, seed " << seed;
    }
}

// Far from the origin, where boxes and rays are rounded coarsely: whether a ray is occluded does not depend on the
// other rays of its packet. Rays pass the outlines of flat, axis-parallel objects, which fill their boxes.
TEST(RayScene, DistantAnyHitsDoNotDependOnTheRestOfThePacket)
{
    for (const double away : {0.0, 1e3, 1e5, 1e6})
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            Random random(seed);
            scene::Scene scene = scene_with_balls();
            scene::Mesh flat;
            flat.positions = {{-1, 0, -.4f}, {1, 0, -.4f}, {1, 0, .4f}, {-1, 0, .4f}};
            flat.triangles = {{0, 1, 2}, {0, 2, 3}};
            flat.parts = scene.meshes.front().parts;
            flat.parts.resize(1);
            flat.parts.front().first_triangle = 0, flat.parts.front().triangle_count = 2;
            scene.meshes.push_back(flat);
            const glm::dvec3 place = away * glm::dvec3(1, 0.1, -1);
            std::vector<glm::vec3> centres;
            for (int i = 0; i < 6; ++i) {
                const glm::dvec3 at = place + glm::dvec3(3 * i, random.uniform(-1, 1), random.uniform(-2, 2));
                // Some have distant vertices in object space, and small transforms.
                glm::dmat4 m = i % 3 == 0 ? glm::dmat4(1) : random_placement(random, 0);
                if (seed % 2 == 0) m = glm::scale(m, glm::dvec3(0.3 + i));
                m[3] = glm::dvec4(at, 1);
                const scene::NodeId node =
                    add_object(scene, i % 2 ? 0 : static_cast<scene::MeshId>(scene.meshes.size() - 1));
                scene.nodes[node].transform = std::make_shared<JumpTrack>(100, m, m);
                centres.emplace_back(at);
            }
            const SceneState state(finished(scene), 0);
            const ray::RayScene rays(state);
            ray::RayQueue queue;
            std::size_t i = 0;
            while (queue.size() < 40000) {
                const glm::vec3& centre = centres[i++ % centres.size()];
                const glm::vec3 from =
                    centre + glm::vec3(random.uniform(-4, 4), random.uniform(1, 4), random.uniform(-4, 4));
                const glm::vec3 to = centre + glm::vec3(random.uniform(-1.1f, 1.1f), 0, random.uniform(-.5f, .5f));
                queue.push(from, 0, 1.5f * (to - from), 0.9999f);
            }
            std::vector<std::uint8_t> together(queue.size() + ray::k_packet_pad),
                alone(queue.size() + ray::k_packet_pad);
            rays.occluded(queue, 0, queue.size(), together.data());
            std::size_t occluded = 0, differ = 0, single = 0;
            for (std::size_t r = 0; r < queue.size(); ++r) {
                rays.occluded(queue, r, r + 1, alone.data());
                occluded += together[r];
                differ += together[r] != alone[0];
                single += together[r] != rays.occluded_single(queue.origin(r), 0, queue.direction(r), queue.tfar[r]);
            }
            EXPECT_GT(occluded, 5000u);
            EXPECT_EQ(differ, 0u) << away << " away, seed " << seed;
            EXPECT_EQ(single, 0u) << away << " away, seed " << seed;
        }
}

TEST(RayScene, SameHitsForAnyThreadCount)
{
    const SceneState state(make_random_scene(3), 1);
    const ray::RayScene rays(state);
    const ray::RayQueue queue = random_rays(5, 4000);
    const Answers alone = trace(rays, queue);
    std::vector<std::size_t> wrong(16);
    Tasks tasks(4);
    tasks.for_each(wrong.size(),
                   [&](std::size_t i, int) { wrong[i] = differences(trace(rays, queue, 500 + i), alone); });
    for (const std::size_t count : wrong) EXPECT_EQ(count, 0u);
}

// Embree must not restrict other code to one thread.
TEST(RayScene, DoesNotLimitOtherThreads)
{
    const SceneState state(make_random_scene(1), 0);
    const ray::RayScene rays(state);
    Tasks tasks(4);
    std::atomic<int> inside = 0;
    std::atomic<bool> together = false;
    tasks.for_each(4, [&](std::size_t, int) {
        ++inside;
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(3);
        while (!together && std::chrono::steady_clock::now() < give_up) {
            if (inside > 1) together = true;
            std::this_thread::yield();
        }
        --inside;
    });
    EXPECT_TRUE(together) << "the bodies ran one after the other";
}

TEST(RayScene, UpdateEqualsAFreshScene)
{
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const auto scene = make_random_scene(seed);
        const ray::RayQueue queue = random_rays(seed, 3000);
        SceneState state(scene, 0);
        ray::RayScene followed(state);
        const Answers first = trace(followed, queue);
        Random random(seed);
        for (int step = 0; step < 8; ++step) {
            const double time = static_cast<double>(random.uniform(0, 6));
            state.advance(time);
            followed.update(state);
            const SceneState at_once(scene, time);
            const ray::RayScene fresh(at_once);
            const Answers expected = trace(fresh, queue);
            EXPECT_EQ(differences(trace(followed, queue), expected), 0u) << "seed " << seed << ", time " << time;
            EXPECT_GT(differences(first, expected), 50u) << "nothing moved";
        }
    }
}

// Intersecting coplanar surfaces: the reported one depends on the structure of the trees, so the trees must be the
// same.
TEST(RayScene, UpdateBreaksTiesAsAFreshSceneDoes)
{
    scene::Scene scene = scene_with_balls();
    scene::Mesh doubled = ball(two_sided, 12, 16);
    const std::vector<glm::uvec3> once = doubled.triangles;
    doubled.triangles.insert(doubled.triangles.end(), once.rbegin(), once.rend());
    doubled.parts.front().triangle_count *= 2;
    scene.meshes.push_back(doubled);
    add_vertex_keys(doubled);
    scene.meshes.push_back(doubled);
    const auto track = std::make_shared<SwayTrack>(glm::dvec3(0), 4, 3);
    for (int i = 0; i < 5; ++i) scene.nodes[add_object(scene, 1)].transform = track;
    for (int i = 0; i < 5; ++i) add_object(scene, 2, scene::none, translation(3, 0, 0));
    for (int i = 0; i < 5; ++i) add_object(scene, 2);
    const auto shared = finished(scene);

    const ray::RayQueue queue = random_rays(1, 4000, 4);
    SceneState state(shared, 0.1);
    ray::RayScene followed(state);
    for (const double time : {0.4, 1.9, 4.8, 0.1, 3.0}) {
        state.advance(time);
        followed.update(state);
        const SceneState at_once(shared, time);
        const ray::RayScene fresh(at_once);
        EXPECT_EQ(differences(trace(followed, queue), trace(fresh, queue)), 0u) << "time " << time;
    }
}

TEST(RayScene, ObjectsAppearAndVanish)
{
    scene::Scene scene = scene_with_balls();
    scene::Mesh keyed = ball(two_sided);
    add_vertex_keys(keyed);
    scene.meshes.push_back(keyed);
    const scene::NodeId blinking = add_object(scene, 0);
    scene.nodes[blinking].visibility = visibility({1, 2}, {false, true});
    // Deforms and jumps while it is invisible.
    const scene::NodeId sleeper = add_object(scene, 1);
    scene.nodes[sleeper].transform = std::make_shared<JumpTrack>(1.5, translation(10, 0, 0), translation(20, 0, 0));
    scene.nodes[sleeper].visibility = visibility({1, 3}, {false, true});
    const auto shared = finished(scene);
    const ray::RayQueue queue = random_rays(2, 2000, 25);

    SceneState state(shared, 0);
    ray::RayScene rays(state);
    EXPECT_EQ(look_at(rays, 0).object, 0u);
    EXPECT_EQ(look_at(rays, 10).object, 1u);
    for (const double time : {1.1, 1.7, 2.5, 3.5, 1.2, 0.5}) {
        state.advance(time);
        rays.update(state);
        const bool first_seen = time < 1 || time >= 2, second_seen = time < 1 || time >= 3;
        EXPECT_EQ(look_at(rays, 0).object, first_seen ? 0u : scene::none) << time;
        EXPECT_EQ(look_at(rays, 10).object, second_seen && time < 1.5 ? 1u : scene::none) << time;
        EXPECT_EQ(look_at(rays, 20).object, second_seen && time >= 1.5 ? 1u : scene::none) << time;
        const SceneState at_once(shared, time);
        EXPECT_EQ(differences(trace(rays, queue), trace(ray::RayScene(at_once), queue)), 0u) << time;
    }
}

TEST(RayScene, SkinnedObjectsFollowTheirJoints)
{
    scene::Scene scene = scene_with_balls();
    scene::Mesh mesh = ball(two_sided);
    mesh.skin.emplace();
    mesh.skin->joints[0].assign(mesh.positions.size(), glm::u16vec4(0));
    mesh.skin->weights[0].assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
    scene.meshes.push_back(mesh);
    const scene::NodeId joint = scene.add_node("joint", scene::none);
    scene.nodes[joint].transform = std::make_shared<JumpTrack>(1, glm::dmat4(1), translation(7, 0, 0));
    scene.skins.push_back({"", {joint}, {glm::dmat4(1)}});
    // The transform of a skinned mesh's own node has no effect.
    const scene::NodeId node = add_object(scene, 1, scene::none, translation(-30, 0, 0));
    scene.nodes[node].skin = 0;
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    EXPECT_EQ(look_at(rays, 0).object, 0u);
    EXPECT_EQ(look_at(rays, -30).object, scene::none);
    state.advance(2);
    rays.update(state);
    EXPECT_EQ(look_at(rays, 0).object, scene::none);
    EXPECT_EQ(look_at(rays, 7).object, 0u);
}

TEST(RayScene, ObjectShrunkToAPointReturns)
{
    // At the origin no margin is needed; elsewhere the position needs one. One part, and one part of every surface
    // class.
    for (const double x : {0.0, 7.0})
        for (const scene::Mesh& shape : {ball(two_sided), patchwork(1)}) {
            scene::Scene scene;
            add_materials(scene);
            scene.meshes.push_back(shape);
            scene::Mesh& mesh = scene.meshes.edit(0);
            mesh.skin.emplace();
            mesh.skin->joints[0].assign(mesh.positions.size(), glm::u16vec4(0));
            mesh.skin->weights[0].assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
            const scene::NodeId joint = scene.add_node("joint", scene::none);
            const glm::dmat4 there = translation(x, 0, 0);
            scene.nodes[joint].transform = std::make_shared<JumpTrack>(1, glm::scale(there, glm::dvec3(0)), there);
            scene.skins.push_back({"", {joint}, {glm::dmat4(1)}});
            scene.nodes[add_object(scene, 0)].skin = 0;
            SceneState state(finished(scene), 0);
            ray::RayScene rays(state);
            const ray::RayQueue queue = random_rays(1, 3000, 3);
            EXPECT_EQ(count_hits(trace(rays, queue)), 0u) << x;
            state.advance(2);
            rays.update(state);
            EXPECT_GT(count_hits(trace(rays, queue)), 0u) << x;
            EXPECT_EQ(differences(trace(rays, queue), trace(ray::RayScene(state), queue)), 0u) << x;
            state.advance(0.5);
            rays.update(state);
            EXPECT_EQ(count_hits(trace(rays, queue)), 0u) << x;
        }
}

// A joint that shrinks to a point hides a limb: the rest stays.
TEST(RayScene, PartlyShrunkMeshKeepsTheRest)
{
    for (const double x : {0.0, 7.0})
        for (const unsigned every : {2u, 3u, 7u, 1000u})
            for (const scene::Mesh& shape : {ball(two_sided), patchwork(1), patchwork(2)}) {
                scene::Scene scene;
                add_materials(scene);
                scene.meshes.push_back(shape);
                scene::Mesh& mesh = scene.meshes.edit(0);
                mesh.skin.emplace();
                for (std::size_t v = 0; v < mesh.positions.size(); ++v)   // in runs
                    mesh.skin->joints[0].emplace_back(v / 40 % every == 0 ? 0 : 1, 0, 0, 0);
                mesh.skin->weights[0].assign(mesh.positions.size(), glm::vec4(1, 0, 0, 0));
                const scene::NodeId still = scene.add_node("still", scene::none);
                const scene::NodeId joint = scene.add_node("joint", scene::none);
                const glm::dmat4 there = translation(x, 0, 0);
                scene.nodes[still].transform = std::make_shared<JumpTrack>(1, there, there);
                scene.nodes[joint].transform = std::make_shared<JumpTrack>(1, glm::scale(there, glm::dvec3(0)), there);
                scene.skins.push_back({"", {still, joint}, {glm::dmat4(1), glm::dmat4(1)}});
                scene.nodes[add_object(scene, 0)].skin = 0;
                SceneState state(finished(scene), 0);
                ray::RayScene rays(state);
                const ray::RayQueue queue = random_rays(1, 3000, 3);
                for (const double time : {2.0, 0.5, 3.0}) {
                    state.advance(time);
                    rays.update(state);
                    EXPECT_EQ(differences(trace(rays, queue), trace(ray::RayScene(state), queue)), 0u)
                        << x << " " << time;
                }
                EXPECT_GT(count_hits(trace(rays, queue)), 0u);
            }
}

TEST(RayScene, FollowsUserOverrides)
{
    scene::Scene scene = scene_with_balls();
    const scene::NodeId shelf = scene.add_node("shelf", scene::none);
    const scene::NodeId still = add_object(scene, 0, shelf);
    add_object(scene, 0, shelf, translation(5, 0, 0));
    const scene::NodeId anchor = scene.add_node("anchor", scene::none);
    scene.nodes[anchor].transform = std::make_shared<JumpTrack>(4.5, translation(10, 0, 0), translation(12, 0, 0));
    add_object(scene, 0, anchor);
    const scene::NodeId passenger = add_object(scene, 0, anchor, translation(5, 0, 0));
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    const auto expect_at = [&](std::initializer_list<std::pair<float, scene::ObjectId>> places) {
        for (const auto& [x, object] : places) {
            EXPECT_EQ(look_at(rays, x).object, object) << x;
            EXPECT_EQ(rays.occluded_single({x, 0, 50}, 0, {0, 0, -1}, 100), object != scene::none) << x;
        }
    };
    double time = 0;
    const auto step = [&] {
        state.advance(++time);
        rays.update(state);
    };
    expect_at({{0, 0}, {5, 1}, {10, 2}, {15, 3}});

    // A static object.
    const glm::dmat4 aside = translation(-6, 0, 0);
    state.override_transform(still, &aside);
    step();
    expect_at({{0, scene::none}, {-6, 0}, {5, 1}, {10, 2}});
    EXPECT_EQ(rays.statistics().touched, 1u);
    // One of two objects that moved together, relative to the other.
    const glm::dmat4 further = translation(8, 0, 0);
    state.override_transform(passenger, &further);
    step();
    expect_at({{10, 2}, {15, scene::none}, {18, 3}, {-6, 0}});
    // Back to the transform in the file.
    state.override_transform(still, nullptr);
    state.override_transform(passenger, nullptr);
    step();
    expect_at({{0, 0}, {-6, scene::none}, {15, 3}, {18, scene::none}});
    // An overridden object still follows its anchor; a whole group can be moved.
    const glm::dmat4 left = translation(-20, 0, 0);
    state.override_transform(shelf, &left);
    step();
    step();
    expect_at({{0, scene::none}, {5, scene::none}, {-20, 0}, {-15, 1}, {12, 2}, {17, 3}});
}

TEST(RayScene, UpdatesMovedObjectsOnly)
{
    scene::Scene scene = scene_with_balls();
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        const scene::NodeId node = add_object(scene, 0, scene::none, random_placement(random, 50));
        if (i % 100 == 0) scene.nodes[node].transform = std::make_shared<SwayTrack>(glm::dvec3(i), 1);
    }
    const scene::NodeId late = add_object(scene, 0);   // moves later; then also appears
    scene.nodes[late].transform =
        std::make_shared<JumpTrack>(5, glm::dmat4(1), glm::scale(glm::dmat4(1), glm::dvec3(2)));
    scene.nodes[late].visibility = visibility({0, 5}, {false, true});
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    const std::size_t triangles = 990 * ball(two_sided).triangles.size();
    EXPECT_EQ(rays.statistics().static_triangles, triangles);
    EXPECT_EQ(rays.statistics().instances, 11u);
    EXPECT_GT(rays.statistics().bytes, 36 * triangles);
    state.advance(1);
    rays.update(state);
    EXPECT_EQ(rays.statistics().touched, 10u);
    state.advance(1);
    rays.update(state);
    EXPECT_EQ(rays.statistics().touched, 0u);
    state.advance(6);
    rays.update(state);
    EXPECT_EQ(rays.statistics().touched, 11u) << "each object counts once for all of its changes";
}

TEST(RayScene, EmptySceneHasNoHits)
{
    scene::Scene scene;
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    const Answers answers = trace(rays, random_rays(1, 100));
    EXPECT_EQ(count_hits(answers), 0u);
    EXPECT_EQ(std::count(answers.occluded.begin(), answers.occluded.end(), 0), 100);
    EXPECT_TRUE(rays.bounds().empty());
    EXPECT_EQ(rays.statistics().static_triangles, 0u);
    state.advance(1);
    rays.update(state);
    EXPECT_TRUE(trace(rays, ray::RayQueue()).both.empty());
}

// Many large copies share one BLAS; a flat one among them cannot, and is hit nevertheless.
TEST(RayScene, HitsAFlatInstanceAmongManyCopies)
{
    scene::Scene scene = scene_with_balls();
    scene.meshes.clear();
    scene.meshes.push_back(ball(two_sided, 256, 260));
    constexpr int k_copies = 8;
    for (int i = 0; i < k_copies; ++i) {
        glm::dmat4 m = translation(4.0 * i, 0, 0);
        if (i == 5) m = glm::scale(m, glm::dvec3(1, 1, 0));
        add_object(scene, 0, scene::none, m);
    }
    const SceneState state(finished(scene), 0);
    const ray::RayScene rays(state);
    ASSERT_GE(rays.statistics().static_triangles, std::size_t{1} << 20) << "otherwise they are not instanced";
    ray::RayQueue queue;
    for (int i = 0; i < k_copies; ++i) queue.push(glm::vec3(4.0f * i + 0.2f, 0.1f, 5), 0, glm::vec3(0, 0, -1), 10);
    const Answers answers = trace(rays, queue);
    for (std::size_t i = 0; i < k_copies; ++i) {
        EXPECT_EQ(answers.both[i].object, i);
        EXPECT_TRUE(answers.occluded[i]);
    }
    EXPECT_NEAR(answers.both[5].t, 5, 1e-4);
}

// The margin of a shared BLAS follows dynamic objects that move far away, from which rays may come.
TEST(RayScene, ManyCopiesAreHitFromFarAway)
{
    scene::Scene scene = scene_with_balls();
    scene.meshes.clear();
    scene.meshes.push_back(ball(two_sided, 256, 260));
    for (int i = 0; i < 8; ++i) add_object(scene, 0, scene::none, translation(4.0 * i, 0, 0));
    const scene::NodeId ball_node = add_object(scene, 0, scene::none, translation(0, 5, 0));
    scene.nodes[ball_node].animated = true;
    SceneState state(finished(scene), 0);
    ray::RayScene kept(state);
    ASSERT_GE(kept.statistics().static_triangles, std::size_t{1} << 20) << "otherwise they are not instanced";
    const double places[] = {1e4, 1e5, 5};
    for (const double y : places) {
        const glm::dmat4 there = translation(0, y, 0);
        state.override_transform(ball_node, &there);
        state.advance(0);
        kept.update(state);
        const ray::RayScene anew(state);
        // Aim at the borders of the boxes.
        Random random(5);
        ray::RayQueue queue;
        for (int i = 0; i < 4000; ++i) {
            const glm::vec3 at(4.0f * static_cast<float>(random.below(8)) + random.uniform(-1e-3f, 1e-3f),
                               random.uniform(-1, 1), 1.0f);
            const glm::vec3 from(random.uniform(-1, 1), static_cast<float>(y), 2);
            queue.push(from, 0, at - from, 2);
        }
        EXPECT_EQ(differences(trace(kept, queue), trace(anew, queue)), 0u) << y;
    }
}

// NaN, infinite and huge vertices, triangles without area, objects with singular transforms: they neither crash nor
// affect other objects.
TEST(RayScene, SurvivesDegenerateGeometry)
{
    scene::Scene scene = scene_with_balls();
    scene::Mesh bad = ball(cut_out_one_sided);
    const float values[] = {std::nanf(""), k_infinity, -k_infinity, 3e38f, 1e-40f, 0};
    for (std::size_t i = 0; i < bad.positions.size(); ++i)
        bad.positions[i] = glm::vec3(values[i % 6], values[(i / 6) % 6], values[(i / 2) % 6]);
    scene.meshes.push_back(bad);
    scene::Mesh flat = ball(one_sided);
    for (glm::uvec3& t : flat.triangles) t = {t.x, t.x, t.y};
    scene.meshes.push_back(flat);
    add_object(scene, 0);
    for (const scene::MeshId mesh : {1u, 2u}) {
        add_object(scene, mesh);
        scene.nodes[add_object(scene, mesh)].transform = std::make_shared<SwayTrack>(glm::dvec3(0), 1);
    }
    // A dynamic object that shrinks to a point, and one that always is a point.
    const glm::dmat4 there = translation(10, 0, 0);
    const scene::NodeId shrinking = add_object(scene, 0);
    scene.nodes[shrinking].transform = std::make_shared<JumpTrack>(1, there, glm::scale(there, glm::dvec3(0)));
    const scene::NodeId point = add_object(scene, 0, scene::none, glm::scale(translation(20, 0, 0), glm::dvec3(0)));
    scene.nodes[point].animated = true;
    // Dynamic objects of sizes that rays cannot be transformed to, and one whose vertices become invalid.
    const double sizes[] = {1e-30, 1e30, 1e-12, std::nan(""), k_infinity};
    for (const double size : sizes)
        for (const glm::dvec3& shape : {glm::dvec3(1, size, 1), glm::dvec3(size)})
            scene.nodes[add_object(scene, 0, scene::none, glm::scale(translation(0, 30, 0), shape))].animated = true;
    scene::Mesh astray = ball(two_sided);
    add_vertex_keys(astray);
    for (std::size_t i = 0; i < astray.positions.size(); i += 5)
        for (const int key : {0, 2}) astray.vertex_keys->positions[static_cast<std::size_t>(key)][i].x = values[i % 6];
    scene.meshes.push_back(astray);
    add_object(scene, 3, scene::none, translation(0, 40, 0));
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    const ray::RayQueue queue = random_rays(1, 3000, 3);
    EXPECT_EQ(look_at(rays, 10).object, 5u);
    for (const double time : {1.5, 0.5}) {
        state.advance(time);
        rays.update(state);
        EXPECT_EQ(look_at(rays, 10).object, time < 1 ? 5u : scene::none);
        EXPECT_EQ(look_at(rays, 20).object, scene::none);
        const Answers answers = trace(rays, queue);
        EXPECT_GT(count_hits(answers), 300u);
        EXPECT_EQ(differences(answers, trace_singly(rays, queue)), 0u);
        for (const ray::Hit& hit : answers.both)
            EXPECT_TRUE(hit.object == scene::none || hit.object == 0u || (time < 1 && hit.object == 5u)) << hit.object;
    }
    // The rest of that object is hit again once its vertices are valid.
    state.advance(2);
    rays.update(state);
    const scene::ObjectId last = static_cast<scene::ObjectId>(state.scene().objects.size() - 1);
    EXPECT_EQ(rays.closest_single({0.01f, 60, 0.02f}, 0, {0, -1, 0}, 100, ray::Sides::both).object, last);
    // Rays without a direction or an origin do no harm.
    ray::RayQueue odd;
    for (const float x : values) {
        odd.push({x, 0, 0}, 0, {0, 0, 1}, 10);
        odd.push({0, 0, 0}, 0, {x, 0, x}, 10);
        odd.push({0, 0, 0}, x, {0, 0, 1}, x);
    }
    EXPECT_EQ(differences(trace(rays, odd), trace_singly(rays, odd)), 0u);
}

TEST(RayScene, BoundsFollowMovingObjects)
{
    scene::Scene scene = scene_with_balls();
    add_object(scene, 0);
    scene.nodes[add_object(scene, 0)].transform = std::make_shared<JumpTrack>(1, glm::dmat4(1), translation(100, 0, 0));
    SceneState state(finished(scene), 0);
    ray::RayScene rays(state);
    EXPECT_LT(rays.bounds().high.x, 2);
    EXPECT_LT(rays.bounds().low.x, -0.5f);
    state.advance(2);
    rays.update(state);
    EXPECT_GT(rays.bounds().high.x, 99);
    EXPECT_LT(rays.bounds().low.x, -0.5f);
}

}   // namespace
}   // namespace gnomon::test
