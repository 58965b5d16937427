// SPDX-License-Identifier: Apache-2.0
// Bounced light from surfaces that light grazes, where a leaf of the light tree is wider than its receiver is far away,
// against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

MeshId add_sheet(SceneBuilder& builder)
{
    const std::vector<Vec3> square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    return builder.mesh({.positions = square, .indices = std::vector<std::uint32_t>{0, 2, 1, 0, 3, 2}});
}

// A light half a metre below a ceiling, and the uppermost half metre of a wall some metres away. There, a leaf covers
// .03 x .2 m of the ceiling.
Scene wall_below_a_ceiling(float away)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const MeshId sheet = add_sheet(builder);
    constexpr double k_turn = 1.5707963267948966;
    builder.instance(sheet, white, Transform::translation(0, 2.4, 0) * Transform::scaling(14, 1, 14));
    builder.instance(sheet, white, Transform::scaling(14, 1, 14));
    builder.instance(sheet, white,
                     Transform::translation(0, 1.2, -away) * Transform::rotation({1, 0, 0}, k_turn) *
                         Transform::scaling(14, 1, 2.4));
    builder.light({.type = LightType::point, .color = {10, 10, 10}}, Transform::translation(0, 1.9, 0));
    Camera camera;
    camera.transform = Transform::look_at({0, 2.15f, 1 - away}, {0, 2.15f, -away});
    camera.vertical_fov = 2 * std::atan(0.25);
    builder.camera(camera);
    return builder.finish();
}

double sum_of_indirect(const Scene& scene, RenderOptions options)
{
    options.size = {32, 32};
    options.layers = true;
    const Frame frame = Renderer(options).render(scene, 1);
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        double sum = 0;
        for (const float value : layer.copy()) sum += static_cast<double>(value);
        return sum;
    }
    throw std::runtime_error("no layer of indirect light");
}

TEST(GrazingLight, OfACeilingLightsTheWallBelowItAsInTheReference)
{
    double square = 0;
    int walls = 0;
    for (float away = 3.4f; away < 4.5f; away += 0.1f, ++walls) {
        const Scene scene = wall_below_a_ceiling(away);
        RenderOptions options;
        options.bounces = 1;
        const double got = sum_of_indirect(scene, options);
        options.reference = ReferenceLightOptions{512, 1, 0};
        const double ratio = got / sum_of_indirect(scene, options);
        RecordProperty("ratio " + std::to_string(away), std::to_string(ratio));
        square += (ratio - 1) * (ratio - 1);
    }
    // Where short rays end at the radius of the near field: .027, and .045 at most.
    EXPECT_LE(std::sqrt(square / walls), 0.016);
}

}   // namespace
}   // namespace gnomon
