// SPDX-License-Identifier: Apache-2.0
// Bounced light at the foot of a wall, where patches are wider than they are far away, against the path-traced
// reference in absolute units.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

MeshId add_sheet(SceneBuilder& builder, const std::vector<std::uint32_t>& triangles)
{
    const std::vector<Vec3> square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    return builder.mesh({.positions = square, .indices = triangles});
}

const std::vector<std::uint32_t> k_up{0, 2, 1, 0, 3, 2}, k_down{0, 1, 2, 0, 2, 3};

Transform upright()
{
    return Transform::rotation({1, 0, 0}, 1.5707963267948966);
}

void add_camera(SceneBuilder& builder, const Vec3& eye, const Vec3& target, double field_of_view)
{
    Camera camera;
    camera.transform = Transform::look_at(eye, target);
    camera.vertical_fov = field_of_view;
    builder.camera(camera);
}

// Completes a scene by an even sky and a camera.
Scene finish(SceneBuilder& builder, const Vec3& eye, const Vec3& target, double field_of_view)
{
    const std::vector<float> sky(2 * 3, 1.0f);
    builder.environment({.width = 2, .height = 1, .pixels = sky});
    add_camera(builder, eye, target, field_of_view);
    return builder.finish();
}

// A white block on a white floor, seen closely where they meet, under an even sky or under a light that shines straight
// down.
Scene foot_of_a_block(bool sky = true)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const MeshId sheet = add_sheet(builder, k_up);
    builder.instance(sheet, white, Transform::scaling(4, 1, 4));
    builder.instance(sheet, white, Transform::translation(0, 0.5, 0) * upright() * Transform::scaling(2, 1, 1));
    builder.instance(sheet, white, Transform::translation(0, 1, -0.5) * Transform::scaling(2, 1, 1));
    const Vec3 eye(0.35f, 0.35f, 1.2f), target(0.3f, 0, 0);
    if (sky) return finish(builder, eye, target, 0.25);
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, Transform::rotation({1, 0, 0}, -1.5707963));
    add_camera(builder, eye, target, 0.25);
    return builder.finish();
}

std::vector<float> indirect_of(const Frame& frame)
{
    for (const Layer& layer : frame.layers)
        if (layer.name == "indirect") return layer.copy();
    throw std::runtime_error("no layer of indirect light");
}

// Means of blocks of 4 x 4 pixels of one colour.
std::vector<double> blocks(const std::vector<float>& image, int size)
{
    std::vector<double> means;
    for (int y = 0; y < size; y += 4)
        for (int x = 0; x < size; x += 4) {
            double sum = 0;
            for (int i = 0; i < 16; ++i)
                sum += static_cast<double>(image[static_cast<std::size_t>(3 * ((y + i / 4) * size + x + i % 4))]);
            means.push_back(sum / 16);
        }
    return means;
}

TEST(NearPatches, LightAtTheFootOfAWallIsThatOfTheReference)
{
    constexpr int k_size = 48;
    const Scene scene = foot_of_a_block();
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    options.bounces = 2;
    const std::vector<float> image = indirect_of(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{1000, 2, 0};
    const std::vector<double> truth = blocks(indirect_of(Renderer(options).render(scene, 1)), k_size),
                              got = blocks(image, k_size);
    double square = 0, sum = 0, sum_truth = 0, most = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double error = got[i] - truth[i];
        square += error * error, sum += got[i], sum_truth += truth[i];
        most = std::max(most, std::abs(error) / truth[i]);
    }
    const double mean = sum_truth / static_cast<double>(truth.size());
    RecordProperty("nrmse", std::to_string(std::sqrt(square / static_cast<double>(truth.size())) / mean));
    RecordProperty("most", std::to_string(most));
    RecordProperty("energy", std::to_string(sum / sum_truth));
    EXPECT_GT(mean, 0.05);
    // Without near patches: .033, and .085 at most.
    EXPECT_LE(std::sqrt(square / static_cast<double>(truth.size())) / mean, 0.027);
    EXPECT_LE(most, 0.065);
    EXPECT_NEAR(sum / sum_truth, 1, 0.03);
    // No row of pixels is darker than both its neighbours.
    for (int x = 0; x < k_size; ++x)
        for (int y = 1; y + 1 < k_size; ++y) {
            const auto at = [&](int row) { return image[static_cast<std::size_t>(3 * (row * k_size + x))]; };
            EXPECT_GT(at(y), 0.85f * std::min(at(y - 1), at(y + 1))) << x << ' ' << y;
        }
}

// Before a floor that is far brighter than all else, light at the foot of a wall comes from close by, and goes on
// beside the pixel as well. It does not go up and down along the foot, nor is it that from farther up.
TEST(NearPatches, TheFootOfAWallBeforeABrightFloorIsEven)
{
    constexpr int k_size = 64;
    const Scene scene = foot_of_a_block(false);
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    const std::vector<float> image = indirect_of(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{512, 32, 0};
    const std::vector<double> truth = blocks(indirect_of(Renderer(options).render(scene, 1)), k_size),
                              got = blocks(image, k_size);
    double square = 0, sum = 0, sum_truth = 0, most = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double error = got[i] - truth[i];
        square += error * error, sum += got[i], sum_truth += truth[i];
        most = std::max(most, std::abs(error) / truth[i]);
    }
    const double mean = sum_truth / static_cast<double>(truth.size());
    const double nrmse = std::sqrt(square / static_cast<double>(truth.size())) / mean;
    float uneven = 0;
    for (int y = 0; y < k_size; ++y)
        for (int x = 1; x + 1 < k_size; ++x) {
            const auto at = [&](int column) { return image[static_cast<std::size_t>(3 * (y * k_size + column))]; };
            uneven = std::max(uneven, std::abs(at(x) / (0.5f * (at(x - 1) + at(x + 1))) - 1));
        }
    RecordProperty("nrmse", std::to_string(nrmse));
    RecordProperty("most", std::to_string(most));
    RecordProperty("energy", std::to_string(sum / sum_truth));
    RecordProperty("uneven", std::to_string(uneven));
    EXPECT_GT(mean, 0.1);
    // .128, .22 and .974 where near light is left out of cache points that are farther apart than it reaches.
    EXPECT_LE(nrmse, 0.02);
    EXPECT_LE(most, 0.1);
    EXPECT_NEAR(sum / sum_truth, 1, 0.01);
    // .032 where the light of points that lie close to the foot is left out of all levels.
    EXPECT_LE(uneven, 0.0305);
}

// A luminous plate that lies almost on a floor, before a wall, under an even sky. Light bounces between the plate and
// the floor, and leaves the gap near its mouth alone.
Scene plate_above_a_floor(float x)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    const MaterialId luminous =
        builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .emissive = {500, 500, 500}, .ior = 1});
    const MeshId sheet = add_sheet(builder, k_up);
    const MeshId ceiling = add_sheet(builder, k_down);
    builder.instance(sheet, white, Transform::scaling(4, 1, 4));
    builder.instance(sheet, white, Transform::translation(0, 1, -1) * upright() * Transform::scaling(4, 1, 2));
    builder.instance(ceiling, luminous, Transform::translation(x, 0.002, 0) * Transform::scaling(0.6, 1, 0.6));
    builder.instance(sheet, white, Transform::translation(x, 0.003, 0) * Transform::scaling(0.6, 1, 0.6));
    return finish(builder, {0.01f, 3, 0.5f}, {0, 0, 0}, 0.6);
}

TEST(NearPatches, LightAtTheMouthOfAGapStaysThere)
{
    constexpr int k_size = 64;
    constexpr float k_width = 1.86f;   // of what the camera sees
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    for (const float x : {0.0f, 0.01f, 0.02f, 0.03f, 0.05f, 0.08f}) {
        const std::vector<float> image = indirect_of(Renderer(options).render(plate_above_a_floor(x), 1));
        // Nothing but the pixels at the plate's rim is brighter or darker than the floor around.
        for (int y = 8; y < 56; ++y) {
            std::vector<float> row;
            for (int column = 0; column < k_size; ++column)
                if (const float u = (static_cast<float>(column) + 0.5f) / k_size - 0.5f;
                    std::abs(u * k_width - x) > 0.33f)
                    row.push_back(image[static_cast<std::size_t>(3 * (y * k_size + column))]);
            std::ranges::sort(row);
            const float median = row[row.size() / 2];
            EXPECT_LT(row.back(), 1.6f * median) << x << ' ' << y;   // 36 where such light is interpolated
            EXPECT_GT(row.front(), 0.6f * median) << x << ' ' << y;
        }
    }
}

// Black paving with open joints below a white ceiling that a point light shines at, seen from above. What arrives on
// the paving comes from the ceiling.
Scene paving(float width, float depth)
{
    SceneBuilder builder;
    const MaterialId black = builder.material({.base_color = {0.02f, 0.02f, 0.02f}, .roughness = 1, .ior = 1});
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) corners.push_back({i & 1 ? 0.5f : -0.5f, i & 2 ? 0.0f : -1.0f, i & 4 ? 0.5f : -0.5f});
    // The top and four sides.
    const std::vector<std::uint32_t> faces{2, 6, 3, 3, 6, 7, 0, 2, 1, 1, 2, 3, 4, 5, 6,
                                           5, 7, 6, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const MeshId stone = builder.mesh({.positions = corners, .indices = faces});
    builder.instance(add_sheet(builder, k_up), black,
                     Transform::translation(0, -depth, 0) * Transform::scaling(4, 1, 4));
    builder.instance(add_sheet(builder, k_down), white,
                     Transform::translation(0, 2.5, 0) * Transform::scaling(6, 1, 6));
    for (int i = -4; i < 4; ++i)
        builder.instance(stone, black,
                         Transform::translation(0, 0, 0.1 * i + 0.05) * Transform::scaling(2, depth, 0.1f - width));
    builder.light({.color = {10, 10, 10}}, Transform::translation(0, 2, 1.6));
    Camera camera;
    camera.transform = Transform::look_at({0, 1, 0.001f}, {0, 0, 0});
    camera.vertical_fov = 0.49;
    builder.camera(camera);
    return builder.finish();
}

TEST(NearPatches, JointsHaveNotTheLightOfThePavingAbove)
{
    constexpr int k_size = 96;
    const Scene scene = paving(0.02f, 0.02f);
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    options.bounces = 1;
    const std::vector<float> image = indirect_of(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{64, 1, 0};
    const std::vector<float> truth = indirect_of(Renderer(options).render(scene, 1));
    // Mean of the rows in the middle of joints and of stones.
    const auto mean = [](const std::vector<float>& of, double centre) {
        double sum = 0;
        int count = 0;
        for (int y = 0; y < k_size; ++y) {
            const double z = ((y + 0.5) / k_size - 0.5) * 0.5, from = z - 0.1 * std::round((z - centre) / 0.1) - centre;
            if (std::abs(from) > 0.003) continue;
            for (int x = 0; x < k_size; ++x)
                sum += static_cast<double>(of[static_cast<std::size_t>(3 * (y * k_size + x))]);
            count += k_size;
        }
        return sum / count;
    };
    RecordProperty("joints", std::to_string(mean(image, 0) / mean(truth, 0)));
    RecordProperty("joints_to_stones", std::to_string(mean(truth, 0) / mean(truth, 0.05)));
    EXPECT_NEAR(mean(image, 0.05) / mean(truth, 0.05), 1, 0.05);
    EXPECT_LT(mean(truth, 0), 0.6 * mean(truth, 0.05));
    EXPECT_NEAR(mean(image, 0) / mean(truth, 0), 1, 0.15);
}

}   // namespace
}   // namespace gnomon
