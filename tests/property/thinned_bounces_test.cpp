// SPDX-License-Identifier: Apache-2.0
// Light that bounces, and that of a sky, passes surfaces that are partly transparent as far as their alpha leaves it.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "scene/scene.h"

namespace gnomon {
namespace {

Material blend(float alpha)
{
    return {
        .base_color = {0, 0, 0}, .alpha = alpha, .alpha_mode = AlphaMode::blend, .roughness = 1, .double_sided = true};
}

enum class Lit { spot_above, spot_below, surface };

struct Room {
    SceneBuilder builder;
    MaterialId sheet;
};

// A floor in the plane z = -4, below a camera at the origin; a sheet behind the camera at z = 1; a wide ceiling at z =
// 3 that faces the floor. A light shines at the ceiling, from beyond the sheet or through it.
Room make_room(Lit lit, float alpha, bool there = true)
{
    Room room;
    SceneBuilder& b = room.builder;
    const MaterialId white = b.material({.base_color = {.8f, .8f, .8f}, .roughness = 1, .double_sided = true});
    const MaterialId floor = b.material({.base_color = {.5f, .5f, .5f}, .roughness = 1, .double_sided = true});
    b.instance(b.mesh(test::square(2).mesh()), floor, Transform::translation(0, 0, -4));
    b.instance(b.mesh(test::square(6).mesh()), white, Transform::translation(0, 0, 3));
    room.sheet = b.material(blend(alpha));
    if (there) b.instance(b.mesh(test::square(30).mesh()), room.sheet, Transform::translation(0, 0, 1));
    // Lights shine along -z; turn them around.
    Transform turned;
    turned.m[0] = turned.m[10] = -1;
    turned.m[14] = lit == Lit::spot_below ? 0.5 : 2;
    if (lit == Lit::surface)
        b.area_light({.width = 2, .height = 2, .radiance = {20, 20, 20}}, turned);
    else
        b.light({.type = LightType::spot, .color = {900, 900, 900}, .outer_angle = .9f}, turned);
    b.camera(test::camera_along_z());
    return room;
}

RenderOptions bounced(int bounces)
{
    RenderOptions options = test::plain({48, 48});
    options.indirect = Indirect::visible;
    options.bounces = bounces;
    return options;
}

float mean(const Frame& frame)
{
    const std::vector<float> values = frame.layers.front().copy();
    return std::accumulate(values.begin(), values.end(), 0.0f) / static_cast<float>(values.size());
}

float brightness(Room room, const RenderOptions& options)
{
    return mean(Renderer(options).render(room.builder.finish(), 1));
}

TEST(ThinnedBounces, PassASheetAsFarAsAlphaLeavesThem)
{
    for (const Lit lit : {Lit::spot_above, Lit::spot_below, Lit::surface}) {
        const float whole = brightness(make_room(lit, 0, false), bounced(1));
        ASSERT_GT(whole, 1e-3f) << static_cast<int>(lit);
        for (const float alpha : {0.0f, 0.25f, 0.75f}) {
            // Through the sheet once on the way back, and once on the way there.
            const float passes = lit == Lit::spot_below ? (1 - alpha) * (1 - alpha) : 1 - alpha;
            EXPECT_NEAR(brightness(make_room(lit, alpha), bounced(1)) / whole, passes, 0.01f)
                << "light " << static_cast<int>(lit) << " alpha " << alpha;
        }
        EXPECT_LT(brightness(make_room(lit, 1), bounced(1)), 0.01f * whole) << static_cast<int>(lit);
    }
}

TEST(ThinnedBounces, OfAllOrdersAgreeWithTheReference)
{
    for (const Lit lit : {Lit::spot_below, Lit::surface}) {
        RenderOptions truth = bounced(32);
        truth.reference = ReferenceLightOptions{.spp = 256, .bounces = 32};
        const float expected = brightness(make_room(lit, 0.5f), truth);
        EXPECT_NEAR(brightness(make_room(lit, 0.5f), bounced(32)) / expected, 1, 0.05f) << static_cast<int>(lit);
    }
}

TEST(ThinnedBounces, AnotherAlphaFromAHostIsThatOfANewRenderer)
{
    for (const Lit lit : {Lit::spot_below, Lit::surface}) {
        Room room = make_room(lit, 0.25f);
        const Scene scene = room.builder.finish();
        FrameInput input;
        input.materials.push_back({room.sheet, blend(0.5f)});
        Renderer kept(bounced(8));
        const float before = mean(kept.render(scene, 1));
        const Frame now = kept.render(scene, input), fresh = Renderer(bounced(8)).render(scene, input);
        EXPECT_LT(mean(now), 0.8f * before);
        EXPECT_EQ(now.layers.front().copy(), fresh.layers.front().copy()) << static_cast<int>(lit);
    }
}

// Under an even sky of radiance 1, a floor of albedo .5 below a black sheet has radiance .5 (1 - alpha).
TEST(ThinnedBounces, AnEvenSkyReachesAFloorAsFarAsAlphaLeavesIt)
{
    for (const float alpha : {0.0f, 0.5f, 0.75f}) {
        scene::Scene scene;
        scene::Material floor, sheet;
        floor.base_color = glm::vec3(0.5f);
        floor.roughness = sheet.roughness = 1;
        floor.double_sided = sheet.double_sided = true;
        floor.ior = sheet.ior = 1;   // no highlights
        sheet.base_color = glm::vec3(0);
        sheet.alpha = alpha;
        sheet.alpha_mode = scene::AlphaMode::blend;
        scene.materials = {floor, sheet};
        for (const scene::MaterialId m : {0u, 1u}) {
            const float half = m == 0 ? 2.0f : 300.0f;
            scene::Mesh mesh;
            mesh.positions = {{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}};
            mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
            mesh.parts = {{m, 0, 2}};
            scene.meshes.push_back(mesh);
            scene
                .nodes[scene.add_node("", scene::none, glm::translate(glm::dmat4(1), glm::dvec3(0, m == 0 ? 0 : 2, 0)))]
                .mesh = m;
        }
        scene.background.kind = scene::Background::Kind::sky;
        scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(1);
        const glm::dmat4 down = glm::rotate(glm::dmat4(1), -k_pi / 2, glm::dvec3(1, 0, 0));
        scene.cameras.emplace_back().node =
            scene.add_node("camera", scene::none, glm::translate(glm::dmat4(1), glm::dvec3(0, 1, 0)) * down);
        scene.finish();
        const Scene seen = api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
        const Frame frame = Renderer(bounced(1)).render(seen, 1);
        EXPECT_NEAR(frame.layers.front().value(24, 24, 1), 0.5f * (1 - alpha), 0.01f) << alpha;
    }
}

}   // namespace
}   // namespace gnomon
