// SPDX-License-Identifier: Apache-2.0
// The bounced light of a scene of small shapes (tiles with joints, capitals, foliage), whose cache points stand for
// less than lies between them, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

struct Part {
    int x0 = 0, y0 = 0, x1 = 160, y1 = 128;
};

RenderOptions options_of(int bounces)
{
    RenderOptions options;
    options.size = {160, 128};
    options.layers = true;
    options.bounces = bounces;
    return options;
}

// Frame 30 of the courtyard.
// @param lights  0: its sky alone
double sum_of_indirect(const RenderOptions& options, int lights, const Part& part = {})
{
    const Frame frame = Renderer(options).render(load("builtin:kinetic").with_lights(lights), 30);
    double sum = 0;
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        const std::vector<float> values = layer.copy();
        for (int y = part.y0; y < part.y1; ++y)
            for (int c = 3 * part.x0; c < 3 * part.x1; ++c)
                sum += static_cast<double>(values[static_cast<std::size_t>(480 * y + c)]);
    }
    return sum;
}

RenderOptions reference_of(RenderOptions options, int samples)
{
    options.reference = ReferenceLightOptions{samples, 1, 0};
    return options;
}

// Without near light of parts, points that geometry covers, and finer parts where one is hidden: .88. Without finer
// parts where one is lit unlike its surroundings: .965.
TEST(SmallShapes, KeepTheirBouncedLight)
{
    const RenderOptions options = options_of(1);
    const double got = sum_of_indirect(options, 1);
    const double truth = sum_of_indirect(reference_of(options, 24), 1);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.98 * truth);
    EXPECT_LT(got, 1.03 * truth);
}

// Most of that light is the sky's. Of the sun's own, .86 without near light of lattice points far apart, and with wide
// patches that get no light from themselves.
TEST(SmallShapes, KeepTheSunsLight)
{
    const RenderOptions options = options_of(1), reference = reference_of(options, 24);
    const double got = sum_of_indirect(options, 1) - sum_of_indirect(options, 0);
    const double truth = sum_of_indirect(reference, 1) - sum_of_indirect(reference, 0);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.873 * truth);
    EXPECT_LT(got, 1.03 * truth);
}

// The red plate of the mobile: .90 with cuts for moving objects as coarse as they were before light bounced twice.
TEST(SmallShapes, MovingObjectsReceiveWhatBouncesTwice)
{
    const Part plate{33, 24, 42, 40};
    const RenderOptions options = options_of(2);
    const double got = sum_of_indirect(options, 1, plate);
    const double truth = sum_of_indirect(reference_of(options, 96), 1, plate);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.92 * truth);
    EXPECT_LT(got, 1.05 * truth);
}

// A ledge 4 m long and 2 cm high of two triangles. Left of a partition the floor before it is lit, right of it not.
Scene ledge()
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const std::vector<std::uint32_t> triangles{0, 1, 2, 0, 2, 3};
    const auto add = [&](const Vec3& corner, const Vec3& a, const Vec3& b) {
        std::vector<Vec3> p;
        for (const auto& [s, t] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}})
            p.push_back({corner.x + s * a.x + t * b.x, corner.y + s * a.y + t * b.y, corner.z + s * a.z + t * b.z});
        builder.instance(builder.mesh({.positions = p, .indices = triangles}), white);
    };
    add({-2, 0.5f, 0}, {4, 0, 0}, {0, 0.02f, 0});
    add({-2, 0, 2}, {4, 0, 0}, {0, 0, -2});
    add({0.3f, 0, 0.02f}, {0, 0, 2}, {0, 2, 0}), add({0.29f, 0, 0.02f}, {0, 2, 0}, {0, 0, 2});
    builder.light({.type = LightType::spot, .color = {60, 60, 60}, .outer_angle = 0.5f},
                  Transform::look_at({-1, 2, 0.6f}, {-0.5f, 0, 0.6f}));
    Camera camera;
    camera.transform = Transform::look_at({0, 0.51f, 4}, {0, 0.51f, 0});
    camera.vertical_fov = 0.08;
    builder.camera(camera);
    return builder.finish();
}

// The middles of the parts of a long triangle, or of one that represents it, lie far from what is seen: nRMSE was .25.
TEST(SmallShapes, ALongLedgeIsLitWhereItIsSeen)
{
    RenderOptions options = options_of(1);
    options.size = {256, 32};
    options.samples = 1;
    const auto image_of = [](const RenderOptions& with) {
        const Frame frame = Renderer(with).render(ledge(), 1);
        for (const Layer& layer : frame.layers)
            if (layer.name == "indirect") return layer.copy();
        return std::vector<float>();
    };
    const std::vector<float> got = image_of(options), truth = image_of(reference_of(options, 256));
    // Take the two rows of the ledge, and there means of four pixels.
    double square = 0, sum = 0;
    for (int x = 0; x < 256; x += 4) {
        double ours = 0, theirs = 0;
        for (int i = 0; i < 8; ++i) {
            const auto at = static_cast<std::size_t>(3 * (256 * (15 + i / 4) + x + i % 4));
            ours += static_cast<double>(got.at(at)), theirs += static_cast<double>(truth.at(at));
        }
        square += (ours - theirs) * (ours - theirs), sum += theirs;
    }
    const double error = std::sqrt(square / 64) / (sum / 64);
    RecordProperty("nrmse", std::to_string(error));
    EXPECT_LT(error, 0.06);
}

// A step 30 cm high on a ground of 160 m x 160 m: the sun shines on the ground before it, and not on its riser. Of the
// light map's texels those of the sun are 60 cm wide, those of candles in boxes elsewhere one or two centimetres.
Scene step_in_the_sun(int candles)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const auto box = [&](const Vec3& from, const Vec3& to) {
        std::vector<Vec3> p;
        const Vec3 ends[2] = {from, to};
        // The corners' numbers have a bit for each axis.
        for (int i = 0; i < 8; ++i) p.push_back({ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z});
        const std::vector<std::uint32_t> triangles{0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                                   2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
        builder.instance(builder.mesh({.positions = p, .indices = triangles}), white);
    };
    box({-80, -1, -80}, {80, 0, 80});
    box({-3, 0, -2}, {3, 0.3f, 0});
    for (int i = 0; i < candles; ++i) {
        const float x = 20.0f + 2 * static_cast<float>(i);
        box({x - 0.5f, 0, 19.5f}, {x + 0.5f, 1, 20.5f});
        builder.light({.type = LightType::point, .color = {0.01f, 0.01f, 0.01f}}, Transform::translation(x, 0.5, 20));
    }
    // The riser faces +z; the sun stands behind the step, so high that its shadow is 3 cm long.
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, Transform::look_at({0, 10, -1}, {0, 0, 0}));
    Camera camera;
    camera.transform = Transform::look_at({0, 0.5f, 3}, {0, 0.15f, 0});
    camera.vertical_fov = 0.06;
    builder.camera(camera);
    return builder.finish();
}

// The candles take texels of the sun's light map, which are wider then. Where near light reached as far as one texel is
// wide, that changed the riser's light by 2.2 %.
TEST(SmallShapes, RisersAreLitByTheGroundBeforeThem)
{
    RenderOptions options = options_of(2);
    options.size = {48, 24};
    options.samples = 1;
    const auto sum_of = [](const RenderOptions& with, int candles) {
        const Frame frame = Renderer(with).render(step_in_the_sun(candles), 1);
        double sum = 0;
        for (const Layer& layer : frame.layers)
            if (layer.name == "indirect")
                for (const float value : layer.copy()) sum += static_cast<double>(value);
        return sum;
    };
    RenderOptions reference = options;
    reference.reference = ReferenceLightOptions{256, 2, 0};
    const double alone = sum_of(options, 0), got = sum_of(options, 6), truth = sum_of(reference, 6);
    RecordProperty("energy", std::to_string(got / truth));
    RecordProperty("candles", std::to_string(got / alone));
    EXPECT_GT(got, 0.97 * truth);
    EXPECT_LT(got, 1.03 * truth);
    EXPECT_NEAR(got, alone, 0.004 * alone);
}

}   // namespace
}   // namespace gnomon
