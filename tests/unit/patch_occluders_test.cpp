// SPDX-License-Identifier: Apache-2.0
// What static triangles hide from patches: nothing that a ray reaches, and most of what no ray reaches.
#include "irradiance_cache/light_tree/patch_occluders.h"

#include <gtest/gtest.h>

#include <cmath>

#include "api/scene_access.h"
#include "base/random.h"
#include "gnomon/gnomon.h"
#include "irradiance_cache/light_tree/light_tree.h"
#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using namespace irradiance_cache;

glm::vec3 random_point(Random& random, float size)
{
    const float x = random.uniform(-size, size), y = random.uniform(-size, size);
    return {x, y, random.uniform(-size, size)};
}

// Rays from random places, and from close above surfaces, in a box with two blocks.
TEST(TriangleShadow, HidesWhatNoRayReaches)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    Random random(3);
    std::size_t wrong = 0, hidden = 0, occluded = 0, unknown = 0;
    for (int k = 0; k < 200'000; ++k) {
        glm::vec3 from = random_point(random, 1.2f);
        const ray::Hit near = rays.closest_single(from, 0, random_point(random, 1), k_infinity, ray::Sides::both);
        if (near.object == scene::none || state.is_dynamic(near.object)) continue;
        glm::vec3 corners[3];
        rays.geometry(near.object).corners(near.triangle, corners);
        const glm::vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        const glm::vec3 at = (1 - near.u - near.v) * corners[0] + near.u * corners[1] + near.v * corners[2];
        // Of a few places, some are as close to the triangle as places of patches are.
        if (k % 4 == 0) from = at + std::pow(10.0f, random.uniform(-5.5f, 0)) * normal;
        const auto shadow = TriangleShadow::behind(corners, from);
        if (!shadow) {
            ++unknown;
            continue;
        }
        for (int i = 0; i < 4; ++i) {
            const glm::vec3 to = (1 + (i == 0 ? 1e-3f : 1.0f) * random.uniform(-1, 1)) * (at - from) +
                                 (i == 1 ? random_point(random, 0.3f) : glm::vec3(0));
            const bool is_hidden = shadow->hides(to, 0);
            const bool is_occluded =
                rays.occluded_single(from, 0, to, ray::k_shadow_ray_end, ray::Against::static_only);
            hidden += is_hidden, occluded += is_occluded, wrong += is_hidden && !is_occluded;
        }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(occluded, 100'000u);
    EXPECT_GT(hidden, occluded / 2);
    EXPECT_LT(unknown, 40'000u);
}

TEST(TriangleShadow, HidesASphereIfItHidesAllOfIt)
{
    const glm::vec3 corners[3]{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, from(0, 0, 1);
    const auto shadow = TriangleShadow::behind(corners, from);
    ASSERT_TRUE(shadow);
    Random random(5);
    std::size_t hidden = 0, wrong = 0;
    for (int k = 0; k < 10'000; ++k) {
        const glm::vec3 centre = random_point(random, 2) - glm::vec3(0, 0, 3);
        const float radius = random.uniform(0, 0.5f);
        if (!shadow->hides(centre, radius)) continue;
        ++hidden;
        for (int i = 0; i < 20; ++i) {
            const glm::vec3 place = centre + radius * glm::normalize(random_point(random, 1));
            // The way to the place crosses the plane within the triangle.
            const glm::vec2 at = glm::vec2(place) / -place.z;
            wrong += place.z > -1 || at.y < -1 || 2 * std::abs(at.x) + at.y > 1;
        }
    }
    EXPECT_GT(hidden, 500u);
    EXPECT_EQ(wrong, 0u);
}

TEST(TriangleShadow, OfATriangleSeenEdgeOnIsNone)
{
    const glm::vec3 corners[3]{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    EXPECT_FALSE(TriangleShadow::behind(corners, {3, 0, 0}));
    EXPECT_FALSE(TriangleShadow::behind(corners, {0, 0, 1e-6f}));
    const glm::vec3 line[3]{{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    EXPECT_FALSE(TriangleShadow::behind(line, {0, 0, 1}));
}

TEST(PatchOccluders, KeepOneTriangleForEachPatchAndOwner)
{
    const glm::vec3 front[3]{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, back[3]{{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}},
        from(0, 0, 1), before(0, 0, -5), behind(0, 0, 5);
    PatchOccluders occluders;
    occluders.limit();
    PatchOccluders::OfOwner &one = occluders.of(7, 600), &two = occluders.of(9, 600);
    EXPECT_EQ(one.find(599), nullptr);
    one.remember(599, *TriangleShadow::behind(front, from));
    two.remember(599, *TriangleShadow::behind(back, from));
    one.remember(3, *TriangleShadow::behind(back, from));
    ASSERT_TRUE(one.find(599) && two.find(599) && one.find(3));
    EXPECT_EQ(two.find(3), nullptr);
    EXPECT_TRUE(one.find(599)->hides(before, 0.1f) && !one.find(599)->hides(behind, 0.1f));
    EXPECT_TRUE(two.find(599)->hides(behind, 0.1f) && one.find(3)->hides(behind, 0.1f));
    one.remember(599, *TriangleShadow::behind(back, from));
    EXPECT_TRUE(one.find(599)->hides(behind, 0.1f));
    EXPECT_GT(occluders.bytes(), 3 * sizeof(TriangleShadow));
    occluders.forget();
    EXPECT_EQ(occluders.of(7, 600).find(599), nullptr);
}

// The light of patches is that of a new tree to the bit, and most rays to dynamic objects are not cast again.
TEST(PatchOccluders, LeaveOutRaysThatWereOccludedInTheFrameBefore)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state(scene, scene->timeline.time_of(3));
    ray::RayScene rays(state);
    Tasks tasks(2);
    LightTreeOptions options;
    options.patches.bounces = 1000;
    LightTree updated(state, rays, options, tasks);
    for (const int frame : {4, 5, 20, 21}) {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
        updated.update(state, rays, tasks);
        const LightTree fresh(state, rays, options, tasks);
        ASSERT_TRUE(updated.patch_light() && fresh.patch_light());
        const std::span<const glm::vec3> a = updated.patch_light()->flux(), b = fresh.patch_light()->flux();
        EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << "frame " << frame;
        EXPECT_GT(fresh.rays_to_dynamic(), 1000u);
        EXPECT_LT(updated.rays_to_dynamic(), fresh.rays_to_dynamic() / 2) << "frame " << frame;
    }
}

// A plate that alone is lit, by a light below a screen, lights a ceiling. From many places of it the screen hides the
// middle of the plate, and not all of it.
TEST(PatchOccluders, LeaveWhatIsHiddenInPartToRays)
{
    SceneBuilder builder;
    const std::vector<Vec3> corners{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> up{0, 2, 1, 0, 3, 2};
    const MeshId square = builder.mesh({.positions = corners, .indices = up});
    Material matte{.base_color = {0.5f, 0.5f, 0.5f}, .roughness = 1, .ior = 1};
    matte.double_sided = true;
    const MaterialId grey = builder.material(matte);
    builder.instance(square, grey, Transform::scaling(1.5, 1, 1.5), {.mobility = Mobility::may_move});
    builder.instance(square, grey, Transform::translation(0, 1, 0) * Transform::scaling(0.8, 1, 0.8));
    builder.instance(square, grey, Transform::translation(0, 2, 0) * Transform::scaling(4, 1, 4));
    builder.light({.type = LightType::spot, .color = {9, 9, 9}, .inner_angle = 0.5f, .outer_angle = 0.6f},
                  Transform::translation(0, 0.9, 0) * Transform::rotation({1, 0, 0}, -0.5 * k_pi));
    const auto scene = api::scene_of(builder.finish());
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    Tasks tasks(1);
    LightTreeOptions options;
    options.patches.bounces = 1000;
    LightTree updated(state, rays, options, tasks);
    const glm::dmat4 there(glm::dvec4(1.5, 0, 0, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 1.5, 0),
                           glm::dvec4(0.01, 0, 0, 1));
    state.override_transform(scene->objects[0].node, &there);
    state.advance(0);
    rays.update(state);
    updated.update(state, rays, tasks);
    const LightTree fresh(state, rays, options, tasks);
    ASSERT_TRUE(updated.patch_light() && fresh.patch_light());
    const std::span<const glm::vec3> a = updated.patch_light()->flux(), b = fresh.patch_light()->flux();
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    EXPECT_GT(std::ranges::count_if(a, [](const glm::vec3& flux) { return flux != glm::vec3(0); }), 100);
    EXPECT_LT(updated.rays_to_dynamic(), fresh.rays_to_dynamic());
}

}   // namespace
}   // namespace gnomon
