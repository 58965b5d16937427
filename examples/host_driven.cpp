// SPDX-License-Identifier: Apache-2.0
// A host with a loop of its own: a hundred balls fall on a floor and bounce until they rest.
//
//   example_host_driven [FRAMES [WIDTH [NAME]]]     writes NAME-0001.png and so on
//
// The balls are declared `may_move`; the floor is fixed. Each frame hands over the balls that moved, and nothing else.
// The printed counters show what that costs: shadows on the floor that no ball can reach are remembered, and a ball
// that rests is not visited any more.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "gnomon/gnomon.h"
#include "shapes.h"

namespace {

constexpr int k_balls = 100, k_rows = 10;
constexpr double k_radius = 0.12, k_spacing = 0.4;   // metres
constexpr double k_gravity = 9.81;                   // metres per second squared
constexpr double k_bounce = 0.55;                    // of a ball's speed remains when it leaves the floor
constexpr double k_rest = 0.4;                       // metres per second below which a ball comes to rest
constexpr double k_step = 1.0 / 24;                  // seconds from frame to frame

struct Ball {
    gnomon::InstanceId instance{};
    double x = 0, y = 0, z = 0;   // of its centre
    double speed = 0;             // upwards
    bool rests = false;

    gnomon::Transform transform() const { return place(x, y, z, k_radius, k_radius, k_radius); }
};

/// Adds a square of balls at heights that form a wave.
std::vector<Ball> add_balls(gnomon::SceneBuilder& builder)
{
    const gnomon::MeshId sphere = add_sphere(builder);
    const gnomon::MaterialId colors[] = {add_color(builder, {0.8f, 0.2f, 0.1f}), add_color(builder, {0.1f, 0.4f, 0.8f}),
                                         add_color(builder, {0.9f, 0.7f, 0.2f})};
    std::vector<Ball> balls(k_balls);
    for (int i = 0; i < k_balls; ++i) {
        const int row = i / k_rows, column = i % k_rows;
        Ball& ball = balls[static_cast<std::size_t>(i)];
        ball.x = (column - 4.5) * k_spacing;
        ball.y = 1.2 + 0.6 * std::sin(0.7 * row + 0.4 * column);
        ball.z = (row - 4.5) * k_spacing;
        ball.instance = builder.instance(sphere, colors[(row + column) % 3], ball.transform(),
                                         {.mobility = gnomon::Mobility::may_move});
    }
    return balls;
}

gnomon::Scene make_scene(std::vector<Ball>& balls)
{
    gnomon::SceneBuilder builder;
    builder.instance(add_cube(builder), add_color(builder, {0.6f, 0.6f, 0.6f}), place(0, -0.1, 0, 12, 0.2, 12));
    balls = add_balls(builder);
    builder.light({.color = {70, 65, 55}}, gnomon::Transform::translation(2, 5, 3));    // candela
    builder.light({.color = {15, 18, 25}}, gnomon::Transform::translation(-5, 4, 2));   // into the shadows
    builder.background({0.1f, 0.15f, 0.25f});
    gnomon::Camera camera;
    camera.transform = gnomon::Transform::look_at({3.2f, 2.6f, 4.6f}, {0, 0.5f, 0});
    camera.vertical_fov = 0.7;
    builder.camera(camera);
    return builder.finish();
}

/// Moves the balls by one frame; returns what the renderer must know: the transforms of those that moved.
std::vector<gnomon::NodeTransform> simulate(std::vector<Ball>& balls)
{
    std::vector<gnomon::NodeTransform> moved;
    for (Ball& ball : balls) {
        if (ball.rests) continue;
        ball.speed -= k_gravity * k_step;
        ball.y += ball.speed * k_step;
        if (ball.y < k_radius) {
            ball.y = k_radius;
            ball.speed *= -k_bounce;
            ball.rests = ball.speed < k_rest;
        }
        moved.push_back({ball.instance, ball.transform()});
    }
    return moved;
}

}   // namespace

int main(int argc, char** argv)
try {
    const int frames = argc > 1 ? std::atoi(argv[1]) : 72;
    const int width = argc > 2 ? std::atoi(argv[2]) : 640;
    const std::string name = argc > 3 ? argv[3] : "balls";
    std::vector<Ball> balls;
    const gnomon::Scene scene = make_scene(balls);

    gnomon::Renderer renderer({.size = {width, width * 9 / 16}, .exposure = 0.0});
    std::printf("frame  balls moved  nodes updated  shadow rays  without a ray      ms\n");
    for (int frame = 1; frame <= frames; ++frame) {
        gnomon::FrameInput input;
        if (frame > 1) input.transforms = simulate(balls);
        const gnomon::Frame image = renderer.render(scene, input);
        image.write(name + "-" + std::to_string(10000 + frame).substr(1) + ".png");

        const gnomon::FrameCounters& work = image.counters;
        std::printf("%5d  %11zu  %13zu  %11zu  %13zu  %6.1f\n", frame, input.transforms.size(),
                    static_cast<std::size_t>(work.update.nodes), static_cast<std::size_t>(work.shadow.rays),
                    static_cast<std::size_t>(work.shadow.rays_skipped), image.milliseconds);
    }
    return 0;
} catch (const gnomon::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
