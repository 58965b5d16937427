// SPDX-License-Identifier: Apache-2.0
// Bounced light of a wall above a lit floor, from its foot up, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr int k_width = 160, k_height = 120;
constexpr int k_left = 45, k_right = 115;   // columns of the wall
constexpr int k_top = 42, k_foot = 108;     // rows of it, from half a radius of the near field above the other edge
constexpr int k_rows = 6;                   // of a band

// A box on a square floor, under a sun that comes over the camera's shoulder.
Scene box_on_floor()
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
    builder.light({.type = LightType::directional, .color = {5, 5, 5}}, Transform::rotation({1, 0, 0}, -1.1));
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

// Lattice points are about as far apart as the near field reaches. When their light left out what is near, it was that
// of no place between them: bands of the wall had .75 to 1.19 of their light.
TEST(WallFoot, HasTheLightOfTheFloor)
{
    const Scene scene = box_on_floor();
    RenderOptions options;
    options.size = {k_width, k_height};
    options.layers = true, options.samples = 1, options.bounces = 1;
    const std::vector<double> got = bands(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
    const std::vector<double> truth = bands(Renderer(options).render(scene, 1));
    for (std::size_t band = 0; band < truth.size(); ++band) {
        EXPECT_GT(truth[band], 0.05);
        EXPECT_NEAR(got[band] / truth[band], 1, 0.03) << "band " << band;
    }
}

}   // namespace
}   // namespace gnomon
