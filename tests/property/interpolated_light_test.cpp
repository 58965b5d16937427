// SPDX-License-Identifier: Apache-2.0
// Soft light that is interpolated between pixels (trace/tile_lattice.cpp): the image of a frame in which every pixel
// computes its own, at fewer shadow rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "ray/ray_scene.h"
#include "trace/environment_lighting.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

constexpr int k_size = 192;

// A sky with bright squares all around.
std::vector<float> bright_squares(int width, int height)
{
    std::vector<float> pixels(static_cast<std::size_t>(width * height * 3), 0.5f);
    for (int y = height / 8; y < 3 * height / 8; ++y)
        for (int x = 0; x < width; ++x)
            if (x % 8 < 2) std::fill_n(pixels.data() + 3 * (y * width + x), 3, 6.0f);
    return pixels;
}

// Blocks of a matte, a glossy and a metallic surface on a floor, some of them a few pixels wide.
Scene blocks()
{
    SceneBuilder builder;
    const std::vector<Vec3> floor = {{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}};
    const std::vector<std::uint32_t> square = {0, 1, 2, 0, 2, 3};
    const std::vector<std::uint32_t> cube = {0, 4, 5, 0, 5, 1, 1, 5, 6, 1, 6, 2, 2, 6, 7, 2, 7, 3,
                                             3, 7, 4, 3, 4, 0, 4, 7, 6, 4, 6, 5, 0, 1, 2, 0, 2, 3};
    const MaterialId matte = builder.material({.base_color = {0.7f, 0.6f, 0.5f}, .roughness = 1, .ior = 1});
    const MaterialId glossy = builder.material({.base_color = {0.2f, 0.3f, 0.6f}, .roughness = 0.4f});
    const MaterialId metal = builder.material({.base_color = {0.9f, 0.7f, 0.4f}, .metallic = 1, .roughness = 0.3f});
    builder.instance(builder.mesh({.positions = floor, .indices = square}), matte);
    const auto put = [&](MaterialId material, float x, float z, float side, float height) {
        std::vector<Vec3> corners;
        for (const float y : {0.0f, height})
            corners.insert(corners.end(), {{x, y, z}, {x + side, y, z}, {x + side, y, z + side}, {x, y, z + side}});
        builder.instance(builder.mesh({.positions = corners, .indices = cube}), material);
    };
    // In a plate, bright squares have edges.
    const MaterialId plate = builder.material({.base_color = {0.9f, 0.9f, 0.9f}, .metallic = 1, .roughness = 0.12f});
    put(plate, -3, -4, 6, 0.02f);
    put(matte, -2, -1, 1, 1), put(glossy, 0, -1, 1, 1.5f), put(metal, 1.5f, 0, 0.8f, 0.8f);
    for (int i = 0; i < 6; ++i) put(i % 2 == 0 ? matte : glossy, -2 + 0.5f * static_cast<float>(i), 1.2f, 0.08f, 0.6f);
    builder.environment({.width = 32, .height = 16, .pixels = bright_squares(32, 16)});
    Camera camera;
    camera.transform = Transform::look_at({1, 4, 6}, {0, 0.3, 0});
    builder.camera(camera);
    return builder.finish();
}

struct Traced {
    shading::FrameBuffers buffers;
    FrameCounters counters;
};

Traced traced(const scene::SceneState& state, bool interpolates)
{
    const ray::RayScene rays(state);
    const scene::View view = scene::make_view(state, 0, {k_size, k_size});
    trace::EnvironmentTechnique environment;
    trace::TracedOptions options{.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = 0.0f};
    options.interpolates = interpolates;
    options.layers = true;
    Tasks tasks(1);
    Traced result;
    result.counters =
        trace::trace_frame(state, rays, view, options, tasks, result.buffers, {.environment = &environment});
    return result;
}

TEST(InterpolatedLight, IsThatOfEveryPixel)
{
    const std::shared_ptr<const scene::Scene> scene = api::scene_of(blocks());
    const scene::SceneState state(scene, 0);
    const Traced every = traced(state, false), some = traced(state, true);
    // The bright squares' shadows are sharp: many pixels compute their own.
    EXPECT_LT(some.counters.shadow.rays, 0.9 * static_cast<double>(every.counters.shadow.rays));
    for (const auto layer : {&shading::FrameBuffers::color, &shading::FrameBuffers::direct}) {
        const std::vector<float>&a = (every.buffers.*layer).data, &b = (some.buffers.*layer).data;
        ASSERT_EQ(a.size(), b.size());
        double square = 0, mean = 0, most = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double off = static_cast<double>(b[i] - a[i]);
            square += off * off, mean += static_cast<double>(a[i]), most = std::max(most, std::abs(off));
        }
        mean /= static_cast<double>(a.size());
        EXPECT_LT(std::sqrt(square / static_cast<double>(a.size())), 0.0012 * mean);
        EXPECT_LT(most, 0.1 * mean);
    }
}

}   // namespace
}   // namespace gnomon
