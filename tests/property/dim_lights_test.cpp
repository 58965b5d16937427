// SPDX-License-Identifier: Apache-2.0
// Lights with size beside an environment image: those that bring little are seen by few rays, without visible steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/math.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"

namespace gnomon {
namespace {

// A floor below a small area light, or a black square instead of it, and a cube between them.
Scene lit_floor(float light, float sky)
{
    SceneBuilder b;
    const MaterialId white = b.material({.base_color = {0.7f, 0.7f, 0.7f}, .roughness = 1, .ior = 1});
    b.instance(b.mesh(test::square(2).mesh()), white, Transform::rotation({1, 0, 0}, -k_pi / 2));
    b.instance(b.mesh(test::cube(0.4f).mesh()), white, Transform::translation(0.1, 0.5, 0));
    const Transform above = Transform::translation(0, 1.5, 0) * Transform::rotation({1, 0, 0}, -k_pi / 2);
    if (light > 0)
        b.area_light({.width = 0.6f, .height = 0.6f, .radiance = {light, light, light}}, above);
    else
        b.instance(b.mesh(test::square(0.3f).mesh()), b.material({.base_color = {0, 0, 0}, .ior = 1}), above);
    if (sky > 0) b.environment({.width = 2, .height = 1, .pixels = std::vector<float>(6, sky)});
    Camera camera;
    camera.transform = Transform::look_at({0, 1.2, 2.5}, {0, 0, 0});
    camera.vertical_fov = 0.9;
    b.camera(camera);
    return b.finish();
}

struct Rendered {
    std::vector<float> values;
    std::uint64_t rays = 0;
};

Rendered render_of(const Scene& scene)
{
    RenderOptions options;
    options.size = {96, 96};
    options.indirect = Indirect::off;
    options.max_depth = 0;
    options.threads = 1;
    options.background = BackgroundKind::color;
    const Frame frame = Renderer(options).render(scene, 1);
    const auto values = frame.layers.front().values();
    return {{values.begin(), values.end()}, frame.counters.shadow.rays};
}

// The frame of both kinds of light against the sum of two frames of one kind each, in which nothing is dim.
TEST(DimLights, LeaveNoStepsBesideAnImage)
{
    const Rendered sky = render_of(lit_floor(0, 1));
    bool differs = false;
    for (const float light : {0.003f, 0.03f, 0.3f, 3.0f}) {
        const Rendered both = render_of(lit_floor(light, 1)), alone = render_of(lit_floor(light, 0));
        ASSERT_EQ(both.values.size(), alone.values.size());
        double square = 0;
        for (std::size_t i = 0; i < both.values.size(); ++i) {
            // The emitter itself, seen before the image.
            if (sky.values[i] == 0 || alone.values[i] >= light) continue;
            const float error = both.values[i] - alone.values[i] - sky.values[i];
            EXPECT_LE(std::abs(error), 0.012f * sky.values[i] + 1e-5f) << light << " " << i;
            square += std::pow(static_cast<double>(error), 2);
            differs = differs || std::abs(error) > 1e-4f;
        }
        EXPECT_LE(std::sqrt(square / static_cast<double>(both.values.size())), 0.0015) << light;
    }
    EXPECT_TRUE(differs);   // few rays were cast
}

// The dimmer the light, the fewer rays.
TEST(DimLights, NeedFewRays)
{
    const std::uint64_t sky = render_of(lit_floor(0, 1)).rays;
    const std::uint64_t dim = render_of(lit_floor(0.0003f, 1)).rays - sky;
    const std::uint64_t more = render_of(lit_floor(0.1f, 1)).rays - sky;
    EXPECT_GT(dim, 0u);
    EXPECT_LT(dim, 96u * 96u + 1);
    EXPECT_GT(more, 2 * dim);
}

TEST(DimLights, SameFrameFromAKeptRendererAndForAnyThreadCount)
{
    const Scene scene = lit_floor(0.1f, 1);
    const Rendered first = render_of(scene);
    RenderOptions options;
    options.size = {96, 96};
    options.indirect = Indirect::off;
    options.max_depth = 0;
    options.background = BackgroundKind::color;
    options.threads = 3;
    options.keep_image = false;
    Renderer renderer(options);
    for (int k = 0; k < 3; ++k) {
        const Frame frame = renderer.render(scene, 1);
        EXPECT_TRUE(std::ranges::equal(frame.layers.front().values(), first.values)) << k;
    }
}

}   // namespace
}   // namespace gnomon
