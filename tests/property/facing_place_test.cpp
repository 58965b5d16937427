// SPDX-License-Identifier: Apache-2.0
// Light from surfaces that face many directions, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

// A floor of pyramids between x = -4 and 0, whose sides slope by 45 degrees in four directions, under a sun above. A
// wall at the right, which no sun lights, sees a part of the sides alone.
Scene pyramids_before_a_wall()
{
    constexpr int k_pyramids = 100;
    constexpr float k_width = 4.0f / k_pyramids;
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    for (int z = 0; z < k_pyramids; ++z)
        for (int x = 0; x < k_pyramids; ++x) {
            const auto first = static_cast<std::uint32_t>(positions.size());
            const float left = -4 + static_cast<float>(x) * k_width, front = -2 + static_cast<float>(z) * k_width;
            positions.push_back({left, 0, front}), positions.push_back({left, 0, front + k_width});
            positions.push_back({left + k_width, 0, front + k_width}), positions.push_back({left + k_width, 0, front});
            positions.push_back({left + k_width / 2, k_width / 2, front + k_width / 2});
            for (std::uint32_t side = 0; side < 4; ++side)
                for (const std::uint32_t corner : {side, (side + 1) % 4, 4u}) indices.push_back(first + corner);
        }
    builder.instance(builder.mesh({.positions = positions, .indices = indices}), white);
    const std::vector<Vec3> wall{{1, 0, -2}, {1, 0, 2}, {1, 2, 2}, {1, 2, -2}};
    const std::vector<std::uint32_t> quad{0, 1, 2, 0, 2, 3};
    builder.instance(builder.mesh({.positions = wall, .indices = quad}), white);
    builder.light({.type = LightType::directional, .color = {3, 3, 3}},
                  Transform::rotation({1, 0, 0}, -std::numbers::pi / 2));
    Camera camera;
    camera.transform = Transform::look_at({-2, 1, 0}, {1, 1, 0});
    camera.vertical_fov = 0.6;
    builder.camera(camera);
    return builder.finish();
}

double mean_indirect(const Frame& frame)
{
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        double sum = 0;
        for (const float value : layer.copy()) sum += static_cast<double>(value);
        return sum / static_cast<double>(layer.copy().size());
    }
    throw std::runtime_error("no layer of indirect light");
}

// Most nodes of the light tree contain sides that face the wall and others that do not. Where a node's visibility was
// tested for a place on one of the latter, all of its light was lost: .74 of the light was left.
TEST(FacingPlace, AWallGetsTheLightOfSidesThatFaceIt)
{
    const Scene scene = pyramids_before_a_wall();
    for (const int bounces : {1, 2}) {
        RenderOptions options;
        options.size = {32, 32};
        options.layers = true;
        options.bounces = bounces;
        const double got = mean_indirect(Renderer(options).render(scene, 1));
        options.reference = ReferenceLightOptions{400, bounces, 0};
        const double truth = mean_indirect(Renderer(options).render(scene, 1));
        EXPECT_GT(truth, 0.05);
        EXPECT_NEAR(got / truth, 1, 0.06) << bounces << " bounces";
    }
}

}   // namespace
}   // namespace gnomon
