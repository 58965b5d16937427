// SPDX-License-Identifier: Apache-2.0
// Rays on the device against RayScene: between surface points of several scenes, before and after objects move. Both
// may differ where a ray passes an edge of a triangle, or of a hole in a mask, within rounding. Few rays may differ,
// and each of these must be such a ray: RayScene's own results differ among neighbouring rays that are closer than any
// image shows.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <fmt/format.h>

#include "gnomon/gnomon.h"
#include "ray/vulkan/device_rays.h"
#include "ray_helpers.h"
#include "scene/builtin/builtin.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon {
namespace {

using ray::Against;
using ray::DeviceRays;

constexpr double k_differing = 1e-3;   // fraction of rays that may differ
constexpr float k_neighbour = 2e-5f;   // of the scene's size: the distance of neighbouring rays
constexpr int k_neighbours = 64;
constexpr float k_offset = 1e-3f;   // of the scene's size: the offset of ray origins and ends from their surfaces
constexpr std::size_t k_rays = 20'000;

class DeviceRaysVulkan : public test::VulkanTest {};

#define GNOMON_NEED_RAYS                                                                    \
    if (!DeviceRays::supported(*device_))                                                   \
    GTEST_SKIP() << "the device '" << device_->info().name << "' traces no rays: it lacks " \
                 << device_->info().no_rays.front()

// A point on a random triangle of a random object, slightly above either side.
glm::vec3 surface_point(const ray::RayScene& rays, const scene::SceneState& state, Random& random, float offset)
{
    for (;;) {
        const scene::ObjectId o = random.below(static_cast<std::uint32_t>(state.scene().objects.size()));
        const scene::Mesh& mesh = state.scene().meshes[state.scene().objects[o].mesh];
        if (!state.object_visible(o) || mesh.triangles.empty()) continue;
        glm::vec3 p[3];
        rays.geometry(o).corners(random.below(static_cast<std::uint32_t>(mesh.triangles.size())), p);
        const glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        if (!(glm::length(normal) > 0)) continue;
        float u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const float side = random.below(2) ? offset : -offset;
        return (1 - u - v) * p[0] + u * p[1] + v * p[2] + side * glm::normalize(normal);
    }
}

ray::RayQueue surface_rays(const ray::RayScene& rays, const scene::SceneState& state, std::uint64_t seed,
                           std::size_t count)
{
    Random random(seed);
    const float offset = k_offset * rays.bounds().diagonal();
    ray::RayQueue queue;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 from = surface_point(rays, state, random, offset),
                        to = surface_point(rays, state, random, offset);
        queue.push(from, 0, to - from, 1);
    }
    return queue;
}

// Whether RayScene's own result changes if the ends of a ray are moved by about the rounding error.
bool on_an_edge(const ray::RayScene& rays, const ray::RayQueue& queue, std::size_t i, Against against)
{
    Random random(i);
    const float reach = k_neighbour * rays.bounds().diagonal();
    const auto nudge = [&] {
        const float x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
        return glm::vec3(x, y, random.uniform(-reach, reach));
    };
    int occluded = 0;
    for (int n = 0; n < k_neighbours; ++n) {
        const glm::vec3 from = queue.origin(i) + nudge(), to = queue.origin(i) + queue.direction(i) + nudge();
        occluded += rays.occluded_single(from, queue.tnear[i], to - from, queue.tfar[i], against);
    }
    return occluded > 0 && occluded < k_neighbours;
}

struct Compared {
    std::size_t traced = 0, differing = 0, occluded = 0;
};

// Traces the same rays with both, against each part of the scene.
void compare(vk::Commands& commands, const gpu_scene::GpuScene& scene, DeviceRays& device, const ray::RayScene& rays,
             const ray::RayQueue& queue, Compared& sum)
{
    std::vector<std::uint8_t> expected(queue.size()), answers(queue.size(), 2);
    for (const Against against : {Against::everything, Against::static_only, Against::dynamic_only}) {
        rays.occluded(queue, 0, queue.size(), expected.data(), against);
        device.occluded(commands, scene, queue, answers.data(), against);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            ASSERT_LE(answers[i], 1u);
            ++sum.traced;
            sum.occluded += expected[i];
            if (answers[i] == expected[i]) continue;
            ++sum.differing;
            EXPECT_TRUE(on_an_edge(rays, queue, i, against))
                << "ray " << i << ", far from any edge, against " << static_cast<int>(against);
        }
    }
}

// Follows a scene through several times.
Compared follow(const std::shared_ptr<vk::Device>& vulkan, const std::shared_ptr<const scene::Scene>& description,
                const std::vector<double>& times, std::size_t count = k_rays)
{
    scene::SceneState state(description, times.front());
    ray::RayScene rays(state);
    gpu_scene::GpuScene scene(vulkan, state);
    DeviceRays device(vulkan, scene, state);
    vk::Commands commands(vulkan);
    Compared sum;
    for (std::size_t t = 0; t < times.size(); ++t) {
        SCOPED_TRACE(fmt::format("time {}", times[t]));
        if (t > 0) {
            state.advance(times[t]);
            rays.update(state);
            scene.update(commands, state);
            device.update(commands, scene, state);
        }
        compare(commands, scene, device, rays, surface_rays(rays, state, t + 1, count), sum);
        if (testing::Test::HasFailure()) break;
    }
    const double fraction = static_cast<double>(sum.differing) / static_cast<double>(sum.traced);
    fmt::print("{} of {} answers differ ({:.1e}), {} occluded\n", sum.differing, sum.traced, fraction, sum.occluded);
    EXPECT_LE(fraction, k_differing);
    EXPECT_GT(sum.occluded, sum.traced / 50);
    EXPECT_LT(sum.occluded, sum.traced);
    return sum;
}

Compared follow_frames(const std::shared_ptr<vk::Device>& vulkan, const char* name, const std::vector<int>& frames)
{
    const auto description = std::make_shared<const scene::Scene>(scene::make_builtin(name));
    std::vector<double> times;
    for (const int frame : frames) times.push_back(description->timeline.time_of(frame));
    return follow(vulkan, description, times);
}

TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnCornell)
{
    GNOMON_NEED_RAYS;
    follow_frames(device_, "cornell", {1, 2, 20});
}

TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnKinetic)
{
    GNOMON_NEED_RAYS;
    follow_frames(device_, "kinetic", {1, 2, 60});
}

TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnSpheres)
{
    GNOMON_NEED_RAYS;
    follow_frames(device_, "spheres?objects=100&dynamic=20&vertices=200", {1, 2});
}

// Masks, glass, mirrored instances, deforming meshes, with and without a moving node.
TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnRandomScenes)
{
    GNOMON_NEED_RAYS;
    for (const std::uint64_t seed : {11u, 12u, 13u}) follow(device_, test::make_random_scene(seed), {0.4, 0.5, 1.7, 3});
}

// Leaves whose holes come from all possible sources of alpha: a filtered texture that is rotated, repeated and
// mirrored, with either set of coordinates; vertex alpha; material alpha; two cutoffs in one mesh.
std::shared_ptr<const scene::Scene> leaf_scene()
{
    scene::Scene scene;
    Random random(9);
    Image8 image(16, 8, 4);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) image.pixel(x, y)[3] = static_cast<std::uint8_t>(random.below(256));
    for (const auto& [u, v] :
         {std::pair(scene::Wrap::repeat, scene::Wrap::mirror), std::pair(scene::Wrap::clamp, scene::Wrap::repeat)}) {
        scene::Sampler sampler;
        sampler.wrap_u = u, sampler.wrap_v = v;
        scene.textures.emplace_back("holes", image, true, sampler);
    }
    scene.materials.resize(4);
    for (std::uint32_t m = 1; m < 4; ++m) {
        scene::Material& material = scene.materials[m];
        material.alpha_mode = scene::AlphaMode::mask;
        material.alpha = 0.9f;
        material.alpha_cutoff = 0.2f + 0.1f * static_cast<float>(m);
        if (m == 3) continue;   // vertex alpha only
        material.base_color_texture.texture = m - 1;
        material.base_color_texture.texcoord = static_cast<int>(m - 1);
        material.base_color_texture.rotation = 0.4f;
        material.base_color_texture.scale = {2.3f, 1.7f};
        material.base_color_texture.offset = {-0.6f, 0.2f};
    }
    scene::Mesh leaf;
    leaf.positions = {{0, 0, 0}, {1, 0, 0.2f}, {0.2f, 1, 0}, {1, 1, 0.3f}, {0.5f, 2, -0.2f}};
    leaf.triangles = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {0, 2, 4}};
    leaf.parts = {{1, 0, 1}, {2, 1, 1}, {3, 2, 1}, {0, 3, 1}};
    for (std::size_t i = 0; i < leaf.positions.size(); ++i) {
        for (auto& set : leaf.texcoords) set.emplace_back(random.uniform(-1, 2), random.uniform(-1, 2));
        leaf.colors.emplace_back(1, 1, 1, random.uniform(0.2f, 1));
    }
    scene.meshes.push_back(leaf);
    for (int i = 0; i < 60; ++i) {
        const scene::NodeId node = test::add_object(scene, 0, scene::none, test::random_placement(random, 3));
        if (i % 3 == 0)
            scene.nodes[node].transform =
                std::make_shared<test::SwayTrack>(glm::dvec3(random.uniform(-3.0f, 3.0f), 0, 1), 40u + i);
    }
    return test::finished(scene);
}

TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnAlphaTestedLeaves)
{
    GNOMON_NEED_RAYS;
    follow(device_, leaf_scene(), {0, 0.2, 1});
}

// A ball, one half of which follows a moving joint, in a ring of static balls.
std::shared_ptr<const scene::Scene> skinned_scene()
{
    scene::Scene scene;
    test::add_materials(scene);
    scene.meshes.push_back(test::patchwork(1));
    scene.meshes.push_back(test::ball(test::two_sided));
    scene::Mesh& mesh = scene.meshes.edit(0);
    mesh.skin.emplace();
    for (const glm::vec3& p : mesh.positions) {
        const float weight = std::clamp(0.5f * p.y + 0.5f, 0.0f, 1.0f);
        mesh.skin->joints[0].emplace_back(0, 1, 0, 0);
        mesh.skin->weights[0].emplace_back(1 - weight, weight, 0, 0);
    }
    const scene::NodeId still = scene.add_node("still", scene::none), moving = scene.add_node("moving", scene::none);
    scene.nodes[moving].transform = std::make_shared<test::SwayTrack>(glm::dvec3(0), 5, 1.5);
    scene.skins.push_back({"", {still, moving}, {glm::dmat4(1), glm::dmat4(1)}});
    scene.nodes[test::add_object(scene, 0)].skin = 0;
    for (int i = 0; i < 6; ++i)
        test::add_object(scene, 1, scene::none, test::translation(3 * std::cos(i), 0.3 * i, 3 * std::sin(i)));
    return test::finished(scene);
}

TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnASkinnedBall)
{
    GNOMON_NEED_RAYS;
    follow(device_, skinned_scene(), {0, 0.3, 0.4, 2});
}

scene::Mesh box_mesh()
{
    scene::Mesh mesh;
    for (std::uint32_t axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
                glm::vec3 p(0);
                p[static_cast<int>(axis)] = side;
                p[static_cast<int>((axis + 1) % 3)] = corner.x;
                p[static_cast<int>((axis + 2) % 3)] = corner.y;
                mesh.positions.push_back(p);
                mesh.normals.emplace_back(glm::vec3(0));
                mesh.normals.back()[static_cast<int>(axis)] = side;
            }
            mesh.triangles.emplace_back(first, first + 1, first + 2);
            mesh.triangles.emplace_back(first, first + 2, first + 3);
        }
    mesh.parts = {{test::two_sided, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

// Axis-aligned boxes, some of which jump at time 1; one has a singular transform, another from then on.
std::shared_ptr<const scene::Scene> box_scene()
{
    scene::Scene scene;
    test::add_materials(scene);
    scene.meshes.push_back(box_mesh());
    Random random(7);
    const auto place = [&](const glm::dvec3& stretch) {
        const double x = random.uniform(-6.0f, 6.0f), y = random.uniform(-6.0f, 6.0f);
        return glm::scale(test::translation(x, y, random.uniform(-6.0f, 6.0f)), stretch);
    };
    const glm::dvec3 flat(3, 0, 3), plain(0.7, 1, 1.3);
    for (int i = 0; i < 24; ++i) test::add_object(scene, 0, scene::none, place(i == 0 ? flat : plain));
    for (int i = 0; i < 8; ++i) {
        const scene::NodeId node = test::add_object(scene, 0);
        const glm::dmat4 before = place(plain), after = place(i == 0 ? flat : plain);
        scene.nodes[node].transform = std::make_shared<test::JumpTrack>(1, before, after);
    }
    return test::finished(scene);
}

// Rays whose result RayScene does not change in their neighbourhood.
ray::RayQueue clear_rays(const ray::RayScene& rays, const scene::SceneState& state, std::uint64_t seed)
{
    const ray::RayQueue all = surface_rays(rays, state, seed, k_rays);
    ray::RayQueue clear;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!on_an_edge(rays, all, i, Against::static_only) && !on_an_edge(rays, all, i, Against::dynamic_only))
            clear.push(all.origin(i), all.tnear[i], all.direction(i), all.tfar[i]);
    return clear;
}

// For rays that pass no edge, every result is equal: after the build, after a jump, and after user overrides of static
// objects. Only changed structures are rebuilt.
TEST_F(DeviceRaysVulkan, AgreesWithRaySceneOnEveryRayAwayFromEdges)
{
    GNOMON_NEED_RAYS;
    const auto description = box_scene();
    scene::SceneState state(description, 0);
    ray::RayScene rays(state);
    gpu_scene::GpuScene scene(device_, state);
    DeviceRays device(device_, scene, state);
    vk::Commands commands(device_);
    EXPECT_EQ(device.work().bottom_levels, 2u);   // the mesh, and the object with a singular transform
    Compared sum;
    const auto trace = [&](std::uint64_t seed) {
        const ray::RayQueue queue = clear_rays(rays, state, seed);
        EXPECT_GT(queue.size(), 99 * k_rays / 100);
        compare(commands, scene, device, rays, queue, sum);
    };
    const auto step = [&](double time) {
        state.advance(time);
        rays.update(state);
        scene.update(commands, state);
        device.update(commands, scene, state);
    };
    trace(1);
    step(0.5);
    EXPECT_EQ(device.work().top_levels, 0u);
    EXPECT_EQ(device.work().instances, 0u);
    trace(2);
    step(1.5);
    EXPECT_EQ(device.work().bottom_levels, 0u);
    EXPECT_EQ(device.work().top_levels, 1u);
    EXPECT_EQ(device.work().instances, 8u);
    trace(3);
    for (const scene::ObjectId o : {0u, 1u}) {   // one of them was flat
        const glm::dmat4 there = test::translation(2.5 * o, 0, 1);
        state.override_transform(description->objects[o].node, &there);
    }
    step(1.6);
    EXPECT_EQ(device.work().instances, 2u);
    trace(4);
    EXPECT_EQ(sum.differing, 0u);

    // A DeviceRays created now treats the same objects as dynamic as the RayScene.
    DeviceRays late(device_, scene, state);
    compare(commands, scene, late, rays, clear_rays(rays, state, 5), sum);
    EXPECT_EQ(sum.differing, 0u);
    EXPECT_GT(late.bytes(), 10'000u);
}

// NaN vertices, or vertices out of range, remove their triangles and nothing else; a mesh with NaN vertices for a while
// is not hit, and is complete again afterwards.
TEST_F(DeviceRaysVulkan, SkipsTrianglesWithNonFiniteCorners)
{
    GNOMON_NEED_RAYS;
    scene::Scene scene = test::scene_with_balls();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    scene.meshes.push_back(test::patchwork(3));
    const float strange[] = {nan, k_infinity, -1e30f};
    for (std::size_t i = 0; i < 9; ++i)
        scene.meshes.edit(1).positions[9 * i + 5][static_cast<int>(i % 3)] = strange[i / 3];
    scene.meshes.push_back(test::patchwork(4));
    scene::VertexKeys keys;
    keys.times = {0, 1, 2, 3};
    keys.positions.assign(4, scene.meshes[2].positions);
    for (const std::size_t key : {1u, 2u})
        std::fill(keys.positions[key].begin(), keys.positions[key].end(), glm::vec3(nan));
    for (glm::vec3& p : keys.positions[3]) p *= 1.2f;
    scene.meshes.edit(2).vertex_keys = std::move(keys);
    for (scene::MeshId m = 0; m < 3; ++m) {
        test::add_object(scene, m, scene::none, test::translation(2.5 * m, 0, 0));
        test::add_object(scene, m, scene::none, test::translation(2.5 * m, 1, 3));
    }
    const auto description = test::finished(scene);

    for (const double start : {0.0, 1.5}) {
        scene::SceneState state(description, start);
        ray::RayScene rays(state);
        gpu_scene::GpuScene gpu(device_, state);
        DeviceRays device(device_, gpu, state);
        vk::Commands commands(device_);
        Compared sum;
        for (const double time : {start, 1.5, 3.0, 3.5}) {
            if (time > start) {
                state.advance(time);
                rays.update(state);
                gpu.update(commands, state);
                device.update(commands, gpu, state);
            }
            ray::RayQueue queue;
            Random random(5);
            for (std::size_t i = 0; i < k_rays; ++i) {
                const auto point = [&] {
                    const float x = random.uniform(-1.5f, 6.5f), y = random.uniform(-1.5f, 2.5f);
                    return glm::vec3(x, y, random.uniform(-1.5f, 4.5f));
                };
                const glm::vec3 from = point(), to = point();
                queue.push(from, 0, to - from, 1);
            }
            compare(commands, gpu, device, rays, queue, sum);
        }
        EXPECT_LE(static_cast<double>(sum.differing), k_differing * static_cast<double>(sum.traced));
        EXPECT_GT(sum.occluded, sum.traced / 20);
    }
}

// More rays than fit into one dispatch, degenerate rays, and an empty scene.
TEST_F(DeviceRaysVulkan, AcceptsEmptyLargeAndDegenerateQueues)
{
    GNOMON_NEED_RAYS;
    const auto description = box_scene();
    const scene::SceneState state(description, 0);
    const ray::RayScene rays(state);
    const gpu_scene::GpuScene scene(device_, state);
    DeviceRays device(device_, scene, state);
    vk::Commands commands(device_);

    const ray::RayQueue some = clear_rays(rays, state, 1);
    ray::RayQueue many;
    while (many.size() <= DeviceRays::k_rays_at_once + 1000) {
        const std::size_t i = many.size() % some.size();
        many.push(some.origin(i), some.tnear[i], some.direction(i), some.tfar[i]);
    }
    std::vector<std::uint8_t> expected(many.size()), answers(many.size(), 2);
    rays.occluded(many, 0, many.size(), expected.data());
    device.occluded(commands, scene, many, answers.data());
    EXPECT_EQ(answers, expected);

    // Ends out of range, behind the origin, and NaN.
    const float inf = k_infinity, nan = std::numeric_limits<float>::quiet_NaN();
    ray::RayQueue odd;
    for (std::size_t i = 0; i < 2000; ++i) {
        glm::vec3 from = some.origin(i), along = some.direction(i);
        float numbers[] = {from.x, from.y, from.z, 0, along.x, along.y, along.z, inf};
        const float strange[] = {inf, -inf, nan, 2e9f, -2e9f, 3e38f, 0};
        if (i % 3 > 0) numbers[i % 8] = strange[i % 7];
        odd.push({numbers[0], numbers[1], numbers[2]}, numbers[3], {numbers[4], numbers[5], numbers[6]}, numbers[7]);
    }
    odd.push(some.origin(0), 0, glm::vec3(0), 1);
    odd.push(some.origin(0), -1, some.direction(0), 1);
    odd.push(some.origin(0), 0.5f, some.direction(0), 0.25f);
    expected.assign(odd.size(), 0), answers.assign(odd.size(), 2);
    rays.occluded(odd, 0, odd.size(), expected.data());
    device.occluded(commands, scene, odd, answers.data());
    for (std::size_t i = 0; i < odd.size(); ++i)
        EXPECT_EQ(answers[i], expected[i])
            << fmt::format("ray {}: {} {} {}, {}; {} {} {}, {}", i, odd.ox[i], odd.oy[i], odd.oz[i], odd.tnear[i],
                           odd.dx[i], odd.dy[i], odd.dz[i], odd.tfar[i]);
    EXPECT_GT(std::count(answers.begin(), answers.end(), 1), 200);

    device.occluded(commands, scene, ray::RayQueue(), nullptr);

    scene::Scene nothing;
    const scene::SceneState empty(test::finished(nothing), 0);
    const gpu_scene::GpuScene empty_scene(device_, empty);
    DeviceRays empty_rays(device_, empty_scene, empty);
    answers.assign(some.size(), 2);
    empty_rays.occluded(commands, empty_scene, some, answers.data());
    EXPECT_EQ(answers, std::vector<std::uint8_t>(some.size(), 0));
}

}   // namespace
}   // namespace gnomon
#else
TEST(DeviceRaysVulkan, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
