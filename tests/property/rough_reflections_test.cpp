// SPDX-License-Identifier: Apache-2.0
// LONG: the lobe's rays, their filter and whole frames share their scenes and helpers.
// Reflections by rough metals: rays of their lobes, filtered between pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/math.h"
#include "base/random.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "shading/glossy.h"
#include "shading/lobe_rays.h"
#include "trace/lobe_filter.h"
#include "trace/packed_lobe_ray.h"
#include "two_references.h"

namespace gnomon {
namespace {

MeshId add_ball(SceneBuilder& builder)
{
    constexpr std::uint32_t k_rings = 48, k_sides = 96;
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t y = 0; y <= k_rings; ++y)
        for (std::uint32_t x = 0; x < k_sides; ++x) {
            const double v = k_pi * y / k_rings, u = 2 * k_pi * x / k_sides;
            positions.push_back({static_cast<float>(std::sin(v) * std::cos(u)), static_cast<float>(std::cos(v)),
                                 static_cast<float>(std::sin(v) * std::sin(u))});
        }
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return y * k_sides + x % k_sides; };
    for (std::uint32_t y = 0; y < k_rings; ++y)
        for (std::uint32_t x = 0; x < k_sides; ++x)
            for (const std::uint32_t i :
                 {at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)})
                indices.push_back(i);
    return builder.mesh({.positions = positions, .indices = indices, .normals = positions});
}

Material metal(float roughness)
{
    return {.base_color = {0.95f, 0.93f, 0.88f}, .metallic = 1, .roughness = roughness};
}

// A ball in a box from -1 to 1 with coloured walls, open in front, under a spot light and a small emissive square. The
// ball fills the image.
Scene ball_in_a_box(const Material& material, double height = 0.92)
{
    SceneBuilder builder;
    const MeshId cube = builder.mesh(test::cube(0.5f).mesh()), square = builder.mesh(test::square(0.2f).mesh());
    const auto wall = [&](const Vec3& color, const Vec3& at, const Vec3& size) {
        builder.instance(cube, builder.material({.base_color = color, .roughness = 1, .ior = 1}),
                         Transform::translation(at.x, at.y, at.z) * Transform::scaling(size.x, size.y, size.z));
    };
    const Vec3 white{0.75f, 0.75f, 0.75f};
    wall(white, {0, -1.05f, 0}, {2, 0.1f, 2});
    wall(white, {0, 1.05f, 0}, {2, 0.1f, 2});
    wall(white, {0, 0, -1.05f}, {2.2f, 2.2f, 0.1f});
    wall({0.75f, 0.1f, 0.1f}, {-1.05f, 0, 0}, {0.1f, 2.2f, 2});
    wall({0.1f, 0.75f, 0.1f}, {1.05f, 0, 0}, {0.1f, 2.2f, 2});
    builder.instance(square, builder.material({.base_color = {0, 0, 0}, .emissive = {6, 6, 6}}),
                     Transform::translation(0, 0.2, -0.99));
    builder.instance(add_ball(builder), builder.material(material),
                     Transform::translation(0, -0.5, 0.1) * Transform::scaling(0.5, 0.5, 0.5));
    builder.light({.type = LightType::spot, .color = {8, 8, 8}, .outer_angle = 0.7f},
                  Transform::look_at({0.6, 0.8, 0.9}, {-0.5, -0.2, -0.2}));
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 3.6}, {0, -0.5, 0.1});
    camera.vertical_fov = 2 * std::atan(0.5 * height / 3.5);
    builder.camera(camera);
    return builder.finish();
}

RenderOptions options_of(int size)
{
    RenderOptions options;
    options.size = {size, size};
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

std::vector<float> rendered(const Scene& scene, const RenderOptions& options)
{
    const Frame frame = Renderer(options).render(scene, 1);
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

std::vector<float> reference(const Scene& scene, int size, int paths, std::uint64_t seed, int bounces = 32)
{
    RenderOptions options = options_of(size);
    options.reference = ReferenceLightOptions{.spp = paths, .bounces = bounces, .seed = seed};
    return rendered(scene, options);
}

constexpr int k_row = 200, k_column = 100;   // pixels

// Two balls side by side, and a window a hundred times as bright as the rest.
Scene balls(float roughness)
{
    SceneBuilder builder;
    const MeshId ball = add_ball(builder);
    const MaterialId material = builder.material(metal(roughness));
    for (const double x : {-0.5, 0.5})
        builder.instance(ball, material, Transform::translation(x, 0, 0) * Transform::scaling(0.45, 0.45, 0.45));
    constexpr int k_columns = 256, k_rows = 128;
    std::vector<float> pixels(3 * k_columns * k_rows, 0.05f);
    for (int y = 20; y < 50; ++y)
        for (int x = 20; x < 90; ++x) std::fill_n(pixels.begin() + 3 * (y * k_columns + x), 3, 5.0f);
    builder.environment({.width = k_columns, .height = k_rows, .pixels = pixels});
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
    camera.vertical_fov = 2 * std::atan(0.5 / 4);
    builder.camera(camera);
    return builder.finish();
}

std::vector<float> greens(const Scene& scene, const RenderOptions& options)
{
    const std::vector<float> values = rendered(scene, options);
    std::vector<float> greens;
    for (std::size_t i = 1; i < values.size(); i += 3) greens.push_back(values[i]);
    return greens;
}

// Pixels more than twice as bright as seven of the eight around them.
int dots_of(const std::vector<float>& image)
{
    const auto at = [&](int x, int y) { return image[static_cast<std::size_t>(y * k_row + x)]; };
    int dots = 0;
    for (int y = 1; y + 1 < k_column; ++y)
        for (int x = 1; x + 1 < k_row; ++x) {
            std::array<float, 9> around{};
            for (int k = 0; k < 9; ++k) around[static_cast<std::size_t>(k)] = at(x + k % 3 - 1, y + k / 3 - 1);
            std::sort(around.begin(), around.end());
            dots += at(x, y) == around[8] && around[8] > 2 * around[7] ? 1 : 0;
        }
    return dots;
}

// Single rays of the lobe showed the window, and neighbours shared none of what they met: 7 to 15 dots.
TEST(RoughReflections, SmoothMetalsHaveNoDotsBesideABrightWindow)
{
    for (const float roughness : {0.06f, 0.1f, 0.14f, 0.2f}) {
        const Scene scene = balls(roughness);
        RenderOptions options;
        options.size = {k_row, k_column};
        const std::vector<float> image = greens(scene, options);
        options.reference = ReferenceLightOptions{.spp = 1024};
        const std::vector<float> reference = greens(scene, options);
        double difference = 0, mean = 0;
        for (std::size_t i = 0; i < image.size(); ++i) {
            const auto shown = [](float x) { return static_cast<double>(x / (1 + x)); };
            difference += (shown(image[i]) - shown(reference[i])) * (shown(image[i]) - shown(reference[i]));
            mean += shown(reference[i]);
        }
        const auto count = static_cast<double>(image.size());
        const double rmse = std::sqrt(difference / count) / (mean / count);
        std::printf("roughness %.2f: %d dots, of the reference %d; nRMSE as shown %.3f\n",
                    static_cast<double>(roughness), dots_of(image), dots_of(reference), rmse);
        EXPECT_LE(dots_of(image), 3) << roughness;
        EXPECT_LE(rmse, 0.12) << roughness;
    }
}

TEST(RoughReflections, AMetalBallInABoxIsThatOfTheReference)
{
    constexpr int k_size = 40, k_paths = 256;
    for (int i = 0; i <= 10; ++i) {
        const Scene scene = ball_in_a_box(metal(0.1f * static_cast<float>(i)));
        const std::vector<float> a = reference(scene, k_size, k_paths, 1), b = reference(scene, k_size, k_paths, 2);
        const test::ErrorOfImage error = test::error_of(rendered(scene, options_of(k_size)), a, b);
        RecordProperty("nrmse_" + std::to_string(i), std::to_string(error.nrmse));
        EXPECT_LE(error.nrmse, i == 0 || i >= 8 ? 0.07 : 0.045) << "roughness " << 0.1f * static_cast<float>(i);
        EXPECT_NEAR(error.energy, 1, 0.015) << "roughness " << 0.1f * static_cast<float>(i);
    }
}

// What a small ball shows is lit by cache points that are close enough for the room around.
TEST(RoughReflections, BouncedLightInAMetalBallIsThatOfTheReference)
{
    constexpr int k_size = 40, k_paths = 128;
    const auto without = [](std::vector<float> all, const std::vector<float>& direct) {
        for (std::size_t i = 0; i < all.size(); ++i) all[i] -= direct[i];
        return all;
    };
    for (const float roughness : {0.0f, 0.3f}) {
        const Scene scene = ball_in_a_box(metal(roughness));
        const auto bounced = [&](std::uint64_t seed) {
            return without(reference(scene, k_size, k_paths, seed), reference(scene, k_size, k_paths, seed, 0));
        };
        RenderOptions direct = options_of(k_size);
        direct.indirect = Indirect::off;
        const test::ErrorOfImage error = test::error_of(
            without(rendered(scene, options_of(k_size)), rendered(scene, direct)), bounced(1), bounced(2));
        RecordProperty("nrmse_" + std::to_string(roughness), std::to_string(error.nrmse));
        EXPECT_LE(error.nrmse, 0.2) << roughness;
        EXPECT_NEAR(error.energy, 1, 0.04) << roughness;
    }
}

// The comparison above notices a wrong lobe.
TEST(RoughReflections, AnotherRoughnessIsNotThatOfTheReference)
{
    constexpr int k_size = 40;
    const Scene right = ball_in_a_box(metal(0.6f)), wrong = ball_in_a_box(metal(0.3f));
    const std::vector<float> a = reference(right, k_size, 64, 1), b = reference(right, k_size, 64, 2);
    EXPECT_GT(test::error_of(rendered(wrong, options_of(k_size)), a, b).nrmse, 0.25);
}

// A mirror ray shows a smooth metal, and rays of its lobe a rough one.
TEST(RoughReflections, NoSeamBetweenRoughnesses)
{
    constexpr int k_size = 40;
    for (const float roughness : {0.05f, 0.12f, 0.15f, 0.45f}) {
        const std::vector<float> below = rendered(ball_in_a_box(metal(roughness - 0.001f)), options_of(k_size)),
                                 above = rendered(ball_in_a_box(metal(roughness + 0.001f)), options_of(k_size));
        double difference = 0, all = 0;
        for (std::size_t i = 0; i < below.size(); ++i) {
            // Highlights of the spot light differ more: their peak goes with the fourth power of the roughness.
            const double x = std::min(below[i], 1.0f), y = std::min(above[i], 1.0f);
            difference += std::abs(x - y), all += x;
        }
        EXPECT_LE(difference / all, 0.02) << roughness;
    }
}

TEST(RoughReflections, WhiteMetalVanishesAtEveryRoughness)
{
    for (const float roughness : {0.0f, 0.04f, 0.06f, 0.1f, 0.2f, 0.3f, 0.4f, 0.7f, 1.0f}) {
        SceneBuilder builder;
        builder.instance(add_ball(builder),
                         builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness}));
        builder.background({1, 1, 1});
        Camera camera;
        camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
        camera.vertical_fov = 0.6;
        builder.camera(camera);
        const Scene scene = builder.finish();
        const bool all = roughness == 0.1f || roughness == 0.4f || roughness == 1;
        for (const int samples : {1, 4, 16, 64, k_adaptive_samples}) {
            if (samples != 1 && !all) continue;
            RenderOptions options = options_of(24);
            options.samples = samples, options.filter = PixelFilter::box;
            for (const float value : rendered(scene, options))
                EXPECT_NEAR(value, 1, 0.002f) << roughness << ' ' << samples;
        }
    }
}

// A filter that reaches beyond the pixel takes the light of lobes along, so that the ball's edge does not show.
TEST(RoughReflections, WhiteMetalVanishesUnderEveryPixelFilter)
{
    for (const PixelFilter filter : {PixelFilter::box, PixelFilter::gaussian, PixelFilter::blackman_harris})
        for (const int samples : {1, 16, k_adaptive_samples}) {
            SceneBuilder builder;
            builder.instance(add_ball(builder),
                             builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0.4f}));
            builder.background({1, 1, 1});
            Camera camera;
            camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
            camera.vertical_fov = 0.6;
            builder.camera(camera);
            RenderOptions options = options_of(48);
            options.samples = samples, options.filter = filter, options.exposure = 0;
            int different = 0;
            for (const float value : rendered(builder.finish(), options)) different += std::abs(value - 1) > 0.01f;
            EXPECT_EQ(different, 0) << samples << ' ' << static_cast<int>(filter);
        }
}

TEST(RoughReflections, SameBytesForAnyThreadCountAndAWarmCache)
{
    const Scene scene = ball_in_a_box(metal(0.3f), 1.6);
    for (const int samples : {1, 4}) {
        RenderOptions options = options_of(72);
        options.samples = samples, options.threads = 1;
        const std::vector<float> one = rendered(scene, options);
        options.threads = 3;
        Renderer renderer(options);
        for (int i = 0; i < 2; ++i) {
            const Frame frame = renderer.render(scene, 1);
            EXPECT_TRUE(std::ranges::equal(frame.layers.front().values(), one)) << samples << ' ' << i;
        }
    }
}

// The light of a smooth surface under even light steps nowhere: neither rays nor their filter show.
TEST(RoughReflections, NoNoiseOnAFloorThatReflectsAWall)
{
    SceneBuilder builder;
    const MeshId square = builder.mesh(test::square(2).mesh());
    builder.instance(square, builder.material({.base_color = {0.9f, 0.9f, 0.9f}, .metallic = 1, .roughness = 0.5f}),
                     Transform::rotation({1, 0, 0}, -k_pi / 2));
    builder.instance(square, builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1}),
                     Transform::translation(0, 2, -2));
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, Transform::look_at({0, 1, 3}, {0, 0.8, 0}));
    Camera camera;
    camera.transform = Transform::look_at({0, 1, 1.8}, {0, 0, -0.9});
    camera.vertical_fov = 0.5;
    builder.camera(camera);
    constexpr std::size_t k_size = 96;
    const std::vector<float> image = rendered(builder.finish(), options_of(k_size));
    double worst = 0, mean = 0;
    for (const float value : image) mean += static_cast<double>(value) / static_cast<double>(image.size());
    ASSERT_GT(mean, 0.05);
    for (std::size_t y = 40; y + 1 < k_size; ++y)   // the wall is above

        for (std::size_t x = 1; x + 1 < k_size; ++x) {
            const auto at = [&](std::size_t px, std::size_t py) { return image[3 * (py * k_size + px)]; };
            const double around = 0.25 * (at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1));
            worst = std::max(worst, std::abs(at(x, y) - around));
        }
    EXPECT_LE(worst, mean / 100);
    RecordProperty("worst", std::to_string(worst / mean));
}

// Of many samples, 16 of each pixel cast a ray, and what these bring serves all of them: also at the metal's edges,
// where few samples meet it.
TEST(RoughReflections, ManySamplesOfAPixelHaveAsManyRaysAsAFewDo)
{
    constexpr int k_size = 48;
    SceneBuilder builder;
    builder.instance(add_ball(builder), builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0.4f}));
    builder.background({1, 1, 1});
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
    camera.vertical_fov = 0.6;
    builder.camera(camera);
    const Scene scene = builder.finish();
    std::uint64_t rays = 0;
    for (const int samples : {7, 16, 64}) {
        RenderOptions options = options_of(k_size);
        options.samples = samples;
        const Frame frame = Renderer(options).render(scene, 1);
        for (const float value : frame.layers.front().values()) EXPECT_NEAR(value, 1, 0.02f) << samples;
        EXPECT_LE(frame.counters.reflection_rays, 16U * k_size * k_size) << samples;
        EXPECT_GE(frame.counters.reflection_rays, rays) << samples;   // none before
        rays = frame.counters.reflection_rays;
    }
}

shading::SurfacePoint surface(float roughness, float cosine)
{
    shading::SurfacePoint s;
    s.geometric_normal = s.normal = s.smooth_normal = {0, 0, 1};
    s.to_viewer = {std::sqrt(1 - cosine * cosine), 0, cosine};
    s.specular = {0.9f, 0.6f, 0.3f};
    s.roughness = roughness;
    return s;
}

// Radiance by direction: half of the sky is bright.
float bright_half(const glm::vec3& direction)
{
    return direction.y > 0.1f ? 1.0f : 0.2f;
}

TEST(LobeRays, TheirMeanIsTheLobesIntegral)
{
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const float cosine : {0.2f, 0.9f}) {
            const shading::SurfacePoint s = surface(roughness, cosine);
            // Sum the lobe over a fine pattern of directions.
            constexpr int k_side = 1200;
            glm::dvec3 integral(0);
            for (int i = 0; i < k_side; ++i)
                for (int j = 0; j < k_side; ++j) {
                    const double z = (i + 0.5) / k_side, phi = 2 * k_pi * (j + 0.5) / k_side, r = std::sqrt(1 - z * z);
                    const glm::vec3 direction(r * std::cos(phi), r * std::sin(phi), z);
                    integral += glm::dvec3(shading::reflect_glossy(s, direction) * bright_half(direction));
                }
            integral *= 2 * k_pi / k_side / k_side;
            std::array<shading::LobeRay, 4096> rays;
            const std::size_t count = shading::lobe_rays(s, 4096, glm::uvec2(0), false, rays);
            ASSERT_GT(count, rays.size() / 4);
            glm::dvec3 sum(0), weight(0);
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_GT(rays[k].direction.z, 0);
                sum += glm::dvec3(rays[k].weight * bright_half(rays[k].direction));
                weight += glm::dvec3(rays[k].weight);
            }
            sum *= glm::dvec3(shading::glossy_albedo(s));
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(weight[c], 1, 1e-4);
                EXPECT_NEAR(sum[c], integral[c], 0.03 * integral[c]) << roughness << ' ' << cosine;
            }
        }
}

// One ray of each of 64 pixels: beside those of the others, it counts by its weight.
TEST(LobeRays, SingleRaysOfManyPixelsMakeTheLobesIntegral)
{
    for (const float roughness : {0.3f, 0.6f, 1.0f}) {
        const shading::SurfacePoint s = surface(roughness, 0.6f);
        std::array<shading::LobeRay, 4096> rays;
        const std::size_t count = shading::lobe_rays(s, 4096, glm::uvec2(0), false, rays);
        double light = 0;
        for (std::size_t k = 0; k < count; ++k)
            light += static_cast<double>((rays[k].weight * bright_half(rays[k].direction)).x);
        double brought = 0, counted = 0, unweighted = 0;
        for (std::uint32_t block = 0; block < 1024; ++block) {
            std::array<shading::LobeRay, 1> one;
            float counts = 0;
            if (shading::lobe_rays(s, block, glm::uvec2(0), false, one, &counts) == 0) continue;
            brought += static_cast<double>(counts * bright_half(one[0].direction)), counted += counts;
            unweighted += bright_half(one[0].direction);
        }
        EXPECT_NEAR(counted, 1024, 0.02 * 1024) << roughness;
        EXPECT_NEAR(brought / counted, light, 0.01 * light) << roughness;
        RecordProperty("unweighted_" + std::to_string(roughness), std::to_string(unweighted / 1024 / light));
    }
}

// The error of a pattern that turns with the normal around where a surface faces the viewer shows as a star there.
TEST(LobeRays, AlikeAllAroundWhereASurfaceFacesTheViewer)
{
    for (const glm::vec3& view : {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0.64f, 0.48f), glm::vec3(-0.8f, 0.6f, 0),
                                  glm::vec3(0, 1, 0), glm::vec3(0, -0.6f, -0.8f)}) {
        std::array<shading::LobeRay, 16> facing, around;
        shading::SurfacePoint s = surface(0.3f, 1);
        glm::vec3 x, y;
        make_basis(view, x, y);
        s.to_viewer = view;
        for (int i = -1; i < 12; ++i) {
            const double angle = 2 * k_pi * i / 12;
            s.normal = glm::normalize(
                view + 0.01f * (static_cast<float>(std::cos(angle)) * x + static_cast<float>(std::sin(angle)) * y));
            s.geometric_normal = s.smooth_normal = s.normal;
            const std::size_t count = shading::lobe_rays(s, 16, glm::uvec2(0), false, i < 0 ? facing : around);
            ASSERT_EQ(count, 16u);
            if (i < 0) continue;
            for (std::size_t k = 0; k < count; ++k)
                EXPECT_LT(glm::length(around[k].direction - facing[k].direction), 0.08f) << i << ' ' << k;
        }
    }
}

TEST(LobeRays, NeighbouringPixelsHaveBlocksOfTheirOwn)
{
    std::array<bool, 64> met{};
    for (int y = 5; y < 13; ++y)
        for (int x = 3; x < 11; ++x) {
            const std::uint32_t block = shading::lobe_block(x, y);
            ASSERT_LT(block, met.size());
            EXPECT_FALSE(met[block]);
            met[block] = true;
        }
}

TEST(LobeRays, OnlyReflectiveRoughSurfacesHaveThem)
{
    shading::SurfacePoint s = surface(0.4f, 0.8f);
    EXPECT_EQ(shading::lobe_share(s), 1);
    s.specular = glm::vec3(0.04f);
    EXPECT_EQ(shading::lobe_share(s), 0);
    s = surface(0.01f, 0.8f);
    EXPECT_EQ(shading::lobe_share(s), 0);
}

// Gives each pixel that has none a ray along its lobe's axis, which brings the pixel's light.
void add_rays(trace::LobeImage& image, int width, int height, int side = 32)
{
    for (int top = 0; top < height; top += side)
        for (int left = 0; left < width; left += side) {
            std::vector<std::uint32_t> pixels;
            std::vector<trace::LobeRay> rays;
            for (int y = top; y < std::min(top + side, height); ++y)
                for (int x = left; x < std::min(left + side, width); ++x) {
                    trace::LobePixel& pixel = image.at(x, y);
                    pixels.push_back(static_cast<std::uint32_t>((y - top) * side + x - left));
                    trace::LobeRay& ray = rays.emplace_back();
                    ray.direction = pixel.axis, ray.weight = pixel.weight;
                    ray.light = std::exchange(pixel.light, glm::vec3(0));
                }
            image.set_rays(left, top, pixels, rays);
        }
}

// Sets a pixel's lobe about an axis in which its surface faces the viewer.
void set_axis(trace::LobePixel& pixel, const glm::vec3& axis, float width)
{
    pixel.axis = glm::normalize(axis);
    pixel.set_lobe(pixel.axis, pixel.axis, width, 1);
}

// An image of one plane, on which each pixel found light of its own; its rays are still to be added.
trace::LobeImage plane(int size, float width)
{
    trace::LobeImage image({size, size});
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            trace::LobePixel& pixel = image.at(x, y);
            pixel.weight = glm::vec3(0.5f);
            pixel.light = pixel.weight * static_cast<float>(shading::lobe_block(x, y));
            pixel.position = {0.01f * static_cast<float>(x), 0.01f * static_cast<float>(y), 0};
            set_axis(pixel, {0, 0, 1}, width);
            pixel.footprint = 0.01f;
        }
    return image;
}

TEST(LobeFilter, InterleavedPatternsVanish)
{
    trace::LobeImage image = plane(32, 0.2f);
    add_rays(image, 32, 32);
    for (int y = 8; y < 24; ++y)
        for (int x = 8; x < 24; ++x) EXPECT_NEAR(image.gathered(x, y).x, 0.5f * 31.5f, 1e-3f);
}

// One ray in eight columns meets something bright, from the middle of the image on.
TEST(LobeFilter, EdgesOfTheWindowDoNotShow)
{
    trace::LobeImage image = plane(64, 0.2f);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) image.at(x, y).light = glm::vec3(x >= 32 && x % 8 == 3 ? 8.0f : 0.0f);
    add_rays(image, 64, 64);
    ImageF filtered(64, 64, 3);
    Tasks tasks(1);
    image.add_to(filtered, 1, tasks);
    EXPECT_NEAR(filtered.pixel(16, 32)[0], 0, 1e-6f);
    EXPECT_NEAR(filtered.pixel(48, 32)[0], 1, 1e-3f);
    for (int x = 8; x < 56; ++x) {
        const float step = filtered.pixel(x + 1, 32)[0] - filtered.pixel(x, 32)[0];
        EXPECT_LT(std::abs(step), 0.15f) << x;   // .5 if the window slid once
    }
}

TEST(LobeFilter, TilesAreFilteredAsThePixelsByThemselves)
{
    constexpr int k_width = 43, k_height = 26, k_side = 16;   // not a multiple of a tile's side
    Random random(1, 2);
    const auto number = [&] { return random.uniform(0, 1); };
    trace::LobeImage image({k_width, k_height}, k_side);
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) {
            if (x >= 32 && y < 16) continue;   // a tile without a lobe
            trace::LobePixel& pixel = image.at(x, y);
            pixel.weight = number() < 0.1f ? glm::vec3(0) : glm::vec3(number(), number(), number());
            // On the left, the lobes of windows are nearly the same.
            const float bent = x < 12 ? 0.02f : x < 20 ? 0.14f : 1.0f;
            pixel.position = 0.01f * glm::vec3(x, y, bent * number());
            set_axis(pixel, {bent * number(), bent * number(), 3},
                     number() < 0.1f ? 0 : 0.1f + (x < 20 ? 0.3f : number()));
            pixel.to_viewer = glm::normalize(glm::vec3(bent * number(), bent * number(), 3));
            pixel.footprint = 0.01f, pixel.rays = number();
            pixel.open = pixel.weight * number();
        }
    for (int top = 0; top < k_height; top += k_side)
        for (int left = 0; left < k_width; left += k_side) {
            if (left >= 32 && top < 16) continue;
            std::vector<std::uint32_t> pixels;
            std::vector<trace::LobeRay> rays;
            for (int y = 0; y < std::min(k_side, k_height - top); ++y)
                for (int x = 0; x < std::min(k_side, k_width - left); ++x)
                    for (int k = static_cast<int>(4 * number()); k > 0; --k) {
                        if (image.at(left + x, top + y).weight == glm::vec3(0)) break;
                        pixels.push_back(static_cast<std::uint32_t>(y * k_side + x));
                        trace::LobeRay& ray = rays.emplace_back();
                        ray.direction = glm::normalize(glm::vec3(number() - 0.5f, number() - 0.5f, 1));
                        if (number() > 0.2f) {
                            ray.nearness = (left + x < 20 ? 0.3f : 10.0f) * number();
                            ray.normal = glm::normalize(glm::vec3(number() - 0.5f, number() - 0.5f, -1));
                        }
                        ray.light = glm::vec3(number(), number(), number());
                        ray.weight = glm::vec3(number(), number(), number());
                    }
            image.set_rays(left, top, pixels, rays);
        }
    std::vector<glm::vec3> gathered;
    std::array<int, 3> by_evenness{};   // pixels for whose rays no lobes around are the same, some are, all are
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) gathered.push_back(image.gathered(x, y));
    ImageF color(k_width, k_height, 3);
    Tasks tasks(2);
    image.add_to(color, 1, tasks);
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) {
            if (x >= 32 && y < 16) continue;
            const glm::vec3 own = gathered[static_cast<std::size_t>(y * k_width + x)], mean = image.mean(x, y);
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(std::as_const(image).at(x, y).gathered[c], own[c]) << x << ' ' << y;
                ASSERT_EQ(color.pixel(x, y)[c], mean[c]) << x << ' ' << y;
            }
            const trace::LobePixel& pixel = std::as_const(image).at(x, y);
            if (pixel.weight != glm::vec3(0) && pixel.width > 0)
                ++by_evenness[pixel.even == 0 ? 0 : pixel.uneven > 0 ? 1 : 2];
        }
    for (const int pixels : by_evenness) EXPECT_GT(pixels, 20);
}

// The part of all rays that leave the scene is shared, and each pixel shows its own mean of the image there.
TEST(LobeFilter, OpenPartsAreSharedAndNotWhatIsSeenThere)
{
    constexpr int k_size = 32;
    for (const float bend : {0.0f, 0.1f}) {   // of the surface
        trace::LobeImage image = plane(k_size, 0.2f);
        std::vector<std::uint32_t> pixels;
        std::vector<trace::LobeRay> rays;
        for (int y = 0; y < k_size; ++y)
            for (int x = 0; x < k_size; ++x) {
                trace::LobePixel& pixel = image.at(x, y);
                pixel.light = glm::vec3(0), pixel.open = pixel.weight * static_cast<float>(x);
                set_axis(pixel, {bend * static_cast<float>(x) / 4, 0, 1}, 0.2f);
                pixels.push_back(static_cast<std::uint32_t>(y * k_size + x));
                // A quarter of the rays end close by, at something dark.
                trace::LobeRay& ray = rays.emplace_back();
                ray.direction = pixel.axis, ray.weight = pixel.weight;
                if (x % 2 == 0 && y % 2 == 0) ray.nearness = 0.1f, ray.normal = -pixel.axis;
            }
        image.set_rays(0, 0, pixels, rays);
        for (int y = 8; y < 24; ++y)
            for (int x = 8; x < 24; ++x)
                EXPECT_NEAR(image.gathered(x, y).x, 0.5f * 0.75f * static_cast<float>(x),
                            (bend == 0 ? 1e-3f : 0.1f) * static_cast<float>(x))
                    << x << ' ' << y;
    }
}

TEST(LobeFilter, KeptRaysAreThoseThatWereCast)
{
    Random random(3, 4);
    const auto number = [&] { return random.uniform(-1, 1); };
    float farthest = 0, worst = 0;
    for (int i = 0; i < 100000; ++i) {
        const glm::vec3 direction = glm::normalize(glm::vec3(number(), number(), number()));
        const glm::vec3 found = trace::unpack_direction(trace::pack_direction(direction));
        farthest = std::max(farthest, glm::length(found - direction));
        EXPECT_NEAR(glm::length(found), 1, 1e-6f);
        const glm::vec3 color = std::exp(60 * number()) * glm::abs(glm::vec3(number(), number(), number()));
        const glm::vec3 apart = glm::abs(trace::unpack_color(trace::pack_color(color)) - color);
        worst = std::max(worst, std::max({apart.x, apart.y, apart.z}) / std::max({color.x, color.y, color.z}));
    }
    EXPECT_LT(farthest, 5e-5f);
    EXPECT_LT(worst, 1.3e-4f);
    for (const glm::vec3& axis : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)})
        for (const float sign : {-1.0f, 1.0f})
            EXPECT_EQ(trace::unpack_direction(trace::pack_direction(sign * axis)), sign * axis);
    for (const float value : {0.0f, 1.0f, 0x1p-90f, 0x1p100f})
        EXPECT_EQ(trace::unpack_color(trace::pack_color({value, 0, value})), glm::vec3(value, 0, value));
    for (const float value : {1e-20f, 1e30f, 3e38f, 0x1.fffffep0f})
        EXPECT_NEAR(trace::unpack_color(trace::pack_color({0, value, 0})).y / value, 1, 1.3e-4f) << value;
    EXPECT_EQ(trace::unpack_color(trace::pack_color({-1, -1, -1})), glm::vec3(0));
}

// A pixel of whose samples some have no rays has the light of those that do.
TEST(LobeFilter, SamplesWithoutRaysGetTheLightOfOthers)
{
    trace::LobeImage image({1, 1}, 1);
    image.at(0, 0).weight = {4, 2, 1};
    trace::LobeRay ray;
    ray.direction = {0, 0, 1}, ray.weight = {1, 0.5f, 0.25f}, ray.light = {3, 2, 1};
    image.set_rays(0, 0, std::vector<std::uint32_t>{0}, std::vector{ray});
    EXPECT_EQ(image.gathered(0, 0), glm::vec3(12, 8, 4));
    EXPECT_EQ(image.bytes_of_rays(), sizeof(trace::PackedLobeRay));
}

// Pixels that see a bright disk on a wall by rays of their lobes, and what each would find by 4,096 rays.
struct DiskImage {
    static constexpr int k_size = 16;
    trace::LobeImage image{{k_size, k_size}, k_size};
    std::vector<float> truth;

    /// @param turn      of the normal from pixel to pixel
    /// @param distance  of the wall
    /// @param radius    of the disk
    DiskImage(float turn, float distance, float radius)
    {
        constexpr int k_rays = 16;
        constexpr float k_step = 0.02f;
        const auto radiance = [&](const glm::vec3& from, const glm::vec3& direction) {
            const glm::vec3 place = from + direction * ((distance - from.z) / direction.z);
            return glm::length(glm::vec2(place.x - 0.67f * radius, place.y)) < radius ? 1.0f : 0.0f;
        };
        std::vector<std::uint32_t> pixels;
        std::vector<trace::LobeRay> rays;
        std::array<shading::LobeRay, 4096> many;
        for (int y = 0; y < k_size; ++y)
            for (int x = 0; x < k_size; ++x) {
                const auto right = static_cast<float>(x - 8), down = static_cast<float>(y - 8);
                shading::SurfacePoint s = surface(0.45f, 1);
                s.specular = glm::vec3(1), s.to_viewer = {0, 0, 1};
                s.normal = glm::normalize(glm::vec3(turn * right, turn * down, 1));
                s.geometric_normal = s.smooth_normal = s.normal;
                trace::LobePixel& pixel = image.at(x, y);
                pixel.weight = glm::vec3(1), pixel.position = k_step * glm::vec3(right, down, 0);
                pixel.axis = 2 * glm::dot(s.normal, s.to_viewer) * s.normal - s.to_viewer, pixel.footprint = k_step;
                pixel.set_lobe(s.normal, s.to_viewer, shading::lobe_width(s.roughness),
                               shading::glossy_density(s, pixel.axis));
                const auto find = [&](std::uint32_t first, std::span<shading::LobeRay> found) {
                    float sum = 0;
                    const std::size_t count = shading::lobe_rays(s, first, glm::uvec2(0), false, found);
                    for (std::size_t k = 0; k < count; ++k)
                        sum += found[k].weight.x * radiance(pixel.position, found[k].direction);
                    return std::pair(sum, count);
                };
                truth.push_back(find(4096, many).first);
                const std::size_t count =
                    find(shading::lobe_block(x, y) * k_rays, std::span(many).first(k_rays)).second;
                for (std::size_t k = 0; k < count; ++k) {
                    const glm::vec3 direction = many[k].direction;
                    trace::LobeRay& ray = rays.emplace_back();
                    pixels.push_back(static_cast<std::uint32_t>(y * k_size + x));
                    ray.direction = direction, ray.nearness = direction.z / distance;
                    ray.normal = {0, 0, -1};
                    ray.weight = many[k].weight, ray.light = ray.weight * radiance(pixel.position, direction);
                }
            }
        image.set_rays(0, 0, pixels, rays);
    }
};

// What a pixel's neighbours have found tells it what it would find itself, although their lobes point elsewhere and
// start elsewhere: here the pixels differ by more than half of their light.
TEST(LobeFilter, RaysOfNeighboursCountByThePixelsOwnLobe)
{
    const DiskImage disk(0.05f, 0.5f, 0.15f);
    double error = 0, all = 0, spread = 0;
    for (int y = 4; y < 12; ++y)
        for (int x = 4; x < 12; ++x) {
            const float right = disk.truth[static_cast<std::size_t>(y * disk.k_size + x)];
            error += std::abs(disk.image.gathered(x, y).x - right), all += right;
            spread += std::abs(right - disk.truth[static_cast<std::size_t>(8 * disk.k_size + 8)]);
        }
    EXPECT_GT(spread / all, 0.2);
    EXPECT_LE(error / all, 0.15);
    RecordProperty("error", std::to_string(error / all));
}

// Where the lobes around are nearly the same, rays count alike, as they would by their densities.
TEST(LobeFilter, RaysOfFlatPartsCountAlike)
{
    trace::LobeFilterOptions by_densities;
    by_densities.even_alike = 0, by_densities.even_unlike = 1e-4f;
    for (const float turn : {0.0005f, 0.0015f, 0.0025f}) {
        DiskImage disk(turn, 8, 1.2f);
        float worst = 0, error = 0, error_by_densities = 0, all = 0, even = 0;
        for (int y = 4; y < 12; ++y)
            for (int x = 4; x < 12; ++x) {
                const float right = disk.truth[static_cast<std::size_t>(y * disk.k_size + x)];
                const float exact = disk.image.gathered(x, y, by_densities).x, found = disk.image.gathered(x, y).x;
                worst = std::max(worst, std::abs(found / exact - 1)), all += right;
                error += std::abs(found - right), error_by_densities += std::abs(exact - right);
            }
        ImageF color(disk.k_size, disk.k_size, 3);
        Tasks tasks(1);
        disk.image.add_to(color, 1, tasks);
        for (int y = 4; y < 12; ++y)
            for (int x = 4; x < 12; ++x) even += std::as_const(disk.image).at(x, y).even / 64;
        EXPECT_GT(even, 0.1f) << turn;
        EXPECT_LE(worst, 0.015f) << turn;
        EXPECT_LE(error, error_by_densities) << turn;
        RecordProperty("even_" + std::to_string(turn), std::to_string(even));
        RecordProperty("worst_" + std::to_string(turn), std::to_string(worst));
        RecordProperty("error_" + std::to_string(turn),
                       std::to_string(error / all) + " by densities " + std::to_string(error_by_densities / all));
    }
}

TEST(LobeFilter, PixelsWithoutNeighboursAlikeCastMoreRays)
{
    const trace::LobeFilterOptions options;
    const trace::LobeImage wide = plane(32, 0.2f);
    EXPECT_EQ(wide.rays_wanted(16, 16, 0, 0, 32, 32), options.least_rays);
    EXPECT_EQ(wide.rays_wanted(0, 0, 0, 0, 32, 32), options.least_rays);   // at a corner: as within
    EXPECT_EQ(wide.rays_wanted(16, 16, 16, 16, 1, 1), options.rays);       // nothing is known of its neighbours
    // On a ball, axes turn from pixel to pixel.
    trace::LobeImage ball = plane(32, 0.2f);
    float last = options.least_rays;
    for (const float turn : {0.02f, 0.5f, 1.0f}) {
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x)
                ball.at(x, y).axis =
                    glm::normalize(glm::vec3(turn * static_cast<float>(x - 16), turn * static_cast<float>(y - 16), 1));
        const float wanted = ball.rays_wanted(16, 16, 0, 0, 32, 32);
        if (turn < 1)
            EXPECT_GT(wanted, last) << turn;
        else
            EXPECT_EQ(wanted, options.own_rays);   // a lobe that is narrow beside a pixel
        last = wanted;
    }
}

// A pixel whose rays brought nothing says less than its neighbours.
TEST(LobeFilter, NeighboursCountByTheWeightsOfTheirRays)
{
    trace::LobeImage image = plane(32, 0.2f);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            trace::LobePixel& pixel = image.at(x, y);
            pixel.light = pixel.weight * (x % 2 == 0 ? 1.0f : 3.0f);
            pixel.rays = x % 2 == 0 ? 1.0f : 0.25f;
        }
    add_rays(image, 32, 32);
    EXPECT_NEAR(image.gathered(16, 16).x, 0.5f * (1 + 3 * 0.25f) / 1.25f, 1e-5f);
}

TEST(LobeFilter, KeepsApartWhatReflectsOtherSurroundings)
{
    const auto halves = [](float step) {
        trace::LobeImage image = plane(32, 0.05f);
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                trace::LobePixel& pixel = image.at(x, y);
                pixel.light = pixel.weight * (x < 16 ? 1.0f : 3.0f);
                pixel.position.x *= step;
                if (x >= 16) set_axis(pixel, {0.5f, 0, 1}, 0.05f);
            }
        add_rays(image, 32, 32);
        return image;
    };
    const trace::LobeImage image = halves(1);
    EXPECT_NEAR(image.gathered(15, 16).x, 0.5f, 1e-5f);
    EXPECT_NEAR(image.gathered(16, 16).x, 1.5f, 1e-5f);
    // So does what lies farther away than some pixels.
    const trace::LobeImage apart = halves(1000);
    EXPECT_EQ(apart.gathered(14, 16).x, apart.at(14, 16).light.x);
}

}   // namespace
}   // namespace gnomon
