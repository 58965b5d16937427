// SPDX-License-Identifier: Apache-2.0
// Areas, a textured emitter, a point and a spot in one box: direct and bounced light against the path-traced reference,
// in absolute units.
#include <gtest/gtest.h>

#include <cmath>

#include "base/math.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

Scene box_of_lights()
{
    SceneBuilder b;
    const auto matte = [&](const Vec3& color) { return b.material({.base_color = color, .roughness = 1, .ior = 1}); };
    const MaterialId white = matte({0.7f, 0.7f, 0.7f}), red = matte({0.6f, 0.1f, 0.1f}),
                     green = matte({0.1f, 0.5f, 0.15f});
    const MeshId wall = b.mesh(test::square(1).mesh()), cube = b.mesh(test::cube(0.3f).mesh());
    const double quarter = k_pi / 2;
    b.instance(wall, white, Transform::rotation({1, 0, 0}, -quarter) * Transform::translation(0, 0, -1));   // floor
    b.instance(wall, white, Transform::rotation({1, 0, 0}, quarter) * Transform::translation(0, 0, -1));    // ceiling
    b.instance(wall, white, Transform::translation(0, 0, -1));
    b.instance(wall, red, Transform::rotation({0, 1, 0}, quarter) * Transform::translation(0, 0, -1));
    b.instance(wall, green, Transform::rotation({0, 1, 0}, -quarter) * Transform::translation(0, 0, -1));
    b.instance(cube, white, Transform::translation(-0.3, -0.7, -0.2) * Transform::rotation({0, 1, 0}, 0.4));
    b.instance(cube, white, Transform::translation(0.45, -0.75, 0.3) * Transform::rotation({0, 1, 0}, -0.3));

    b.area_light({.width = 0.5f, .height = 0.3f, .radiance = {6, 5, 4}},
                 Transform::translation(0.2, 0.99, -0.3) * Transform::rotation({1, 0, 0}, -quarter));
    b.area_light({.shape = AreaLightShape::disc, .width = 0.4f, .radiance = {1, 2, 4}},
                 Transform::translation(-0.98, 0.1, 0.2) * Transform::rotation({0, 1, 0}, -quarter));
    // A screen of 2 x 2 colours.
    const std::vector<std::uint8_t> colors{255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    Material screen{.base_color = {0, 0, 0}, .emissive = {3, 3, 3}};
    screen.emissive_texture.texture = b.texture({.width = 2, .height = 2, .channels = 3, .pixels = colors});
    const std::vector<Vec3> corners{{-0.25f, -0.25f, 0}, {0.25f, -0.25f, 0}, {0.25f, 0.25f, 0}, {-0.25f, 0.25f, 0}};
    const std::vector<Vec2> places{{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    const std::vector<std::uint32_t> order{0, 1, 2, 0, 2, 3};
    b.instance(b.mesh({.positions = corners, .indices = order, .texcoords = {places}}), b.material(screen),
               Transform::translation(0.4, 0.3, -0.98));
    b.light({.color = {0.15f, 0.15f, 0.2f}}, Transform::translation(-0.4, 0.4, 0.5));
    b.light({.type = LightType::spot, .color = {0.8f, 0.7f, 0.3f}, .inner_angle = 0.2f, .outer_angle = 0.5f},
            Transform::look_at({0.7f, 0.8f, 0.7f}, {0, -1, 0}));
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 3.2f}, {0, 0, 0});
    camera.vertical_fov = 0.75;
    b.camera(camera);
    return b.finish();
}

TEST(MixedLights, BoxAgreesWithTheReference)
{
    const Scene scene = box_of_lights();
    RenderOptions options;
    options.size = {64, 64};
    options.layers = true;
    const Frame frame = Renderer(options).render(scene, 1);
    options.reference = ReferenceLightOptions{.spp = 1024};
    const Frame truth = Renderer(options).render(scene, 1);
    const auto a = frame.layers.front().values(), b = truth.layers.front().values();
    ASSERT_EQ(a.size(), b.size());
    double square = 0, sum = 0, got = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        // What shines shows itself, and would decide the sum.
        if (b[i] >= 0.9f) continue;
        square += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
        sum += static_cast<double>(b[i]), got += static_cast<double>(a[i]);
    }
    const auto count = static_cast<double>(a.size());
    EXPECT_LE(std::sqrt(square / count) / (sum / count), 0.08);
    EXPECT_NEAR(got / sum, 1, 0.03);
}

}   // namespace
}   // namespace gnomon
