// SPDX-License-Identifier: Apache-2.0
// Dynamic objects give off light of every kind: of the sky, of emissive surfaces, and light that has bounced before;
// against the path-traced reference, in absolute units.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <utility>

#include "base/bits.h"
#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr double k_pi = std::numbers::pi;

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_up{0, 2, 1, 0, 3, 2};

Material matte(const Vec3& albedo)
{
    Material material{.base_color = {albedo.x, albedo.y, albedo.z}, .roughness = 1, .ior = 1};
    material.double_sided = true;
    return material;
}

enum class Source { sky, panel, bounced };

// A floor, and before the camera a board that stands on it and may move.
struct Stage {
    SceneBuilder builder;
    NodeId board;
    explicit Stage(Source light, const Vec3& albedo)
    {
        const MeshId square = builder.mesh({.positions = k_square, .indices = k_up});
        const MaterialId grey = builder.material(matte({0.5f, 0.5f, 0.5f}));
        builder.instance(square, grey, Transform::scaling(8, 1, 8));
        board = builder.node();
        builder.instance(square, builder.material(matte(albedo)),
                         Transform::translation(0, 0.751, -0.5) * Transform::rotation({1, 0, 0}, k_pi / 2) *
                             Transform::scaling(2, 1, 1.5),
                         {.mobility = Mobility::may_move, .parent = board});
        if (light == Source::sky)
            builder.environment({.width = 16, .height = 8, .pixels = std::vector(16 * 8 * 3, 1.0f)});
        if (light == Source::panel) {
            // Faces the board from above the camera, and the floor next to nothing.
            Material shining = matte({0, 0, 0});
            shining.emissive = {10, 10, 10};
            shining.double_sided = false;
            builder.instance(square, builder.material(shining),
                             Transform::translation(0, 1, 2) * Transform::rotation({1, 0, 0}, -k_pi / 2) *
                                 Transform::scaling(0.5, 1, 0.5));
        }
        if (light == Source::bounced) {
            // Lights a wall opposite the board, from behind a screen that hides the board from it.
            const MaterialId white = builder.material(matte({0.9f, 0.9f, 0.9f}));
            builder.instance(square, white,
                             Transform::translation(0, 1.5, 2.5) * Transform::rotation({1, 0, 0}, k_pi / 2) *
                                 Transform::scaling(4, 1, 3));
            builder.instance(square, builder.material(matte({0, 0, 0})),
                             Transform::translation(0, 1, 1.4) * Transform::rotation({1, 0, 0}, k_pi / 2) *
                                 Transform::scaling(0.6, 1, 0.6));
            builder.light({.type = LightType::spot, .color = {40, 40, 40}, .inner_angle = 0.5f, .outer_angle = 0.7f},
                          Transform::translation(0, 1, 1.5) * Transform::rotation({0, 1, 0}, k_pi));
        }
        Camera camera;
        camera.transform = Transform::look_at({0, 1.2f, 0.9f}, {0, 0, -0.15f});
        camera.vertical_fov = 0.7f;
        builder.camera(camera);
    }
};

RenderOptions options_of(int size)
{
    RenderOptions options;
    options.size = {size, size};
    options.bounces = k_all_bounces;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

// Mean of each colour of the lower half of an image, which shows the floor.
Vec3 floor_of(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    Vec3 sum{0, 0, 0};
    const std::size_t pixels = values.size() / 3, first = pixels / 2;
    for (std::size_t i = first; i < pixels; ++i)
        sum.x += values[3 * i], sum.y += values[3 * i + 1], sum.z += values[3 * i + 2];
    const auto count = static_cast<float>(pixels - first);
    return {sum.x / count, sum.y / count, sum.z / count};
}

class MovingReflection : public testing::TestWithParam<Source> {};

TEST_P(MovingReflection, LightsTheFloorAsInTheReference)
{
    // A red board leaves its colour on the floor.
    const Scene red = Stage(GetParam(), {0.9f, 0.1f, 0.1f}).builder.finish(),
                black = Stage(GetParam(), {0, 0, 0}).builder.finish();
    RenderOptions options = options_of(48);
    const Vec3 cached = floor_of(Renderer(options).render(red, 1)),
               without = floor_of(Renderer(options).render(black, 1));
    options.reference = ReferenceLightOptions{.spp = 512, .bounces = 32};
    const Vec3 truth = floor_of(Renderer(options).render(red, 1)),
               truth_without = floor_of(Renderer(options).render(black, 1));
    std::printf("floor before a red board: %.4f %.4f, reference %.4f %.4f; a black one: %.4f, reference %.4f\n",
                static_cast<double>(cached.x), static_cast<double>(cached.y), static_cast<double>(truth.x),
                static_cast<double>(truth.y), static_cast<double>(without.x), static_cast<double>(truth_without.x));
    EXPECT_GT(truth.x, 1.1f * truth_without.x) << "the board gives off nothing that shows";
    // The wall that lights the last board is 4 % too bright on the floor, with a black board as well.
    const float closeness = GetParam() == Source::bounced ? 0.05f : 0.03f;
    EXPECT_NEAR(cached.x, truth.x, closeness * truth.x);
    EXPECT_NEAR(cached.y, truth.y, closeness * truth.y);
    EXPECT_NEAR(without.x, truth_without.x, closeness * truth_without.x);
}

// A court under the sky whose floor or walls may move is as bright as one that stands still: light bounces between
// dynamic objects, and they keep the sky from what lights them.
TEST(MovingCourt, IsAsBrightAsTheReferenceSays)
{
    for (const auto& [of_floor, of_walls] :
         {std::pair(Mobility::may_move, Mobility::may_move), std::pair(Mobility::fixed, Mobility::may_move)}) {
        SceneBuilder builder;
        const MeshId square = builder.mesh({.positions = k_square, .indices = k_up});
        const MaterialId grey = builder.material(matte({0.7f, 0.7f, 0.7f}));
        builder.instance(square, grey, Transform::scaling(4, 1, 4), {.mobility = of_floor});
        const Transform upright =
            Transform::translation(0, 1, -2) * Transform::rotation({1, 0, 0}, k_pi / 2) * Transform::scaling(4, 1, 2);
        for (const double turn : {0.0, 0.5 * k_pi, -0.5 * k_pi})
            builder.instance(square, grey, Transform::rotation({0, 1, 0}, turn) * upright, {.mobility = of_walls});
        builder.environment({.width = 16, .height = 8, .pixels = std::vector(16 * 8 * 3, 1.0f)});
        Camera camera;
        camera.transform = Transform::look_at({0, 1, 4}, {0, 0.5f, -2});
        camera.vertical_fov = 0.4f;
        builder.camera(camera);
        const Scene scene = builder.finish();
        RenderOptions options = options_of(32);
        const Vec3 cached = floor_of(Renderer(options).render(scene, 1));
        options.reference = ReferenceLightOptions{.spp = 256, .bounces = 32};
        const Vec3 truth = floor_of(Renderer(options).render(scene, 1));
        std::printf("court: %.4f, reference %.4f\n", static_cast<double>(cached.x), static_cast<double>(truth.x));
        EXPECT_NEAR(cached.x, truth.x, 0.06f * truth.x);
    }
}

// A wide floor keeps half of the sky from a niche of walls, whether it may move or not: also where the light of a pixel
// is found between others, which see some directions in part.
TEST(MovingCourt, AFloorThatMayMoveHidesTheSkyAsAStillOneDoes)
{
    const auto wall_above = [](Mobility of_floor) {
        SceneBuilder builder;
        const MeshId square = builder.mesh({.positions = k_square, .indices = k_up});
        const MaterialId grey = builder.material(matte({0.7f, 0.7f, 0.7f}));
        builder.instance(square, grey, Transform::scaling(200, 1, 200), {.mobility = of_floor});
        const Transform upright =
            Transform::translation(0, 1, -2) * Transform::rotation({1, 0, 0}, k_pi / 2) * Transform::scaling(4, 1, 2);
        for (const double turn : {0.0, 0.5 * k_pi, -0.5 * k_pi})
            builder.instance(square, grey, Transform::rotation({0, 1, 0}, turn) * upright);
        builder.environment({.width = 16, .height = 8, .pixels = std::vector(16 * 8 * 3, 1.0f)});
        Camera camera;
        camera.transform = Transform::look_at({0, 1, 4}, {0, 0.9f, -2});
        camera.vertical_fov = 0.25f;
        builder.camera(camera);
        RenderOptions options = options_of(48);
        options.indirect = Indirect::off;
        return static_cast<double>(floor_of(Renderer(options).render(builder.finish(), 1)).x);
    };
    const double still = wall_above(Mobility::fixed), moving = wall_above(Mobility::may_move);
    EXPECT_NEAR(moving, still, 0.05 * still);
}

// A frame does not depend on where the board was before.
TEST_P(MovingReflection, FollowsTheBoardAsIfNew)
{
    Stage stage(GetParam(), {0.9f, 0.1f, 0.1f});
    const NodeId board = stage.board;
    const Scene scene = stage.builder.finish();
    RenderOptions options = options_of(32);
    options.threads = 2;
    Renderer warm(options);
    for (const double x : {0.0, 0.7, -0.2}) {
        FrameInput input;
        input.transforms = {{board, Transform::translation(x, 0, 0.1 * x)}};
        const Frame now = warm.render(scene, input);
        options.threads = 1;
        Renderer cold(options);
        const Frame alone = cold.render(scene, input);
        const auto a = now.layers.front().values(), b = alone.layers.front().values();
        EXPECT_TRUE(same_bits(std::vector(a.begin(), a.end()), std::vector(b.begin(), b.end()))) << x;
    }
}

INSTANTIATE_TEST_SUITE_P(EachLight, MovingReflection, testing::Values(Source::sky, Source::panel, Source::bounced),
                         [](const auto& test) {
                             return test.param == Source::sky     ? "Sky"
                                    : test.param == Source::panel ? "Panel"
                                                                  : "Bounced";
                         });

}   // namespace
}   // namespace gnomon
