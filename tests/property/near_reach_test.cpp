// SPDX-License-Identifier: Apache-2.0
// What the near field remembers of its short rays: fewer are cast while dynamic objects move, for the same answer.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "irradiance_cache/near_field/near_light.h"

namespace gnomon {
namespace {

using irradiance_cache::LightWay;
using irradiance_cache::NearAnswer;
using irradiance_cache::NearReceiver;
using irradiance_cache::ReachSteps;
using irradiance_cache::Sphere;

constexpr float k_radius = 1.5f;
constexpr int k_plates = 6;

MeshId add_square(SceneBuilder& builder)
{
    const std::vector<Vec3> corners{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> up{0, 2, 1, 0, 3, 2};
    return builder.mesh({.positions = corners, .indices = up});
}

// A floor and two walls under a sun, a point light and a spot, with plates that may move above the floor.
class Corner {
 public:
    Corner()
    {
        SceneBuilder builder;
        Material matte{.base_color = {0.7f, 0.6f, 0.5f}, .roughness = 1, .ior = 1};
        matte.double_sided = true;
        const MaterialId white = builder.material(matte);
        const MeshId square = add_square(builder);
        builder.instance(square, white, Transform::scaling(6, 1, 6));
        builder.instance(square, white,
                         Transform::translation(-3, 2, 0) * Transform::rotation({0, 0, 1}, 1.5707964f) *
                             Transform::scaling(4, 1, 6));
        builder.instance(square, white,
                         Transform::translation(0, 2, -3) * Transform::rotation({1, 0, 0}, 1.5707964f) *
                             Transform::scaling(6, 1, 4));
        for (int i = 0; i < k_plates; ++i) {
            const Sphere s = sphere(i);
            builder.instance(
                square, white,
                Transform::translation(s.centre.x, s.centre.y, s.centre.z) * Transform::scaling(side(s), 1, side(s)),
                {.mobility = Mobility::may_move});
        }
        Light light{.color = {2, 2, 2}};
        light.type = LightType::directional;
        builder.light(light, Transform::look_at({0, 0, 0}, {-1, -2, -0.6f}));
        light.type = LightType::point;
        builder.light(light, Transform::translation(1, 2.5f, 0.5f));
        light.type = LightType::spot;
        light.outer_angle = 0.9f;
        builder.light(light, Transform::look_at({1.5f, 3, 1.5f}, {-2, 0, -2}));
        Camera camera;
        camera.transform = Transform::look_at({4, 3, 4}, {-1, 1, -1});
        builder.camera(camera);
        scene = api::scene_of(builder.finish());
        for (int i = 0; i < k_plates; ++i) {
            const Sphere s = sphere(i);
            Box3 own;
            own.add({-0.5f, 0, -0.5f}), own.add({0.5f, 0, 0.5f});
            const glm::mat4 to_world = glm::scale(glm::translate(glm::mat4(1), s.centre), {side(s), 1, side(s)});
            spheres.add(std::vector<Sphere>{s});
            boxes.add(std::vector<irradiance_cache::MovingSpheres::Object>{
                {s, irradiance_cache::MovingBox::around(own, to_world, s)}});
        }
    }
    static float side(const Sphere& s) { return 1.3f * s.radius; }
    // Around a plate.
    static Sphere sphere(int i)
    {
        const auto f = static_cast<float>(i);
        return {{-2.4f + 0.8f * f, 0.3f + 0.35f * f, 1.5f - 0.9f * f}, 0.15f + 0.03f * f};
    }
    // Places near the floor and the walls, and in the air, which face any way.
    std::vector<NearReceiver> receivers(std::size_t count) const
    {
        std::minstd_rand random(7);
        std::uniform_real_distribution<float> unit(0, 1);
        std::vector<NearReceiver> all;
        while (all.size() < count) {
            const glm::vec3 at(6 * unit(random) - 2.9f, 2 * unit(random) * unit(random) + 0.01f,
                               6 * unit(random) - 2.9f);
            const glm::vec3 way(2 * unit(random) - 1, 2 * unit(random) - 1, 2 * unit(random) - 1);
            if (!(glm::length(way) > 0.1f)) continue;
            all.push_back({at, glm::normalize(way), glm::normalize(way)});
        }
        return all;
    }
    std::shared_ptr<const scene::Scene> scene;
    irradiance_cache::MovingSpheres spheres, boxes;   // around the plates; the latter with boxes
};

TEST(NearReach, TheSameChangeToTheBitWithAFractionOfTheRays)
{
    const Corner corner;
    const scene::SceneState state(corner.scene, 0);
    const ray::RayScene rays(state);
    irradiance_cache::NearOptions options;
    options.radius = k_radius;
    const irradiance_cache::NearLight near(options);
    irradiance_cache::NearLight::Scratch scratch;
    std::vector<NearReceiver> receivers = corner.receivers(2000);
    const auto directions = static_cast<std::size_t>(options.rays);
    std::vector<NearAnswer> lit(receivers.size()), all(receivers.size()), few(receivers.size());
    std::vector<std::uint8_t> reach(receivers.size() * directions);
    near.gather(state, rays, receivers.data(), receivers.size(), ray::Against::static_only, scratch, lit.data(),
                reach.data());
    scratch.cast = 0;
    near.find_change(state, rays, corner.spheres, receivers.data(), receivers.size(), scratch, all.data());
    const std::uint64_t of_all = scratch.cast;
    for (std::size_t k = 0; k < receivers.size(); ++k)
        receivers[k].reach = std::span(reach).subspan(k * directions, directions);
    scratch.cast = 0;
    near.find_change(state, rays, corner.spheres, receivers.data(), receivers.size(), scratch, few.data());
    std::size_t changed = 0, differ = 0;
    for (std::size_t k = 0; k < receivers.size(); ++k)
        for (int colour = 0; colour < 3; ++colour) {
            changed += all[k].light[colour] != glm::vec3(0);
            differ += all[k].light[colour] != few[k].light[colour];
        }
    EXPECT_EQ(differ, 0u);
    EXPECT_GT(changed, 300u);
    EXPECT_LT(scratch.cast, of_all / 4);
    const std::uint64_t of_spheres = scratch.cast;
    std::printf("%zu of %zu receivers change; %.3f of the rays\n", changed / 3, receivers.size(),
                static_cast<double>(of_spheres) / static_cast<double>(of_all));

    // Boxes leave out most of the rest.
    std::vector<NearAnswer> boxed(receivers.size());
    scratch.cast = 0;
    near.find_change(state, rays, corner.boxes, receivers.data(), receivers.size(), scratch, boxed.data());
    for (std::size_t k = 0; k < receivers.size(); ++k)
        for (int colour = 0; colour < 3; ++colour) EXPECT_EQ(boxed[k].light[colour], all[k].light[colour]) << k;
    EXPECT_LT(scratch.cast, of_spheres * 3 / 4);
    std::printf("with boxes, %.2f of these\n", static_cast<double>(scratch.cast) / static_cast<double>(of_spheres));
}

// A surface that bytes cannot place is never left out.
TEST(NearReach, WhatStepsCannotTellIsDoubted)
{
    const ReachSteps steps(1);
    const glm::vec3 at(0), up(0, 1, 0);
    for (const float t : {0.001f, 0.3f, 0.5f, 0.999f, 1.0f}) {
        const std::uint8_t reach = steps.encode(at, up, t, t * up);
        ASSERT_NE(reach, ReachSteps::k_inexact) << t;
        EXPECT_GE(steps.decode(reach), t);
        EXPECT_LT(steps.decode(reach), t + 2 * steps.step());
    }
    EXPECT_EQ(steps.encode(at, up, 0.5f, {0.1f, 0.5f, 0}), ReachSteps::k_inexact);
    EXPECT_EQ(steps.encode(at, up, 1.1f, 1.1f * up), ReachSteps::k_inexact);

    const std::vector<glm::vec3> directions{{0, 0, 1}, {0.6f, 0, 0.8f}, {-0.6f, 0, 0.8f}};
    const std::vector<std::uint8_t> reach{ReachSteps::k_nothing_lit, ReachSteps::k_inexact, 100};
    irradiance_cache::NearDoubts doubts(1, directions);
    irradiance_cache::MovingSpheres spheres;
    spheres.add({{{50, 0, 0}, 1}});
    std::vector<std::uint32_t> doubted;
    const std::vector<LightWay> lights{{true, {0, 0, 1}}};
    doubts.find({at, {0, 0, 1}, {0, 0, 1}, reach}, glm::mat3(1), lights, spheres, doubted);
    EXPECT_EQ(doubted, std::vector<std::uint32_t>{1});
}

}   // namespace
}   // namespace gnomon
