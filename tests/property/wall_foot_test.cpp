// SPDX-License-Identifier: Apache-2.0
// Bounced light of a wall above a lit floor, from its foot up, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr int k_width = 160, k_height = 120;
constexpr int k_left = 45, k_right = 115;   // columns of the wall
constexpr int k_top = 42, k_foot = 108;     // rows of it, from half a radius of the near field above the other edge
constexpr int k_rows = 6;                   // of a band

enum class Light : std::uint8_t { sun, even_image, studio };

// Radiance .3 from everywhere, and a bright square in front of the camera's shoulder.
std::vector<float> studio_image(int width, int height)
{
    std::vector<float> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 0.3f);
    for (int y = height / 5; y < 2 * height / 5; ++y)
        for (int x = width / 16; x < 3 * width / 16; ++x)
            std::fill_n(pixels.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * width + x), 3, 8.0f);
    return pixels;
}

// A box on a square floor, under an environment image, or a sun that comes over the camera's shoulder.
Scene box_on_floor(Light light)
{
    SceneBuilder builder;
    const MaterialId wall = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const MaterialId floor = builder.material({.base_color = {0.45f, 0.45f, 0.45f}, .roughness = 1, .ior = 1});
    const std::vector<std::uint32_t> quad{0, 1, 2, 0, 2, 3};
    const auto add = [&](const std::vector<Vec3>& corners, MaterialId material) {
        builder.instance(builder.mesh({.positions = corners, .indices = quad}), material);
    };
    constexpr float h = 0.5f;
    add({{-h, 0, h}, {h, 0, h}, {h, 1, h}, {-h, 1, h}}, wall);
    add({{h, 0, -h}, {-h, 0, -h}, {-h, 1, -h}, {h, 1, -h}}, wall);
    add({{h, 0, h}, {h, 0, -h}, {h, 1, -h}, {h, 1, h}}, wall);
    add({{-h, 0, -h}, {-h, 0, h}, {-h, 1, h}, {-h, 1, -h}}, wall);
    add({{-h, 1, h}, {h, 1, h}, {h, 1, -h}, {-h, 1, -h}}, wall);
    add({{-10, 0, -10}, {-10, 0, 10}, {10, 0, 10}, {10, 0, -10}}, floor);
    if (light == Light::sun)
        builder.light({.type = LightType::directional, .color = {5, 5, 5}}, Transform::rotation({1, 0, 0}, -1.1));
    const std::vector<float> image = light == Light::studio ? studio_image(128, 64) : std::vector<float>(2 * 3, 1.0f);
    if (light == Light::even_image) builder.environment({.width = 2, .height = 1, .pixels = image});
    if (light == Light::studio) builder.environment({.width = 128, .height = 64, .pixels = image});
    Camera camera;
    camera.transform = Transform::look_at({0, 0.6, 2.6}, {0, 0.6, 0});
    camera.vertical_fov = 0.7;
    builder.camera(camera);
    return builder.finish();
}

// The mean of bounced light on the wall, by band.
std::vector<double> bands(const Frame& frame)
{
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        const std::vector<float> values = layer.copy();
        std::vector<double> result;
        for (int top = k_top; top < k_foot; top += k_rows) {
            double sum = 0;
            for (int y = top; y < top + k_rows; ++y)
                for (int x = 3 * (y * k_width + k_left); x < 3 * (y * k_width + k_right); ++x)
                    sum += static_cast<double>(values[static_cast<std::size_t>(x)]);
            result.push_back(sum / (3.0 * k_rows * (k_right - k_left)));
        }
        return result;
    }
    throw std::runtime_error("no layer of indirect light");
}

// The wall's bounced light over that of the reference, by band.
std::vector<double> ratios(Light light)
{
    const Scene scene = box_on_floor(light);
    RenderOptions options;
    options.size = {k_width, k_height};
    options.layers = true, options.samples = 1, options.bounces = 1;
    std::vector<double> result = bands(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
    const std::vector<double> truth = bands(Renderer(options).render(scene, 1));
    for (std::size_t band = 0; band < truth.size(); ++band) {
        EXPECT_GT(truth[band], 0.05);
        result[band] /= truth[band];
    }
    return result;
}

// Lattice points are about as far apart as the near field reaches. When their light left out what is near, it was that
// of no place between them: bands of the wall had .75 to 1.19 of their light.
TEST(WallFoot, HasTheLightOfTheFloor)
{
    for (const double ratio : ratios(Light::sun)) EXPECT_NEAR(ratio, 1, 0.03);
}

// Near its foot, the light that a wall gets from an image by way of the floor changes within a spacing of lattice
// points.
void expect_even_above_foot(const std::vector<double>& ratio)
{
    constexpr std::size_t k_above = 7;   // bands
    for (std::size_t band = 0; band < ratio.size(); ++band)
        EXPECT_NEAR(ratio[band], 1, band < k_above ? 0.02 : 0.125) << "band " << band;
}

// What hides an image and what bounced light comes from are two estimates of the same share of the hemisphere. When
// the light was held to the lesser one, walls under an image had .96 to .98 of it.
TEST(WallFoot, HasTheLightThatAFloorGetsFromAnImage)
{
    expect_even_above_foot(ratios(Light::even_image));
}

// Few of a patch's rays meet a small bright part of an image.
TEST(WallFoot, HasTheLightThatAFloorGetsFromASmallBrightSquare)
{
    expect_even_above_foot(ratios(Light::studio));
}

}   // namespace
}   // namespace gnomon
