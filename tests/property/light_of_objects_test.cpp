// SPDX-License-Identifier: Apache-2.0
// What single objects reflect to the ground that they stand above, under an even sky: those that stand still, by
// patches, and those that may move; against the path-traced reference, in absolute units.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr double k_pi = std::numbers::pi;

enum class Shape { ball, box };

struct Triangles {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
};

// A ball of radius .5, of small triangles, whose fronts face outwards.
Triangles ball()
{
    constexpr std::uint32_t k_rings = 24, k_around = 48;
    Triangles mesh;
    for (std::uint32_t i = 0; i <= k_rings; ++i)
        for (std::uint32_t j = 0; j < k_around; ++j) {
            const double theta = k_pi * i / k_rings, phi = 2 * k_pi * j / k_around;
            mesh.positions.push_back({static_cast<float>(0.5 * std::sin(theta) * std::cos(phi)),
                                      static_cast<float>(0.5 * std::cos(theta)),
                                      static_cast<float>(0.5 * std::sin(theta) * std::sin(phi))});
        }
    for (std::uint32_t i = 0; i < k_rings; ++i)
        for (std::uint32_t j = 0; j < k_around; ++j) {
            const std::uint32_t a = i * k_around + j, b = i * k_around + (j + 1) % k_around;
            if (i > 0) mesh.indices.insert(mesh.indices.end(), {a, b, a + k_around});
            if (i + 1 < k_rings) mesh.indices.insert(mesh.indices.end(), {b, b + k_around, a + k_around});
        }
    return mesh;
}

// A cube with sides of 1, likewise.
Triangles box()
{
    Triangles mesh;
    for (std::uint32_t corner = 0; corner < 8; ++corner)
        mesh.positions.push_back(
            {(corner & 1) != 0 ? 0.5f : -0.5f, (corner & 2) != 0 ? 0.5f : -0.5f, (corner & 4) != 0 ? 0.5f : -0.5f});
    mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 4, 2, 2, 4, 6,
                    1, 3, 5, 3, 7, 5, 2, 6, 3, 3, 6, 7, 0, 1, 4, 1, 5, 4};
    return mesh;
}

struct Case {
    Shape shape;
    Mobility mobility;
    bool inside_out = false;   // its triangles face inwards, and are double-sided
};

// An object a tenth above a ground that is forty times as wide, under the upper half of an even sky.
Scene stage(const Case& of)
{
    SceneBuilder builder;
    const std::vector<Vec3> ground{{-20, 0, -20}, {20, 0, -20}, {20, 0, 20}, {-20, 0, 20}};
    const std::vector<std::uint32_t> quad{0, 2, 1, 0, 3, 2};
    builder.instance(builder.mesh({.positions = ground, .indices = quad}),
                     builder.material({.base_color = {0.2f, 0.2f, 0.2f}, .roughness = 1, .ior = 1}));
    Triangles mesh = of.shape == Shape::ball ? ball() : box();
    for (std::size_t t = 0; of.inside_out && t < mesh.indices.size(); t += 3)
        std::swap(mesh.indices[t], mesh.indices[t + 1]);
    Material white{.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1};
    white.double_sided = of.inside_out;
    builder.instance(builder.mesh({.positions = mesh.positions, .indices = mesh.indices}), builder.material(white),
                     Transform::translation(0, 0.6, 0), {.mobility = of.mobility});
    constexpr int k_width = 64, k_height = 32;
    std::vector<float> sky(3 * k_width * k_height, 0.0f);
    std::fill_n(sky.begin(), sky.size() / 2, 1.0f);
    builder.environment({.width = k_width, .height = k_height, .pixels = sky});
    return builder.finish();
}

// The mean bounced light of what a camera sees in a narrow field of view.
double bounced(const Scene& scene, const Vec3& eye, const Vec3& target, int paths)
{
    RenderOptions options;
    options.size = {16, 16};
    options.layers = true;
    if (paths > 0) options.reference = ReferenceLightOptions{.spp = paths};
    Camera camera;
    camera.transform = Transform::look_at(eye, target);
    camera.vertical_fov = 0.014f;
    Renderer renderer(options);
    for (const Layer& layer : renderer.render(scene, {.camera = camera}).layers) {
        if (layer.name != "indirect") continue;
        double sum = 0;
        for (const float value : layer.copy()) sum += static_cast<double>(value);
        return sum / static_cast<double>(layer.copy().size());
    }
    throw std::runtime_error("no layer of indirect light");
}

// That of a spot of the ground.
double bounced_at(const Scene& scene, float z, int paths)
{
    return bounced(scene, {0, 0.6f, z + 3}, {0, 0, z}, paths);
}

// Below a cube .21 of the light was left, below a ball .53: nodes of the light tree held the object's lower side and
// the underside of the ground, which is far larger and all but black, and counted as lights of that size.
TEST(LightOfObjects, ThatStandStillIsThatOfTheReference)
{
    for (const Shape shape : {Shape::ball, Shape::box}) {
        const Scene scene = stage({shape, Mobility::fixed});
        for (const float z : {0.3f, 0.7f, 1.0f, 1.5f}) {
            const double truth = bounced_at(scene, z, 2048), got = bounced_at(scene, z, 0);
            std::printf("%s, %.1f: %.3f of the reference's %.5f\n", shape == Shape::ball ? "ball" : "box",
                        static_cast<double>(z), got / truth, truth);
            EXPECT_NEAR(got / truth, 1, 0.05) << z;
        }
    }
}

// Sides of a box that face eight ways were summed two by two and three by three: .65 to .75 of the light reached the
// ground around it.
TEST(LightOfObjects, ThatMayMoveIsAboutThatOfTheReference)
{
    for (const Case of : {Case{Shape::ball, Mobility::may_move}, {Shape::box, Mobility::may_move}}) {
        const Scene scene = stage(of), still = stage({of.shape, Mobility::fixed});
        for (const float z : {0.7f, 1.0f, 1.5f}) {
            const double truth = bounced_at(still, z, 2048), got = bounced_at(scene, z, 0);
            std::printf("%s, %.1f: %.3f of the reference's %.5f\n", of.shape == Shape::ball ? "ball" : "box",
                        static_cast<double>(z), got / truth, truth);
            EXPECT_NEAR(got / truth, 1, 0.14) << z;
        }
    }
}

// A trough that may move: light bounces from its walls to its bottom and back. Points on a dynamic object got nothing
// from the object itself.
TEST(LightOfObjects, ThatAreConcaveLightsThemselves)
{
    const auto trough = [](Mobility mobility) {
        SceneBuilder builder;
        Triangles mesh = box();
        mesh.indices.resize(36);
        mesh.indices.erase(mesh.indices.begin() + 24, mesh.indices.begin() + 30);   // its top
        Material white{.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1};
        white.double_sided = true;
        builder.instance(builder.mesh({.positions = mesh.positions, .indices = mesh.indices}), builder.material(white),
                         Transform::translation(0, 0.5, 0), {.mobility = mobility});
        constexpr int k_width = 32, k_height = 16;
        builder.environment(
            {.width = k_width, .height = k_height, .pixels = std::vector(3 * k_width * k_height, 1.0f)});
        return builder.finish();
    };
    const auto bottom = [](const Scene& scene, float x, int paths) {
        return bounced(scene, {x, 4, 0.01f}, {x, 0, 0}, paths);
    };
    const Scene moving = trough(Mobility::may_move), still = trough(Mobility::fixed);
    for (const float x : {0.0f, 0.25f, 0.4f}) {
        const double truth = bottom(still, x, 1024), got = bottom(moving, x, 0);
        std::printf("%.2f: %.3f of the reference's %.5f\n", static_cast<double>(x), got / truth, truth);
        EXPECT_GT(truth, 0.1);
        EXPECT_NEAR(got / truth, 1, 0.1) << x;
    }
}

// Skins may turn a mesh inside out, and double-sided materials hide it: such an object gave off no light at all.
TEST(LightOfObjects, ThatAreInsideOutIsTheSame)
{
    for (const Shape shape : {Shape::ball, Shape::box}) {
        const double right = bounced_at(stage({shape, Mobility::may_move}), 1, 0),
                     inside_out = bounced_at(stage({shape, Mobility::may_move, true}), 1, 0);
        EXPECT_NEAR(inside_out / right, 1, 0.06);
    }
}

}   // namespace
}   // namespace gnomon
