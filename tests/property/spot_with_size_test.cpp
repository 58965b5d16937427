// SPDX-License-Identifier: Apache-2.0
// Spots with size: spheres that emit within a cone. From afar they are spot lights; near by they light, and are seen,
// as in the path-traced reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "base/math.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "two_references.h"

namespace gnomon {
namespace {

using test::plain;

constexpr float k_inner = 0.25f, k_outer = 0.6f;

AreaLight spot(float radius, float radiance)
{
    return {.shape = AreaLightShape::sphere,
            .width = 2 * radius,
            .radiance = {radiance, radiance, radiance},
            .hidden_from_camera = true,
            .inner_angle = k_inner,
            .outer_angle = k_outer};
}

const test::Shape k_ground{{{-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4}}, {0, 1, 2, 0, 2, 3}};

void add_floor_and_camera(SceneBuilder& b)
{
    b.instance(b.mesh(k_ground.mesh()), b.material({.base_color = {.6f, .6f, .6f}, .roughness = 1, .ior = 1}));
    Camera camera;
    camera.transform = Transform::look_at({0, 3, 3}, {0, 0, 0});
    camera.vertical_fov = .8;
    b.camera(camera);
}

std::vector<float> rendered(const Scene& scene, const RenderOptions& options, int frame = 1)
{
    const Frame image = Renderer(options).render(scene, frame);
    const auto values = image.layers.front().values();
    return {values.begin(), values.end()};
}

RenderOptions options_of(int size, Indirect indirect = Indirect::off)
{
    RenderOptions options = plain({size, size});
    options.indirect = indirect;
    return options;
}

TEST(SpotsWithSize, AreSpotLightsFromAfar)
{
    const Transform place = Transform::look_at({.3f, 2, .2f}, {.2f, 0, 0}, {1, 0, 0});
    constexpr float radius = .01f, radiance = 4e4f;
    SceneBuilder sized, point;
    sized.area_light(spot(radius, radiance), place);
    const float candela = radiance * static_cast<float>(k_pi) * radius * radius;
    Light like{.color = {candela, candela, candela}};
    like.type = LightType::spot, like.profile = SpotProfile::smooth_cosine;
    like.inner_angle = k_inner, like.outer_angle = k_outer;
    point.light(like, place);
    for (SceneBuilder* b : {&sized, &point}) add_floor_and_camera(*b);
    const std::vector<float> a = rendered(sized.finish(), options_of(48)), b = rendered(point.finish(), options_of(48));
    float most = 0, difference = 0;
    std::size_t dark = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        most = std::max(most, b[i]), difference = std::max(difference, std::abs(a[i] - b[i]));
        dark += b[i] == 0;
    }
    EXPECT_GT(most, .5f);
    EXPECT_GT(dark, a.size() / 4);
    EXPECT_LE(difference, .01f * most);
}

// A wide one beside a post; fixed, or a part of what moves together.
Scene beside_a_post(bool moves)
{
    SceneBuilder b;
    add_floor_and_camera(b);
    const InstanceOptions options{.mobility = moves ? Mobility::may_move : Mobility::fixed};
    b.area_light(spot(.25f, 6), Transform::look_at({.8f, 1.6f, .3f}, {-.2f, 0, 0}, {0, 0, 1}), options);
    b.instance(b.mesh(test::cube(.2f).mesh()), b.material({.base_color = {.7f, .4f, .2f}, .roughness = 1, .ior = 1}),
               Transform::translation(-.1, .4, .1));
    return b.finish();
}

TEST(SpotsWithSize, LightAsInTheReference)
{
    for (const bool moves : {false, true}) {
        const Scene scene = beside_a_post(moves);
        RenderOptions options = options_of(40, Indirect::visible);
        options.bounces = 2;
        const std::vector<float> image = rendered(scene, options);
        std::vector<float> truth[2];
        for (const std::uint64_t seed : {0u, 1u}) {
            options.reference = ReferenceLightOptions{.spp = 256, .bounces = 2, .seed = seed};
            truth[seed] = rendered(scene, options);
        }
        const test::ErrorOfImage error = test::error_of(image, truth[0], truth[1]);
        RecordProperty("nrmse", std::to_string(error.nrmse));
        EXPECT_LE(error.nrmse, .05) << moves;
        EXPECT_NEAR(error.energy, 1, .02) << moves;
    }
}

// Three spheres, so many triangles that they are lit by in clusters: two spots that face different ways, and one that
// shines in all directions.
TEST(SpotsWithSize, HaveConesOfTheirOwn)
{
    const Transform down = Transform::look_at({-1, 1, 0}, {-1, 0, 0}, {1, 0, 0}),
                    up = Transform::look_at({0, 1, 0}, {0, 2, 0}, {1, 0, 0}), aside = Transform::translation(1.2, 1, 0);
    const auto lit = [&](int which) {
        SceneBuilder b;
        add_floor_and_camera(b);
        AreaLight all = spot(.1f, 6);
        all.inner_angle = all.outer_angle = 0;
        if (which & 1) b.area_light(spot(.1f, 6), down);
        if (which & 2) b.area_light(spot(.1f, 6), up);
        if (which & 4) b.area_light(all, aside);
        return rendered(b.finish(), options_of(24));
    };
    const std::vector<float> together = lit(7), first = lit(1), second = lit(2), third = lit(4);
    float most = 0, difference = 0;
    for (std::size_t i = 0; i < together.size(); ++i) {
        most = std::max(most, together[i]);
        difference = std::max(difference, std::abs(together[i] - first[i] - second[i] - third[i]));
    }
    EXPECT_GT(*std::max_element(first.begin(), first.end()), 0);
    EXPECT_EQ(*std::max_element(second.begin(), second.end()), 0);
    EXPECT_LE(difference, .02f * most);
}

// Seen from within the cone and from outside it.
TEST(SpotsWithSize, AreSeenWithinTheirConeAlone)
{
    for (const double angle : {0.0, .2, .4, .58, .7, 3.1}) {
        SceneBuilder b;
        AreaLight light = spot(.25f, 6);
        light.hidden_from_camera = false;
        b.area_light(light);
        Camera camera;
        camera.transform =
            Transform::look_at({0, static_cast<float>(-4 * std::sin(angle)), static_cast<float>(-4 * std::cos(angle))},
                               {0, 0, 0}, {1, 0, 0});
        camera.vertical_fov = .001;
        b.camera(camera);
        const std::vector<float> image = rendered(b.finish(), options_of(2));
        // Blender's profile: the cosine times a smooth step between the cosines of the angles.
        const double cosine = std::cos(angle), outer = std::cos(static_cast<double>(k_outer)),
                     inner = std::cos(static_cast<double>(k_inner)),
                     t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
        const double truth = 6 * std::max(cosine, 0.0) * t * t * (3 - 2 * t);
        EXPECT_NEAR(static_cast<double>(image[0]), truth, .01) << angle;
    }
}

// Methods that know lights without size alone have a spot light of the same intensity.
TEST(SpotsWithSize, AreSpotLightsForOtherMethods)
{
    SceneBuilder b;
    b.area_light(spot(.25f, 6));
    const std::vector<scene::Light>& lights = api::scene_of(b.finish())->lights;
    ASSERT_EQ(lights.size(), 1u);
    EXPECT_EQ(lights[0].type, scene::LightType::spot);
    EXPECT_EQ(lights[0].outer_angle, k_outer);
    EXPECT_NEAR(lights[0].color.x, 6 * k_pi * .25 * .25, 1e-3);
}

TEST(SpotsWithSize, HaveAnglesInTheirOrder)
{
    SceneBuilder b;
    AreaLight wrong = spot(.1f, 1);
    wrong.inner_angle = 1;
    EXPECT_THROW(b.area_light(wrong), UsageError);
    wrong.inner_angle = 0, wrong.outer_angle = 2;
    EXPECT_THROW(b.area_light(wrong), UsageError);
}

}   // namespace
}   // namespace gnomon
