// SPDX-License-Identifier: Apache-2.0
// Mirrors under an environment image, in which the image's visibility is interpolated between places: they show what a
// camera behind them would see, and have the same bytes however a frame is made.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr int k_size = 96;

void add_quad(std::vector<Vec3>& positions, std::vector<std::uint32_t>& indices, const std::array<Vec3, 4>& corner)
{
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), corner.begin(), corner.end());
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + i);
}

// A box on a floor, beside a mirror in the plane x = 2 that faces it, under a sky that is brighter on one side.
Scene box_before_mirror()
{
    SceneBuilder builder;
    const MaterialId grey = builder.material({.base_color = {0.5f, 0.5f, 0.5f}, .roughness = 1, .ior = 1});
    const MaterialId mirror = builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0});
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    add_quad(positions, indices, {Vec3{-3, 0, -3}, {-3, 0, 3}, {2, 0, 3}, {2, 0, -3}});
    const float l = -0.6f, r = 0.2f, t = 0.7f, n = -0.5f, f = 0.4f;
    add_quad(positions, indices, {Vec3{l, t, n}, {l, t, f}, {r, t, f}, {r, t, n}});
    add_quad(positions, indices, {Vec3{r, 0, n}, {r, t, n}, {r, t, f}, {r, 0, f}});
    add_quad(positions, indices, {Vec3{l, 0, n}, {l, 0, f}, {l, t, f}, {l, t, n}});
    add_quad(positions, indices, {Vec3{l, 0, f}, {r, 0, f}, {r, t, f}, {l, t, f}});
    add_quad(positions, indices, {Vec3{l, 0, n}, {l, t, n}, {r, t, n}, {r, 0, n}});
    builder.instance(builder.mesh({.positions = positions, .indices = indices}), grey, Transform{});
    positions.clear(), indices.clear();
    add_quad(positions, indices, {Vec3{2, 0, -2}, {2, 0, 2}, {2, 3, 2}, {2, 3, -2}});
    builder.instance(builder.mesh({.positions = positions, .indices = indices}), mirror, Transform{});
    std::vector<float> sky;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x)
            for (int c = 0; c < 3; ++c) sky.push_back(0.4f + (x < 6 ? 1.2f : 0.0f) + 0.05f * static_cast<float>(8 - y));
    builder.environment({.width = 16, .height = 8, .pixels = sky});
    return builder.finish();
}

// @param behind  the camera's mirror image, behind the mirror, whose back it does not see
FrameInput seen(bool behind)
{
    Camera camera;
    camera.transform =
        behind ? Transform::look_at({2.8f, 1.3f, 0}, {1, 0.4f, 0}) : Transform::look_at({1.2f, 1.3f, 0}, {3, 0.4f, 0});
    camera.orthographic_height = 1.6;
    FrameInput input;
    input.camera = camera;
    return input;
}

RenderOptions options()
{
    RenderOptions result;
    result.size = {k_size, k_size};
    result.indirect = Indirect::off;
    result.keep_image = false;
    return result;
}

std::vector<float> colours(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

TEST(PlaceLattice, AMirrorShowsWhatACameraBehindItSees)
{
    const Scene scene = box_before_mirror();
    const std::vector<float> mirrored = colours(Renderer(options()).render(scene, seen(false))),
                             direct = colours(Renderer(options()).render(scene, seen(true)));
    double squares = 0, sum = 0, worst = 0;
    std::vector<double> differences;
    for (int y = 0; y < k_size; ++y)
        for (int x = 0; x < k_size; ++x) {
            const auto here = static_cast<std::size_t>(3 * (y * k_size + x)),
                       there = static_cast<std::size_t>(3 * (y * k_size + k_size - 1 - x));
            const double difference = static_cast<double>(mirrored[here]) - static_cast<double>(direct[there]);
            squares += difference * difference, sum += static_cast<double>(direct[there]);
            differences.push_back(std::abs(difference));
        }
    constexpr double k_pixels = k_size * k_size;
    const double mean = sum / k_pixels;
    std::ranges::sort(differences);
    worst = differences[static_cast<std::size_t>(0.999 * k_pixels)];
    std::printf("nRMSE %.4f, one pixel of 1,000 %.4f of the mean\n", std::sqrt(squares / k_pixels) / mean,
                worst / mean);
    EXPECT_GT(mean, 0.1);
    EXPECT_LE(std::sqrt(squares / k_pixels) / mean, 0.01);
    EXPECT_LE(worst / mean, 0.08);
}

TEST(PlaceLattice, HasTheSameBytesColdWarmAndOnAnyNumberOfThreads)
{
    const Scene scene = box_before_mirror();
    Renderer warm(options());
    const std::vector<float> image = colours(warm.render(scene, seen(false)));
    EXPECT_EQ(colours(warm.render(scene, seen(false))), image);
    warm.render(scene, seen(true));
    EXPECT_EQ(colours(warm.render(scene, seen(false))), image);
    RenderOptions one = options();
    one.threads = 1;
    EXPECT_EQ(colours(Renderer(one).render(scene, seen(false))), image);
}

}   // namespace
}   // namespace gnomon
