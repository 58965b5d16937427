// SPDX-License-Identifier: Apache-2.0
// Rooms that an environment image lights through a window: closed forms, no steps from pixel to pixel, and the same
// bytes however a frame is made.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr float k_depth = 4;   // of the room, from the window to the wall that is looked at

struct Opening {
    float left, right, low, high;   // in a wall of x from -1.5 to 1.5 and y from 0 to 3
};
constexpr Opening k_window = {-0.6f, 0.5f, 0.9f, 2.1f};
constexpr Opening k_small = {-0.35f, 0.28f, 1.2f, 1.8f};   // as wide as a cell, as seen from the other wall
constexpr Opening k_half = {0.1f, 0.4f, 0.9f, 2.1f}, k_slit = {0.1f, 0.25f, 0.9f, 2.1f};   // narrower than a cell
constexpr Opening k_hole = {-0.28f, -0.08f, 1.4f, 1.6f};

void add_quad(std::vector<Vec3>& positions, std::vector<std::uint32_t>& indices, const std::array<Vec3, 4>& corner)
{
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), corner.begin(), corner.end());
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + i);
}

// A black room around a grey wall at z = 0, which faces the window at z = k_depth. What lights the wall is the sky
// alone.
Scene room(const Opening& window, bool shutter_moves = false)
{
    SceneBuilder builder;
    const MaterialId black = builder.material({.base_color = {0, 0, 0}, .roughness = 1, .ior = 1});
    const MaterialId grey = builder.material({.base_color = {0.5f, 0.5f, 0.5f}, .roughness = 1, .ior = 1});
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    const float l = -1.5f, r = 1.5f, t = 3, d = k_depth;
    add_quad(positions, indices, {Vec3{l, 0, 0}, {l, 0, d}, {r, 0, d}, {r, 0, 0}});
    add_quad(positions, indices, {Vec3{l, t, 0}, {r, t, 0}, {r, t, d}, {l, t, d}});
    add_quad(positions, indices, {Vec3{l, 0, 0}, {l, t, 0}, {l, t, d}, {l, 0, d}});
    add_quad(positions, indices, {Vec3{r, 0, 0}, {r, 0, d}, {r, t, d}, {r, t, 0}});
    const auto [wl, wr, low, high] = window;
    add_quad(positions, indices, {Vec3{l, 0, d}, {l, low, d}, {r, low, d}, {r, 0, d}});
    add_quad(positions, indices, {Vec3{l, high, d}, {l, t, d}, {r, t, d}, {r, high, d}});
    add_quad(positions, indices, {Vec3{l, low, d}, {l, high, d}, {wl, high, d}, {wl, low, d}});
    add_quad(positions, indices, {Vec3{wr, low, d}, {wr, high, d}, {r, high, d}, {r, low, d}});
    builder.instance(builder.mesh({.positions = positions, .indices = indices}), black, Transform{});
    positions.clear(), indices.clear();
    add_quad(positions, indices, {Vec3{l, 0, 0}, {r, 0, 0}, {r, t, 0}, {l, t, 0}});
    builder.instance(builder.mesh({.positions = positions, .indices = indices}), grey, Transform{});
    if (shutter_moves) {
        // It covers the right half of the window.
        positions.clear(), indices.clear();
        const float middle = 0.5f * (wl + wr);
        add_quad(positions, indices,
                 {Vec3{middle, low - 0.1f, d - 0.01f},
                  {middle, high + 0.1f, d - 0.01f},
                  {wr + 0.1f, high + 0.1f, d - 0.01f},
                  {wr + 0.1f, low - 0.1f, d - 0.01f}});
        builder.instance(builder.mesh({.positions = positions, .indices = indices}), black, Transform{},
                         {.mobility = Mobility::may_move});
    }
    const std::vector<float> white(2 * 3, 1.0f);
    builder.environment({.width = 2, .height = 1, .pixels = white});
    return builder.finish();
}

// Looks at the wall from within, 2 m wide and high.
FrameInput input()
{
    Camera camera;
    camera.transform = Transform::look_at({0, 1.5, 1}, {0, 1.5, 0});
    camera.orthographic_height = 2;
    FrameInput of;
    of.camera = camera;
    return of;
}

RenderOptions options_of(int size)
{
    RenderOptions options;
    options.size = {size, size};
    options.indirect = Indirect::visible;
    options.bounces = 1;          // of which there are none: all but the wall is black
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

std::vector<float> colours(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

// The irradiance over pi at a point of the wall under a sky of radiance 1 behind a rectangle at a distance: the form
// factor by the sum over its corners.
double form_factor(const Opening& window, double x, double y)
{
    const auto corner = [&](double a, double b) {
        const double d2 = k_depth * k_depth;
        const double ra = std::sqrt(a * a + d2), rb = std::sqrt(b * b + d2);
        return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * 3.14159265358979323846);
    };
    return corner(window.right - x, window.high - y) - corner(window.left - x, window.high - y) -
           corner(window.right - x, window.low - y) + corner(window.left - x, window.low - y);
}

struct Errors {
    double nrmse = 0, mean_ratio = 0;
    double step =
        0;   // from one pixel to the next, beyond that of the closed form: root of the mean square, of the mean
};

Errors errors_of(const std::vector<float>& image, int size, const Opening& window)
{
    double sum = 0, truth_sum = 0, squares = 0;
    std::vector<double> difference;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const double at_x = -1 + 2 * (x + 0.5) / size, at_y = 2.5 - 2 * (y + 0.5) / size;
            const double truth = 0.5 * form_factor(window, at_x, at_y);
            const auto value = static_cast<double>(image[static_cast<std::size_t>(3 * (y * size + x))]);
            sum += value, truth_sum += truth, squares += (value - truth) * (value - truth);
            difference.push_back(value - truth);
        }
    const double pixels = size * size, mean = truth_sum / pixels;
    Errors errors{std::sqrt(squares / pixels) / mean, sum / truth_sum};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x + 1 < size; ++x) {
            const auto at = static_cast<std::size_t>(y * size + x);
            const double step = (difference[at + 1] - difference[at]) / mean;
            errors.step += step * step / (pixels - size);
        }
    errors.step = std::sqrt(errors.step);
    return errors;
}

TEST(WindowLight, OnAWallIsTheClosedForm)
{
    constexpr int k_size = 96;
    struct Case {
        Opening window;
        double nrmse, mean, step;   // at most: errors, of the mean
    };
    // Of narrow windows, what a pixel sees is counted in few parts of cells: right on average, but not free of steps.
    for (const Case& of :
         {Case{k_window, 0.02, 0.01, 0.01}, Case{k_small, 0.04, 0.015, 0.03}, Case{k_half, 0.045, 0.015, 0.04},
          Case{k_slit, 0.08, 0.015, 0.08}, Case{k_hole, 0.18, 0.02, 0.16}}) {
        Renderer renderer(options_of(k_size));
        const Errors errors = errors_of(colours(renderer.render(room(of.window), input())), k_size, of.window);
        std::printf("window of %.2f m: nRMSE %.4f, mean %.4f, steps %.4f of the mean\n",
                    static_cast<double>(of.window.right - of.window.left), errors.nrmse, errors.mean_ratio,
                    errors.step);
        EXPECT_LE(errors.nrmse, of.nrmse);
        EXPECT_NEAR(errors.mean_ratio, 1, of.mean);
        EXPECT_LE(errors.step, of.step);
    }
}

TEST(WindowLight, AShutterThatMayMoveTakesItsHalf)
{
    constexpr int k_size = 64;
    Opening half = k_window;
    half.right = 0.5f * (k_window.left + k_window.right);
    Renderer renderer(options_of(k_size));
    const Errors errors = errors_of(colours(renderer.render(room(k_window, true), input())), k_size, half);
    EXPECT_LE(errors.nrmse, 0.05);
    EXPECT_NEAR(errors.mean_ratio, 1, 0.03);
}

TEST(WindowLight, HasTheSameBytesColdWarmAndOnAnyNumberOfThreads)
{
    for (const bool moves : {false, true}) {
        const Scene scene = room(k_window, moves);
        const RenderOptions options = options_of(64);
        Renderer warm(options);
        const std::vector<float> image = colours(warm.render(scene, input()));
        for (int again = 0; again < 3; ++again) EXPECT_EQ(colours(warm.render(scene, input())), image);
        RenderOptions one = options;
        one.threads = 1;
        EXPECT_EQ(colours(Renderer(one).render(scene, input())), image);
        one.shadow_culling = ShadowCulling::off;
        EXPECT_EQ(colours(Renderer(one).render(scene, input())), image);
        // From another view, proofs and memory are those of both.
        FrameInput other = input();
        other.camera->orthographic_height = 1.7;
        warm.render(scene, other);
        EXPECT_EQ(colours(warm.render(scene, input())), image);
    }
}

TEST(WindowLight, AStillViewCostsNoRays)
{
    const Scene scene = room(k_window);
    Renderer renderer(options_of(64));
    EXPECT_GT(renderer.render(scene, input()).counters.shadow.rays, 1000u);
    renderer.render(scene, input());
    EXPECT_EQ(renderer.render(scene, input()).counters.shadow.rays, 0u);
}

}   // namespace
}   // namespace gnomon
