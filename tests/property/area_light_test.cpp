// SPDX-License-Identifier: Apache-2.0
// Lights with size that a host adds give surfaces what their closed forms say, whole and half hidden.
#include <gtest/gtest.h>

#include "base/math.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

constexpr float k_albedo = 0.5f;

struct SeenOptions {
    float distance = 1;
    bool half_hidden = false;   // by a blind at half the way, over x < 0
};

// What the centre of a small matte floor shows below a light.
float floor_radiance(const AreaLight& light, const SeenOptions& o)
{
    SceneBuilder builder;
    builder.area_light(light, Transform::translation(0, 0, static_cast<double>(o.distance)));
    const MaterialId grey = builder.material(
        {.base_color = {k_albedo, k_albedo, k_albedo}, .double_sided = true, .roughness = 1, .ior = 1});
    const test::Shape floor = test::square(0.5f);
    const MeshId square = builder.mesh(floor.mesh());
    builder.instance(square, grey);
    if (o.half_hidden)
        builder.instance(
            square, grey,
            Transform::translation(-50, 0, 0.5 * static_cast<double>(o.distance)) * Transform::scaling(100, 100, 1));
    Camera camera;
    camera.transform = Transform::look_at({0.1f, 0.01f, 0.08f}, {0, 0, 0});
    camera.vertical_fov = 1e-3;
    builder.camera(camera);
    RenderOptions options;
    options.size = {1, 1};
    options.indirect = Indirect::off;
    return Renderer(options).render(builder.finish(), 1).layers.front().values()[0];
}

TEST(AreaLights, DiscGivesItsClosedForm)
{
    // [Nusselt 1928]: the form factor of a disc on the axis.
    for (const float distance : {0.2f, 1.0f, 5.0f}) {
        const float truth = k_albedo * 4 * 0.25f / (0.25f + distance * distance);
        const AreaLight disc{.shape = AreaLightShape::disc, .radiance = {4, 4, 4}};
        EXPECT_NEAR(floor_radiance(disc, {.distance = distance}), truth, 0.003f * truth) << distance;
        EXPECT_NEAR(floor_radiance(disc, {.distance = distance, .half_hidden = true}), 0.5f * truth, 0.006f * truth)
            << distance;
    }
}

TEST(AreaLights, SphereGivesItsClosedForm)
{
    for (const float distance : {1.0f, 3.0f}) {
        const float truth = k_albedo * 4 * 0.25f / (distance * distance);
        const AreaLight sphere{.shape = AreaLightShape::sphere, .radiance = {4, 4, 4}};
        EXPECT_NEAR(floor_radiance(sphere, {.distance = distance}), truth, 0.01f * truth) << distance;
    }
}

TEST(AreaLights, RectangleEmitsAlongItsAxisAlone)
{
    const AreaLight rectangle{.width = 2, .height = 0.5f};
    EXPECT_GT(floor_radiance(rectangle, {}), 0);
    // Seen from behind: the floor lies along +Z.
    const auto behind = [&](bool two_sided) {
        SceneBuilder b;
        AreaLight light = rectangle;
        light.two_sided = two_sided;
        b.area_light(light, Transform::translation(0, 0, -1));
        const MaterialId grey = b.material({.double_sided = true, .roughness = 1, .ior = 1});
        b.instance(b.mesh(test::square(0.5f).mesh()), grey);
        Camera camera;
        camera.transform = Transform::look_at({0.1f, 0.01f, -0.08f}, {0, 0, 0});
        camera.vertical_fov = 1e-3;
        b.camera(camera);
        RenderOptions options;
        options.size = {1, 1};
        options.indirect = Indirect::off;
        return Renderer(options).render(b.finish(), 1).layers.front().values()[0];
    };
    EXPECT_EQ(behind(false), 0);
    EXPECT_GT(behind(true), 0);
}

TEST(AreaLights, WhatIsWrongLeavesTheBuilderAsItWas)
{
    SceneBuilder builder;
    EXPECT_NE(test::usage_error([&] { builder.area_light({.width = 0}); }), "");
    EXPECT_NE(test::usage_error([&] { builder.area_light({.radiance = {-1, 0, 0}}); }), "");
    EXPECT_NE(test::usage_error([&] { builder.area_light({.shape = static_cast<AreaLightShape>(7)}); }), "");
    SceneBuilder other;
    const NodeId elsewhere = other.node();
    EXPECT_NE(test::usage_error([&] { builder.area_light({}, {}, {.parent = elsewhere}); }), "");
    EXPECT_EQ(builder.finish().info().objects, 0u);
}

TEST(AreaLights, IsDimmedByItsMaterial)
{
    SceneBuilder builder;
    const AreaLightParts parts = builder.area_light({.shape = AreaLightShape::disc, .radiance = {2, 2, 2}});
    builder.set_material(parts.material, {.base_color = {0, 0, 0}, .emissive = {1, 1, 1}});
    Camera camera;
    camera.transform = Transform::look_at({0, 0, -1}, {0, 0, 0});
    camera.vertical_fov = 1e-3;
    builder.camera(camera);
    RenderOptions options;
    options.size = {1, 1};
    options.indirect = Indirect::off;
    EXPECT_EQ(Renderer(options).render(builder.finish(), 1).layers.front().values()[0], 1);
}

}   // namespace
}   // namespace gnomon
