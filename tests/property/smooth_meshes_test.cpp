// SPDX-License-Identifier: Apache-2.0
// A smooth mesh of few triangles is lit as the smooth surface that its vertex normals describe: no triangle shows where
// its light ends.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/math.h"
#include "base/tasks.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "image/flip.h"

namespace gnomon {
namespace {

constexpr float k_albedo = 0.5f;
constexpr int k_side = 160;
constexpr float k_radius = 0.78f;   // of the ball in the image, in half widths

struct Ball {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    bool smooth = true;
};

// A ball of 2 segments (rings - 1) triangles. @param radius  negative: it faces inwards
Ball ball(int rings, int segments, float radius = 1)
{
    Ball result;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j <= segments; ++j) {
            const double t = k_pi * i / rings, p = 2 * k_pi * j / segments;
            result.positions.push_back({static_cast<float>(radius * std::sin(t) * std::cos(p)),
                                        static_cast<float>(radius * std::cos(t)),
                                        static_cast<float>(radius * std::sin(t) * std::sin(p))});
        }
    const auto row = static_cast<std::uint32_t>(segments + 1);
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rings); ++i)
        for (std::uint32_t j = 0; j + 1 < row; ++j) {
            const std::uint32_t a = i * row + j, b = a + 1, c = a + row, d = c + 1;
            if (i > 0) result.indices.insert(result.indices.end(), {a, b, c});
            if (i + 1 < static_cast<std::uint32_t>(rings)) result.indices.insert(result.indices.end(), {b, d, c});
        }
    return result;
}
Ball coarse()
{
    return ball(10, 11);   // 198 triangles
}
Ball fine()
{
    return ball(100, 101);   // 19,998
}

void add(SceneBuilder& builder, const Ball& ball, const InstanceOptions& options = {})
{
    Mesh mesh;
    mesh.positions = ball.positions, mesh.indices = ball.indices;
    if (ball.smooth) mesh.normals = ball.positions;
    builder.instance(builder.mesh(mesh),
                     builder.material({.base_color = {k_albedo, k_albedo, k_albedo}, .roughness = 1, .ior = 1}), {},
                     options);
}

// Shows a ball of radius 1 around the origin from afar.
void add_camera(SceneBuilder& builder)
{
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 40}, {0, 0, 0});
    camera.vertical_fov = 2 * std::atan(1 / (40 * static_cast<double>(k_radius)));
    builder.camera(camera);
}

RenderOptions options()
{
    RenderOptions result;
    result.size = {k_side, k_side};
    result.indirect = Indirect::off;
    result.layers = true;
    return result;
}

bool is_inside(int x, int y, float part = 0.92f)
{
    const float half = 0.5f * k_side, dx = (static_cast<float>(x) + 0.5f - half) / half,
                dy = (static_cast<float>(y) + 0.5f - half) / half;
    return dx * dx + dy * dy < part * part * k_radius * k_radius;
}

using Lights = std::function<void(SceneBuilder&)>;

Frame render(const Ball& ball, const Lights& lights, const RenderOptions& options, const InstanceOptions& moves = {})
{
    SceneBuilder builder;
    add(builder, ball, moves);
    lights(builder);
    add_camera(builder);
    return Renderer(options).render(builder.finish(), 1);
}

const Transform k_sun = Transform::look_at({3, 1, 0.5f}, {0, 0, 0});
void add_sun(SceneBuilder& builder)
{
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, k_sun);
}
void add_square_light(SceneBuilder& builder)
{
    builder.area_light({.width = 1.5f, .height = 1.5f, .radiance = {6, 6, 6}},
                       Transform::look_at({3, 1, 0}, {0, 0, 0}));
}
// A wall that a spot lights; its light comes back to the ball.
void add_lit_wall(SceneBuilder& builder)
{
    builder.instance(builder.mesh(test::square(3).mesh()),
                     builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1}),
                     Transform::look_at({-2.5f, 0, 0}, {-5, 0, 0}));
    builder.light({.type = LightType::spot, .color = {300, 300, 300}, .outer_angle = 0.4f},
                  Transform::look_at({-1.3f, 1.8f, 0}, {-2.5f, 1.2f, 0}));
}
void add_even_sky(SceneBuilder& builder)
{
    const std::vector<float> pixels(8 * 4 * 3, 1.0f);
    builder.environment({.width = 8, .height = 4, .pixels = pixels});
}
// One side brighter than the other.
void add_uneven_sky(SceneBuilder& builder)
{
    std::vector<float> pixels;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) pixels.push_back(x < 20 && y > 6 && y < 14 ? 5.0f : 0.1f);
    builder.environment({.width = 64, .height = 32, .pixels = pixels});
}

// The mean FLIP of two images, with what lies at the silhouettes painted black in both.
double difference(const Frame& a, const Frame& b)
{
    ImageF images[2];
    const Frame* frames[] = {&a, &b};
    for (int i = 0; i < 2; ++i) {
        images[i] = ImageF(k_side, k_side, 3);
        for (int y = 0; y < k_side; ++y)
            for (int x = 0; x < k_side; ++x)
                for (int c = 0; c < 3; ++c)
                    images[i].pixel(x, y)[c] = is_inside(x, y) ? frames[i]->layers.front().value(x, y, c) : 0;
    }
    Tasks tasks(2);
    return image::mean_of(image::flip_ldr(images[0], images[1], tasks));
}

TEST(SmoothMeshes, UnderASunEveryPixelHasTheLightOfItsNormal)
{
    const Frame frame = render(coarse(), add_sun, options());
    const glm::vec3 to_sun = glm::normalize(glm::vec3(3, 1, 0.5f));
    const Layer &color = frame.layers.front(), &normals = *frame.layer("normal");
    int lit = 0, dark = 0;
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            if (!is_inside(x, y)) continue;
            const glm::vec3 n(normals.value(x, y, 0), normals.value(x, y, 1), normals.value(x, y, 2));
            const float cosine = std::max(glm::dot(n, to_sun), 0.0f);
            const float truth = k_albedo / static_cast<float>(k_pi) * 3 * cosine;
            ASSERT_NEAR(color.value(x, y), truth, 3e-4f) << x << ' ' << y;
            ++(cosine > 0 ? lit : dark);
        }
    EXPECT_GT(lit, 1000);
    EXPECT_GT(dark, 1000);
}

TEST(SmoothMeshes, UnderAnEvenSkyEveryPixelIsEquallyBright)
{
    const Frame frame = render(coarse(), add_even_sky, options());
    double sum = 0;
    int count = 0;
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            if (!is_inside(x, y)) continue;
            ASSERT_NEAR(frame.layers.front().value(x, y), k_albedo, 0.012f * k_albedo) << x << ' ' << y;
            sum += static_cast<double>(frame.layers.front().value(x, y)), ++count;
        }
    EXPECT_NEAR(sum / count, static_cast<double>(k_albedo), 0.003);
}

TEST(SmoothMeshes, LookLikeThoseOfManyTriangles)
{
    struct Case {
        const char* name;
        Lights lights;
        Indirect indirect = Indirect::off;
        double sun_size = 0;
    };
    for (const Case& c : {Case{"sun", add_sun}, Case{"sun of 10 degrees", add_sun, Indirect::off, 10},
                          Case{"square light", add_square_light}, Case{"sky", add_uneven_sky},
                          Case{"bounced light", add_lit_wall, Indirect::visible}}) {
        RenderOptions o = options();
        o.indirect = c.indirect, o.sun_size = c.sun_size;
        const Frame many = render(fine(), c.lights, o);
        const double standing = difference(render(coarse(), c.lights, o), many);
        const double moving = difference(render(coarse(), c.lights, o, {.mobility = Mobility::may_move}), many);
        RecordProperty(c.name, std::to_string(standing));
        EXPECT_LT(standing, 0.02) << c.name;
        EXPECT_LT(moving, 0.02) << c.name;
    }
}

// The comparison above finds facets.
TEST(SmoothMeshes, FacetsAreFound)
{
    Ball flat = coarse();
    flat.smooth = false;
    for (const Lights& lights : {Lights(add_sun), Lights(add_square_light), Lights(add_uneven_sky)})
        EXPECT_GT(difference(render(flat, lights, options()), render(fine(), lights, options())), 0.03);
}

// What lies above a smooth surface still hides lights: rays decide, not the normal.
TEST(SmoothMeshes, KeepTheShadowsOfOtherSurfaces)
{
    for (const Lights& lights : {Lights(add_sun), Lights(add_square_light)}) {
        const Frame frame = render(
            coarse(),
            [&](SceneBuilder& builder) {
                lights(builder);
                builder.instance(builder.mesh(test::square(20).mesh()), builder.material({.double_sided = true}),
                                 Transform::look_at({1.5f, 0.5f, 0}, {0, 0, 0}));
            },
            options());
        for (int y = 0; y < k_side; ++y)
            for (int x = 0; x < k_side; ++x) {
                if (!is_inside(x, y, 0.9f)) continue;
                ASSERT_LT(frame.layers.front().value(x, y), 1e-6f) << x << ' ' << y;
            }
    }
}

TEST(SmoothMeshes, ClosedRoomsOfFewTrianglesStayDark)
{
    SceneBuilder builder;
    add(builder, ball(10, 11, -1));
    add_sun(builder);
    add_square_light(builder);
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 0}, {-1, 0.2f, 0});
    camera.vertical_fov = 1.8;
    builder.camera(camera);
    const Frame frame = Renderer(options()).render(builder.finish(), 1);
    for (const float value : frame.layers.front().values()) ASSERT_LT(value, 1e-6f);
}

// The planes of the vertices of long triangles may meet far away, beyond what lights them.
TEST(SmoothMeshes, LongTrianglesAreLitByWhatStandsBeforeThem)
{
    constexpr std::uint32_t k_strips = 20;
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i <= k_strips; ++i)
        for (const float x : {-10.0f, 10.0f}) {
            positions.push_back({x, 0.5f, 0.1f * static_cast<float>(i) - 1});
            normals.push_back({x > 0 ? 0.70711f : -0.70711f, -0.70711f, 0});
        }
    for (std::uint32_t i = 0; i < k_strips; ++i)
        indices.insert(indices.end(), {2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 1, 2 * i + 3, 2 * i + 2});
    Mesh mesh;
    mesh.positions = positions, mesh.normals = normals, mesh.indices = indices;
    SceneBuilder builder;
    const MaterialId white =
        builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .double_sided = true, .roughness = 1, .ior = 1});
    builder.instance(builder.mesh(mesh), white);
    builder.instance(builder.mesh(test::square(20).mesh()), white, Transform::look_at({0, 0, 0}, {0, 1, 0.001f}));
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, Transform::look_at({0, 2, 3}, {0, 0, 0}));
    Camera camera;
    camera.transform = Transform::look_at({0, 0.1f, 2}, {0, 0.5f, 0});
    camera.vertical_fov = 0.5;
    builder.camera(camera);
    const Scene scene = builder.finish();
    RenderOptions o = options();
    o.size = {40, 40};
    o.indirect = Indirect::visible;
    o.bounces = 1;
    const auto mean_of_strips = [&](const Frame& frame) {
        double sum = 0;
        int count = 0;
        const Layer& facing = *frame.layer("normal");
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                if (facing.value(x, y, 1) < -0.5f)
                    sum += static_cast<double>(frame.layer("indirect")->value(x, y)), ++count;
        EXPECT_GT(count, 300);
        return sum / count;
    };
    const double light = mean_of_strips(Renderer(o).render(scene, 1));
    o.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
    EXPECT_NEAR(light / mean_of_strips(Renderer(o).render(scene, 1)), 1, 0.05);
}

// The smooth surface of a box with rounded normals would reach into the ground around it.
TEST(SmoothMeshes, BoxesWithRoundedNormalsHaveLightAtTheirFeet)
{
    std::vector<Vec3> positions, normals;
    for (int i = 0; i < 8; ++i) {
        const Vec3 sign{i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f};
        positions.push_back({sign.x, sign.y + 1.001f, sign.z});
        normals.push_back({0.57735f * sign.x, 0.57735f * sign.y, 0.57735f * sign.z});
    }
    const std::vector<std::uint32_t> indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                                2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    Mesh mesh;
    mesh.positions = positions, mesh.normals = normals, mesh.indices = indices;
    SceneBuilder builder;
    const MaterialId white =
        builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .double_sided = true, .roughness = 1, .ior = 1});
    builder.instance(builder.mesh(mesh), white);
    builder.instance(builder.mesh(test::square(20).mesh()), white, Transform::look_at({0, 0, 0}, {0, 1, 0.001f}));
    builder.light({.type = LightType::directional, .color = {3, 3, 3}}, Transform::look_at({0, 2, 3}, {0, 0, 0}));
    Camera camera;
    camera.transform = Transform::look_at({0, 1, 6}, {0, 0.2f, 1});
    camera.vertical_fov = 0.12;   // the foot of the front
    builder.camera(camera);
    const Scene scene = builder.finish();
    RenderOptions o = options();
    o.size = {60, 60};
    o.indirect = Indirect::visible;
    o.bounces = 1;
    const auto light_of_foot = [&](const Frame& frame) {
        double sum = 0;
        for (int y = 10; y < 40; ++y)
            for (int x = 0; x < 60; ++x) sum += static_cast<double>(frame.layer("indirect")->value(x, y));
        return sum;
    };
    const double light = light_of_foot(Renderer(o).render(scene, 1));
    o.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
    EXPECT_NEAR(light / light_of_foot(Renderer(o).render(scene, 1)), 1, 0.1);
}

// The path-traced reference has the same horizon, so that both tell the same.
TEST(SmoothMeshes, AgreeWithTheReference)
{
    for (const Lights& lights : {Lights(add_square_light), Lights(add_uneven_sky)}) {
        RenderOptions o = options();
        o.size = {40, 40};
        const Frame frame = render(coarse(), lights, o);
        o.reference = ReferenceLightOptions{.spp = 1024, .bounces = 0};
        const Frame truth = render(coarse(), lights, o);
        double square = 0, sum = 0, of_truth = 0;
        int count = 0;
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x) {
                if (!is_inside(4 * x + 2, 4 * y + 2, 0.9f)) continue;
                const auto a = static_cast<double>(frame.layers.front().value(x, y)),
                           b = static_cast<double>(truth.layers.front().value(x, y));
                square += (a - b) * (a - b), sum += a, of_truth += b, ++count;
            }
        EXPECT_LT(std::sqrt(square / count), 0.06 * of_truth / count);
        EXPECT_NEAR(sum / of_truth, 1, 0.02);
    }
}

}   // namespace
}   // namespace gnomon
