// SPDX-License-Identifier: Apache-2.0
// Dynamic objects give off light of every kind: of the sky, of emissive surfaces, and light that has bounced before;
// against the path-traced reference, in absolute units.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "base/bits.h"
#include "gnomon/gnomon.h"
#include "support.h"

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

// The same board as a file has it, in pieces x pieces below one animated node, before a floor and under an even sky.
Scene in_pieces(int pieces, const char* color, bool from_the_last)
{
    const test::ScratchFolder folder;
    const std::array<float, 26> numbers{-0.5f, 0,    -0.5f, 0.5f, 0,    0.5f, 0.5f, 0, -0.5f, -0.5f, 0, -0.5f, -0.5f,
                                        0,     0.5f, 0.5f,  0,    0.5f, 0,    1,    0, 0,     0,     0, 0,     0};
    std::ofstream(folder / "numbers.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    std::string children, nodes;
    for (int i = 0; i < pieces * pieces; ++i) {
        const int piece = from_the_last ? pieces * pieces - 1 - i : i;
        const double x = (piece % pieces + 0.5) / pieces - 0.5, z = (piece / pieces + 0.5) / pieces - 0.5;
        children += fmt::format("{}{}", i == 0 ? "" : ",", 4 + i);
        nodes +=
            fmt::format(R"(,{{"mesh":1,"translation":[{},0,{}],"scale":[{},1,{}]}})", x, z, 1.0 / pieces, 1.0 / pieces);
    }
    constexpr double k_half = 0.70710678118654752;
    std::ofstream(folder / "scene.gltf")
        << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,3]}],"nodes":[{"mesh":0,"scale":[8,1,8]},)"
        << R"({"children":[2]},{"translation":[0,0.751,-0.5],"rotation":[)" << k_half << ",0,0," << k_half
        << R"(],"scale":[2,1,1.5],"children":[)" << children
        << R"(]},{"camera":0,"translation":[0,1.2,0.9],"rotation":[-0.42,0,0,0.9075]})" << nodes
        << R"(],"cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.01}}],
        "materials":[{"doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,1]}},
                     {"doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":)"
        << color << R"(}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]},
                  {"primitives":[{"attributes":{"POSITION":0},"material":1}]}],
        "buffers":[{"uri":"numbers.bin","byteLength":104}],
        "bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":8},
                       {"buffer":0,"byteOffset":80,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[-0.5,0,-0.5],"max":[0.5,0,0.5]},
                     {"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},
                     {"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":1,"path":"translation"}}],
                       "samplers":[{"input":1,"output":2}]}]})";
    SceneBuilder builder(load((folder / "scene.gltf").string()));
    builder.environment({.width = 16, .height = 8, .pixels = std::vector(16 * 8 * 3, 1.0f)});
    return builder.finish();
}

// Of more objects than places, some stand for all; which ones does not depend on their numbers.
TEST(MovingReflections, OfManyPiecesAreThatOfTheWhole)
{
    constexpr int k_pieces = 33;
    const RenderOptions options = options_of(32);
    const auto floor = [&](int pieces, const char* color, bool from_the_last = false) {
        return floor_of(Renderer(options).render(in_pieces(pieces, color, from_the_last), 1)).x;
    };
    const char *const red = "[0.9,0.1,0.1,1]", *const black = "[0,0,0,1]";
    const float whole = floor(1, red), without = floor(1, black), parts = floor(k_pieces, red),
                parts_without = floor(k_pieces, black), turned = floor(k_pieces, red, true);
    std::printf("floor before a red board: %.4f, a black one %.4f; in %d pieces %.4f and %.4f\n",
                static_cast<double>(whole), static_cast<double>(without), k_pieces * k_pieces,
                static_cast<double>(parts), static_cast<double>(parts_without));
    EXPECT_GT(whole, 1.02f * without) << "the board gives off nothing that shows";
    EXPECT_NEAR(parts - parts_without, whole - without, 0.03f * (whole - without));
    EXPECT_EQ(parts, turned) << "the pieces' numbers matter";
}

INSTANTIATE_TEST_SUITE_P(EachLight, MovingReflection, testing::Values(Source::sky, Source::panel, Source::bounced),
                         [](const auto& test) {
                             return test.param == Source::sky     ? "Sky"
                                    : test.param == Source::panel ? "Panel"
                                                                  : "Bounced";
                         });

}   // namespace
}   // namespace gnomon
