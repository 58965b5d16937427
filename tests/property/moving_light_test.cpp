// SPDX-License-Identifier: Apache-2.0
// Bounced light on what may move, and around it: without facets or dots, and that of the same object that stands still;
// and on smooth meshes of fine triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

struct Triangles {
    std::vector<Vec3> positions, normals;   // normals: none for a box
    std::vector<std::uint32_t> indices;
};

// A cube with sides of 1.2.
Triangles box()
{
    Triangles mesh;
    for (std::uint32_t corner = 0; corner < 8; ++corner)
        mesh.positions.push_back(
            {(corner & 1) != 0 ? 0.6f : -0.6f, (corner & 2) != 0 ? 0.6f : -0.6f, (corner & 4) != 0 ? 0.6f : -0.6f});
    mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 4, 2, 2, 4, 6,
                    1, 3, 5, 3, 7, 5, 2, 6, 3, 3, 6, 7, 0, 1, 4, 1, 5, 4};
    return mesh;
}

// A smooth ball of radius .6, whose triangles are as small as there are rings.
Triangles ball(std::uint32_t rings)
{
    const std::uint32_t around = 2 * rings;
    Triangles mesh;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j <= around; ++j) {
            const double theta = std::numbers::pi * i / rings, phi = std::numbers::pi * j / rings;
            const Vec3 n{static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                         static_cast<float>(std::sin(theta) * std::sin(phi))};
            mesh.normals.push_back(n);
            mesh.positions.push_back({0.6f * n.x, 0.6f * n.y, 0.6f * n.z});
        }
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = i * (around + 1) + j, b = a + 1, c = a + around + 1, d = c + 1;
            if (i > 0) mesh.indices.insert(mesh.indices.end(), {a, b, c});
            if (i + 1 < rings) mesh.indices.insert(mesh.indices.end(), {b, d, c});
        }
    return mesh;
}

// A column of radius .3 and height 1.2 of 512 pairs of triangles as high as it, and its ends.
Triangles column()
{
    constexpr std::uint32_t k_around = 512, k_ring = k_around + 1;
    Triangles mesh;
    for (const bool end : {false, true})
        for (const float y : {-0.6f, 0.6f})
            for (std::uint32_t j = 0; j < k_ring; ++j) {
                const double phi = 2 * std::numbers::pi * j / k_around;
                const auto x = static_cast<float>(std::cos(phi)), z = static_cast<float>(std::sin(phi));
                mesh.positions.push_back({0.3f * x, y, 0.3f * z});
                mesh.normals.push_back(end ? Vec3{0, y > 0 ? 1.0f : -1.0f, 0} : Vec3{x, 0, z});
            }
    for (std::uint32_t j = 0; j < k_around; ++j) {
        const std::uint32_t top = k_ring + j, low = 2 * k_ring, high = 3 * k_ring;
        mesh.indices.insert(mesh.indices.end(), {j, top, j + 1, j + 1, top, top + 1});
        if (j > 0) mesh.indices.insert(mesh.indices.end(), {low, low + j, low + j + 1, high, high + j + 1, high + j});
    }
    return mesh;
}

struct Albedo {
    float object = 0.7f, walls = 0.7f;   // two of the walls are red and green
};

struct Corner {
    Scene scene;
    InstanceId object;
};

constexpr double k_above = 0.65;   // the middle of the object: its foot is just above the floor
constexpr double k_standing = 0.6;

enum class Light { sky, bulb };

// An object in the corner of a floor, a red and a green wall, under an even sky with a bright spot, or a bulb.
Corner corner(const Triangles& mesh, Mobility mobility, const Albedo& albedo = {}, double height = k_above,
              Light of = Light::sky)
{
    SceneBuilder builder;
    const auto matte = [&](float r, float g, float b) {
        return builder.material({.base_color = {r, g, b}, .roughness = 1, .ior = 1});
    };
    const float light = albedo.walls, dark = 0.1f * albedo.walls;
    const std::vector<std::uint32_t> quad{0, 2, 1, 0, 3, 2};
    const auto wall = [&](const std::vector<Vec3>& positions, MaterialId material) {
        builder.instance(builder.mesh({.positions = positions, .indices = quad}), material);
    };
    wall({{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}}, matte(light, light, light));
    wall({{-2, 0, -2}, {-2, 0, 2}, {-2, 4, 2}, {-2, 4, -2}}, matte(light, dark, dark));
    wall({{-2, 0, -2}, {-2, 4, -2}, {2, 4, -2}, {2, 0, -2}}, matte(dark, light, dark));
    const InstanceId object =
        builder.instance(builder.mesh({.positions = mesh.positions, .indices = mesh.indices, .normals = mesh.normals}),
                         matte(albedo.object, albedo.object, albedo.object), Transform::translation(-0.9, height, 0.2),
                         {.mobility = mobility});
    if (of == Light::bulb) {
        builder.light({.color = {40, 40, 40}}, Transform::translation(1.5, 2.5, 2));
        return {builder.finish(), object};
    }
    constexpr int k_width = 64, k_height = 32;
    std::vector<float> sky(3 * k_width * k_height, 0.0f);
    std::fill_n(sky.begin(), sky.size() / 2, 0.3f);
    for (int y = 4; y < 8; ++y)
        for (int x = 20; x < 26; ++x) std::fill_n(sky.begin() + 3 * (y * k_width + x), 3, 60.0f);
    builder.environment({.width = k_width, .height = k_height, .pixels = sky});
    return {builder.finish(), object};
}

constexpr Size k_size{320, 240};

// The bounced light of the whole corner, brightness by pixel.
// @param vertices  of the object; empty: its own
// @param close     at its foot
std::vector<double> bounced(Renderer& renderer, const Corner& corner, const std::vector<Vec3>& vertices = {},
                            bool close = false)
{
    Camera camera;
    camera.transform = close ? Transform::look_at({0.6, 1.2, 2.2}, {-0.7, 0.1, 0.7})
                             : Transform::look_at({0.6, 1.5, 2.2}, {-0.9, 0.6, 0.2});
    camera.vertical_fov = close ? 0.35f : 0.75f;
    FrameInput input{.camera = camera};
    if (!vertices.empty()) input.vertices.push_back({corner.object, vertices});
    for (const Layer& layer : renderer.render(corner.scene, input).layers) {
        if (layer.name != "indirect") continue;
        const std::vector<float> values = layer.copy();
        std::vector<double> light;
        for (std::size_t i = 0; i < values.size(); i += 3)
            light.push_back(static_cast<double>(values[i] + values[i + 1] + values[i + 2]));
        return light;
    }
    throw std::runtime_error("no layer of indirect light");
}

RenderOptions options(Size size = k_size)
{
    RenderOptions options;
    options.size = size;
    options.layers = true;
    return options;
}

std::vector<double> bounced(const Corner& corner)
{
    Renderer renderer(options());
    return bounced(renderer, corner);
}

struct Window {
    int left, top, right, bottom;
};

// How far pixels are from the mean of those on both sides: the root of the mean square, relative to the mean.
double roughness(const std::vector<double>& light, const Window& of)
{
    double squares = 0, sum = 0;
    int count = 0;
    for (int y = of.top; y < of.bottom; ++y)
        for (int x = of.left; x < of.right; ++x) {
            const auto i = static_cast<std::size_t>(y * k_size.width + x), row = std::size_t{k_size.width};
            const double across = light[i] - 0.5 * (light[i - 1] + light[i + 1]),
                         down = light[i] - 0.5 * (light[i - row] + light[i + row]);
            squares += 0.5 * (across * across + down * down), sum += light[i];
            ++count;
        }
    return std::sqrt(squares / count) / (sum / count);
}

double mean(const std::vector<double>& light, const Window& of)
{
    double sum = 0;
    for (int y = of.top; y < of.bottom; ++y)
        for (int x = of.left; x < of.right; ++x) sum += light[static_cast<std::size_t>(y * k_size.width + x)];
    return sum / ((of.right - of.left) * (of.bottom - of.top));
}

void expect_smooth(const Triangles& mesh, const Window& window, double most, double closeness = 0.03)
{
    const std::vector<double> moving = bounced(corner(mesh, Mobility::may_move)),
                              still = bounced(corner(mesh, Mobility::fixed));
    const double rough = roughness(moving, window), ratio = mean(moving, window) / mean(still, window);
    std::printf("roughness %.5f (still %.5f), %.3f of the light of what stands still\n", rough,
                roughness(still, window), ratio);
    EXPECT_LT(rough, most);
    EXPECT_NEAR(ratio, 1, closeness);
}

// Each part of a side had light of its own: a pattern of triangles, strongest near the floor.
TEST(MovingLight, OnTheSidesOfABoxIsSmooth)
{
    const Window right{188, 80, 240, 150};
    expect_smooth(box(), right, 0.001);
}

// Clusters of small triangles showed as patches.
TEST(MovingLight, OnASmoothBallOfSmallTrianglesIsSmooth)
{
    const Window middle{130, 90, 190, 150};
    expect_smooth(ball(128), middle, 0.0025);
}

TEST(MovingLight, OnASmoothBallOfLargeTrianglesIsSmooth)
{
    const Window middle{130, 90, 190, 150};
    expect_smooth(ball(12), middle, 0.006);
}

// A lattice of cache points a spacing apart was said to miss how a fine mesh rises and falls, because a curved surface
// rises: each pixel had parts of triangles of its own, with rays of its own. Grain was .8 % on a ball, 4 % on a column.
TEST(FineMesh, OfTrianglesThatArePixelsWideIsLitWithoutGrain)
{
    const Window of_ball{130, 90, 190, 150}, of_column{146, 80, 174, 150};
    const double ball_grain = roughness(bounced(corner(ball(128), Mobility::fixed)), of_ball),
                 column_grain = roughness(bounced(corner(column(), Mobility::fixed)), of_column);
    std::printf("grain of a ball %.5f, of a column %.5f\n", ball_grain, column_grain);
    EXPECT_LT(ball_grain, 0.003);
    EXPECT_LT(column_grain, 0.006);
}

// On narrow triangles as high as a column parts were far from what they stood for.
TEST(FineMesh, OfLongTrianglesHasTheLightOfTheReference)
{
    const Window middle{146, 80, 174, 150};
    const Corner corner = gnomon::corner(column(), Mobility::fixed);
    RenderOptions truth = options();
    truth.reference = ReferenceLightOptions{.spp = 96};
    Renderer cached(options()), traced(truth);
    const double energy = mean(bounced(cached, corner), middle) / mean(bounced(traced, corner), middle);
    std::printf("%.3f of the reference's light\n", energy);
    EXPECT_NEAR(energy, 1, 0.015);
}

// A ball 35 pixels wide has the light of one that is four times as wide, pixel by pixel: few cache points do not do.
TEST(FineMesh, OfASmallBallHasTheLightOfALargeOne)
{
    constexpr Size k_small{80, 60};
    constexpr int k_wide = 4;
    const Corner corner = gnomon::corner(ball(128), Mobility::fixed);
    Renderer near(options()), far(options(k_small));
    const std::vector<double> large = bounced(near, corner), small = bounced(far, corner);
    double squares = 0, sum = 0;
    int count = 0;
    for (int y = 20; y < 40; ++y)
        for (int x = 30; x < 50; ++x) {
            const Window pixel{k_wide * x, k_wide * y, k_wide * (x + 1), k_wide * (y + 1)};
            const double light = mean(large, pixel),
                         off = small[static_cast<std::size_t>(y * k_small.width + x)] - light;
            squares += off * off, sum += light;
            ++count;
        }
    const double error = std::sqrt(squares / count) / (sum / count);
    std::printf("off by %.4f of the mean\n", error);
    EXPECT_LT(error, 0.045);
}

// The light of a window of a scene with an object that may move, relative to that with one that stands still.
double part_of_still(const Triangles& mesh, const Albedo& albedo, const Window& window)
{
    const double moving = mean(bounced(corner(mesh, Mobility::may_move, albedo)), window),
                 still = mean(bounced(corner(mesh, Mobility::fixed, albedo)), window);
    std::printf("%.3f of the light of what stands still\n", moving / still);
    return moving / still;
}

// Narrow triangles took the light of clusters from one end to the other, of the black bottom as well: dark dashes.
TEST(MovingLight, OnAColumnOfLongTrianglesIsSmooth)
{
    const Window middle{146, 80, 174, 150};
    expect_smooth(column(), middle, 0.002);
}

// What a black box blocks was blocked once, not at every bounce.
TEST(MovingLight, BesideABlackBoxIsBlockedAtEveryBounce)
{
    const Window floor{10, 200, 310, 239}, wall{2, 2, 120, 60};
    EXPECT_NEAR(part_of_still(box(), {.object = 0, .walls = 0.7f}, floor), 1, 0.03);
    EXPECT_NEAR(part_of_still(box(), {.object = 0, .walls = 0.7f}, wall), 1, 0.03);
}

// Light from a box to walls and floor and back was left out.
TEST(MovingLight, GoesFromABoxToWallsAndBack)
{
    const Window wall{2, 2, 120, 60}, right{188, 80, 240, 150};
    // .987 of the reference's light where the box stands still, .939 where it may move.
    EXPECT_NEAR(part_of_still(box(), {.object = 0.9f, .walls = 0.9f}, wall), 1, 0.055);
    EXPECT_NEAR(part_of_still(box(), {.object = 0.9f, .walls = 0.9f}, right), 1, 0.03);
}

// Rays of a ball's places met the sky's bright spot by chance, and what faces away from it by most hardly ever.
TEST(MovingLight, OfABallInTheLightOfABrightSpotReachesTheWallBehind)
{
    const Window above{60, 2, 300, 40};
    EXPECT_NEAR(part_of_still(ball(24), {.object = 0.7f, .walls = 0.01f}, above), 1, 0.08);
}

// Ground and sides had .4 of their light within ten pixels of a box's foot: patches of the ground that the box covers
// in part were dark for its sides, cache points below it lit the ground before it, and its own light came from places
// too far apart.
TEST(MovingLight, AtTheFootOfABoxIsThatOfOneThatStandsStill)
{
    constexpr int k_block = 6;
    struct Case {
        Light light;
        bool close;
        double least, most_off;   // of a block; on average
    };
    for (const auto& [light, close, bound, most_off] :
         {Case{Light::sky, false, 0.78, 0.04}, Case{Light::sky, true, 0.6, 0.04}, Case{Light::bulb, true, 0.6, 0.06}}) {
        const Corner moving = corner(box(), Mobility::may_move, {}, k_standing, light),
                     still = corner(box(), Mobility::fixed, {}, k_standing, light);
        Renderer of_moving(options()), of_still(options());
        const std::vector<double> moves = bounced(of_moving, moving, {}, close),
                                  stands = bounced(of_still, still, {}, close);
        double least = 1, sum = 0;
        int count = 0;
        for (int y = 84; y < 228; y += k_block)
            for (int x = 48; x < 276; x += k_block) {
                const Window block{x, y, x + k_block, y + k_block};
                const double ratio = mean(moves, block) / mean(stands, block);
                least = std::min(least, ratio), sum += ratio;
                ++count;
            }
        std::printf("blocks from %.3f, on average %.3f of the light of what stands still\n", least, sum / count);
        EXPECT_GT(least, bound);
        EXPECT_NEAR(sum / count, 1, most_off);
    }
}

// Half of a ball collapses to a point and comes back. A part of a triangle without area was never placed again.
TEST(MovingLight, OnTrianglesThatHadNoAreaComesBack)
{
    const Triangles mesh = ball(48);
    const Corner corner = gnomon::corner(mesh, Mobility::may_deform);
    std::vector<Vec3> half = mesh.positions;
    for (Vec3& p : half)
        if (p.x > 0.1f) p = {0.1f, 0, 0};
    Renderer kept(options()), fresh(options());
    bounced(kept, corner, half);
    EXPECT_EQ(bounced(kept, corner, mesh.positions), bounced(fresh, corner, mesh.positions));
}

}   // namespace
}   // namespace gnomon
