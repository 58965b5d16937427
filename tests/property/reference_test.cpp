// SPDX-License-Identifier: Apache-2.0
// The reference path tracer: exact where the result is known, with a reported error that is right, and the same for any
// thread count.
#include "reference/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/bits.h"
#include "gnomon/gnomon.h"
#include "reference_scenes.h"
#include "scene/builtin/builtin.h"
#include "scene/defaults/emissive_lights.h"
#include "scene/environment.h"
#include "scene_helpers.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

using reference::IrradianceEstimate;
using reference::IrradiancePoint;
using reference::ReferenceOptions;

using test::closed_room;
using test::emitter_scene;
using test::point_at;
using test::rectangle;
using test::under_emitter;
using World = test::ReferenceWorld;

// 16 paths of a batch: each decision has one point in each cell of 4 x 4, and in each sixteenth of both sides.
TEST(PathNumbers, EachDecisionIsSpreadEvenly)
{
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        for (std::uint32_t decision = 0; decision < 20; ++decision) {
            int cells[16] = {}, columns[16] = {}, rows[16] = {}, singles[16] = {};
            for (std::uint32_t path = 0; path < 16; ++path) {
                const reference::PathNumbers numbers(seed, path);
                const glm::vec2 at = numbers.pair(decision);
                ++cells[4 * static_cast<int>(4 * at.y) + static_cast<int>(4 * at.x)];
                ++columns[static_cast<int>(16 * at.x)], ++rows[static_cast<int>(16 * at.y)];
                ++singles[static_cast<int>(16 * numbers.one(decision))];
            }
            for (int i = 0; i < 16; ++i)
                EXPECT_TRUE(cells[i] == 1 && columns[i] == 1 && rows[i] == 1 && singles[i] == 1)
                    << seed << ' ' << decision << ' ' << i;
        }
}

// Two decisions of a path are uncorrelated, over paths and over batches.
TEST(PathNumbers, DecisionsAreIndependent)
{
    double product = 0, mean = 0;
    constexpr int k_batches = 4000, k_paths = 8;
    for (int batch = 0; batch < k_batches; ++batch)
        for (std::uint32_t path = 0; path < k_paths; ++path) {
            const reference::PathNumbers numbers(static_cast<std::uint64_t>(batch), path);
            const double a = numbers.pair(5).x - 0.5, b = numbers.pair(12).x - 0.5;
            product += a * b, mean += a;
        }
    constexpr double k_count = k_batches * k_paths;
    EXPECT_NEAR(12 * product / k_count, 0, 4 / std::sqrt(k_count));   // standard error: 1 / sqrt(count)
    EXPECT_NEAR(mean / k_count, 0, 0.005);
}

scene::LightId add_sun(scene::Scene& scene, const glm::vec3& direction, const glm::vec3& lux)
{
    scene::Light light;
    light.type = scene::LightType::directional;
    light.color = lux;
    const glm::dvec3 d(glm::normalize(direction));
    const glm::dvec3 up = std::abs(d.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    light.node = scene.add_node("sun", scene::none, glm::inverse(glm::lookAt(glm::dvec3(0), d, up)));
    scene.lights.push_back(light);
    return static_cast<scene::LightId>(scene.lights.size() - 1);
}

// A furnace: in a closed room whose walls emit radiance 1 and have the same albedo everywhere, every point gets the
// same irradiance: pi without a bounce, and pi times the n-th power of the albedo from the n-th bounce.
TEST(Reference, FurnaceOfEmissiveWallsIsUnbiasedAfterEachBounce)
{
    scene::Scene scene = closed_room();
    scene.materials[0].emissive = glm::vec3(1);
    scene.materials[0].base_color = {0.5f, 0.8f, 0.2f};
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 4096, options.shining = true;
    for (const int bounces : {0, 1, 3}) {
        options.bounces = bounces;
        for (const IrradianceEstimate& e :
             world.irradiance({point_at({0, 0, 0}, {0, 1, 0}), point_at({0.9f, -0.9f, 0.3f}, {0, 0, 1}, 7)}, options)) {
            for (int c = 0; c < 3; ++c) {
                double expected = 0;
                const auto albedo = static_cast<double>(world.scene->materials[0].base_color[c]);
                for (int n = 1; n <= bounces; ++n) expected += k_pi * std::pow(albedo, n);
                EXPECT_LT(e.error[c], 0.03 * k_pi);
                EXPECT_NEAR(e.surroundings[c], k_pi, 4.5f * e.error[c]) << c;
                EXPECT_NEAR(e.indirect[c], expected, 4.5f * e.indirect_error[c] + 1e-6) << c << ' ' << bounces;
            }
        }
    }
}

// The same with many bounces and Russian roulette: exact on average.
TEST(Reference, FurnaceWithRussianRouletteIsUnbiased)
{
    scene::Scene scene = closed_room();
    scene.materials[0].emissive = glm::vec3(1);
    scene.materials[0].base_color = glm::vec3(0.5f);
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 4096, options.shining = true, options.bounces = 40;
    const IrradianceEstimate e = world.irradiance({point_at({0, 0, 0}, {0, 1, 0})}, options)[0];
    EXPECT_GT(e.indirect_error.x, 0);
    EXPECT_NEAR(e.indirect.x, k_pi, 4.5f * e.indirect_error.x);
    EXPECT_LT(e.indirect_error.x, 0.05);
}

// White objects in a uniform white environment are invisible: all incident light is reflected. (Without the ball's
// smooth normals, which lose the light reflected below the surface.)
TEST(Reference, WhiteObjectsVanishInAWhiteEnvironment)
{
    scene::Scene scene;
    scene.background.color = glm::vec3(1);
    scene.materials.resize(1);
    scene.materials[0].base_color = glm::vec3(1);
    scene.materials[0].double_sided = true;
    scene.meshes.push_back(test::ball(0, 12, 18));
    scene.meshes.edit(scene.meshes.size() - 1).normals.clear();
    test::add_object(scene, 0, scene::none, test::translation(0, 2, 0));
    scene.meshes.push_back(rectangle({3, 3}));
    test::add_object(scene, 1);
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 1024, options.surroundings = true, options.bounces = 200;
    IrradiancePoint on_floor = point_at({0.2f, 0, 0.1f}, {0, 1, 0});
    on_floor.offset = 1e-4f;
    const IrradianceEstimate e = world.irradiance({on_floor}, options)[0];
    const glm::vec3 sum = e.indirect + e.surroundings;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], k_pi, 4.5f * e.error[c] + 1e-3) << c;
}

// Under an image with a bright zenith and a small sun, a point that sees half of it gets its integral: neither the
// sampling of the image nor that of the surface is biased, nor are their weights.
TEST(Reference, UnevenEnvironmentGivesItsIntegral)
{
    const glm::vec3 sun = glm::normalize(glm::vec3(1, 0.7f, 0.2f));
    ImageF image(128, 64, 3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const glm::vec3 d = scene::Environment::direction_at((x + 0.5) / image.width, (y + 0.5) / image.height);
            const float bright = glm::dot(d, sun) > 0.995f ? 100.0f : 0.0f;
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = bright + 0.5f + (d.y > 0.9f ? 10.0f : 0.0f) + static_cast<float>(c) * d.x * d.x;
        }
    scene::Scene scene;
    scene.background.kind = scene::Background::Kind::image;
    scene.background.environment = std::make_shared<const scene::Environment>(image);
    scene.materials.resize(1);
    scene.meshes.push_back(rectangle({0.01f, 0.01f}));
    test::add_object(scene, 0, scene::none, test::translation(0, -500, 0));   // out of sight
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 1 << 15, options.surroundings = true, options.bounces = 0;
    for (const glm::vec3& normal : {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0), glm::normalize(glm::vec3(-1, 1, 2))}) {
        glm::dvec3 truth(0);
        constexpr int k_rows = 1000, k_columns = 2000;
        for (int row = 0; row < k_rows; ++row)
            for (int column = 0; column < k_columns; ++column) {
                const double up = 1 - (2 * row + 1.0) / k_rows, angle = 2 * k_pi * (column + 0.5) / k_columns;
                const double across = std::sqrt(1 - up * up);
                const glm::vec3 d(glm::dvec3(across * std::cos(angle), up, across * std::sin(angle)));
                const float cosine = glm::dot(d, normal);
                if (cosine > 0)
                    truth += glm::dvec3(world.scene->background.environment->radiance(d) * cosine) *
                             (4 * k_pi / (k_rows * k_columns));
            }
        const IrradianceEstimate e = world.irradiance({point_at({0, 0, 0}, normal)}, options)[0];
        for (int c = 0; c < 3; ++c) {
            EXPECT_LT(static_cast<double>(e.error[c]), 0.008 * truth[c]);
            EXPECT_NEAR(static_cast<double>(e.surroundings[c]) / truth[c], 1, 0.01) << c << ' ' << normal.x;
        }
    }
}

// Differential element to a parallel rectangle over its corner [Howell, catalogue of configuration factors, B-3].
double form_factor(double a, double b, double distance)
{
    const double x = a / distance, y = b / distance;
    const double rx = std::sqrt(1 + x * x), ry = std::sqrt(1 + y * y);
    return (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * k_pi);
}

TEST(Reference, SquareEmitterGivesTheFloorWhatLambertSays)
{
    for (const double height : {2.0, 0.5, 0.15, 0.01}) {
        scene::Scene scene = emitter_scene(height, false);
        const World world(test::finished(scene));
        std::vector<IrradiancePoint> points;
        std::vector<glm::dvec2> places{{0, 0}, {0.3, 0.2}, {0.49, 0}, {0.6, -0.3}, {1.5, 0.7}};
        for (const glm::dvec2& p : places) points.push_back(point_at({p.x, 0, p.y}, {0, 1, 0}, points.size() + 1));
        ReferenceOptions options;
        options.samples = 1 << 14, options.shining = true, options.bounces = 0;
        const auto estimates = world.irradiance(points, options);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double expected = under_emitter(places[i], height);
            for (int c = 0; c < 3; ++c) {
                const double truth = expected * static_cast<double>(world.scene->materials[1].emissive[c]);
                EXPECT_NEAR(estimates[i].surroundings[c], truth, 4.5f * estimates[i].error[c] + 2e-4 * truth)
                    << height << ' ' << i;
                EXPECT_LT(estimates[i].error[c], 0.05 * truth + 1e-3) << height << ' ' << i;
            }
        }
    }
}

// A half-plane at y = .5 whose edge lies over x = 0 hides a part of the emitter: the penumbra.
TEST(Reference, PenumbraOfAStraightEdgeIsTheVisiblePartOfTheEmitter)
{
    constexpr double k_height = 1, k_edge = 0.5;
    scene::Scene scene = emitter_scene(k_height, false);
    scene.meshes.push_back(rectangle({50, 50}));
    test::add_object(scene, 1, scene::none, test::translation(-50, k_edge, 0));
    const World world(test::finished(scene));
    std::vector<IrradiancePoint> points;
    for (int i = -7; i <= 7; ++i)
        points.push_back(point_at({0.1f * static_cast<float>(i), 0, 0.1f}, {0, 1, 0}, points.size() + 1));
    ReferenceOptions options;
    options.samples = 1 << 14, options.shining = true, options.bounces = 0;
    const auto estimates = world.irradiance(points, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec2 p(points[i].position.x, points[i].position.z);
        // A ray to the emitter's x passes the edge's height at a place between: it must lie beyond the edge.
        const double from = p.x - p.x * k_height / k_edge;
        const double truth = under_emitter(p, k_height, from);
        EXPECT_NEAR(estimates[i].surroundings.y, truth, 4.5f * estimates[i].error.y + 2e-4) << p.x;
    }
}

TEST(Reference, SurfacesEmitOnTheFrontUnlessTheyAreDoubleSided)
{
    ReferenceOptions options;
    options.samples = 1 << 12, options.shining = true, options.bounces = 0;
    for (const bool double_sided : {false, true}) {
        scene::Scene scene = emitter_scene(1, double_sided);
        const World world(test::finished(scene));
        const IrradianceEstimate above = world.irradiance({point_at({0.1f, 2, 0}, {0, -1, 0})}, options)[0];
        const double truth = double_sided ? under_emitter({0.1, 0}, 1) : 0;
        EXPECT_NEAR(above.surroundings.y, truth, 4.5f * above.error.y + 1e-6);
    }
}

// Beside other lights, dim, textured, far away, and many: emission always lights, once.
TEST(Reference, EmissionLightsBesideOtherLightsAndIsCountedOnce)
{
    scene::Scene scene = emitter_scene(1, false);
    scene.finish();
    scene::add_emitter_lights(scene);   // approximate the emitter for the other methods
    ASSERT_FALSE(scene.lights.empty());
    scene::Light weak;
    weak.color = glm::vec3(1e-3f);
    weak.node = scene.add_node("weak", scene::none, test::translation(0, 1, 0));
    scene.lights.push_back(weak);
    scene.materials[1].emissive = glm::vec3(0.99f);
    scene.textures.push_back(scene::Texture("half", Image8(1, 1, 3), false, {}));
    {
        Image8 image(2, 1, 3);   // white, and half of it
        for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = i < 3 ? 255 : 128;
        scene.textures.replace(0, scene::Texture("half", image, false, {}));
    }
    scene.materials[1].emissive_texture.texture = 0;
    scene.meshes.edit(0).texcoords[0].assign(4, glm::vec2(0.25f, 0.5f));   // the white texel's middle
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 1 << 13, options.shining = true, options.bounces = 0;
    const IrradianceEstimate e = world.irradiance({point_at({0.2f, 0, 0}, {0, 1, 0})}, options)[0];
    const double truth = 0.99 * under_emitter({0.2, 0}, 1);
    EXPECT_NEAR(e.surroundings.x, truth, 4.5f * e.error.x + 1e-3 * truth);
    // The lights that stand for the emitter take no part; the weak one does.
    const reference::ReferenceLight light(world.state, world.rays, options);
    for (const scene::Light& l : world.scene->lights) EXPECT_EQ(light.uses(l), !l.of_surface);
}

TEST(Reference, AgreesWithAnAnalyticFormFactor)
{
    for (const scene::ShadingModel model : {scene::ShadingModel::metallic_roughness, scene::ShadingModel::whitted}) {
        scene::Scene scene;
        scene.materials.resize(1);
        scene.materials[0].model = model;
        scene.materials[0].base_color = {0.5f, 0.25f, 0.75f};
        scene.meshes.push_back(rectangle({0.8f, 0.5f}));
        test::add_object(scene, 0);
        add_sun(scene, {0.6f, -0.8f, 0}, {2, 3, 4});
        const World world(test::finished(scene));
        ReferenceOptions options;
        options.samples = 1 << 14;
        // A point on no surface, so that nothing occludes it; over the middle, and over a corner.
        const double whole = 4 * form_factor(0.8, 0.5, 0.7), corner = form_factor(1.6, 1.0, 0.7);
        const auto e = world.irradiance(
            {point_at({0, 0.7f, 0}, {0, -1, 0}), point_at({0.8f, 0.7f, -0.5f}, {0, -1, 0}, 2)}, options);
        // AFF's lights lack a factor of pi.
        const double factor = model == scene::ShadingModel::whitted ? k_pi : 1;
        for (int c = 0; c < 3; ++c) {
            const double exitance = static_cast<double>(world.scene->materials[0].base_color[c]) * 0.8 * (2 + c);
            for (int i = 0; i < 2; ++i) {
                const IrradianceEstimate& at = e[static_cast<std::size_t>(i)];
                const double expected = factor * exitance * (i == 0 ? whole : corner);
                EXPECT_NEAR(at.indirect[c], expected, 4.5f * at.indirect_error[c]) << c << ' ' << i;
                EXPECT_LT(at.indirect_error[c], 0.01 * expected);
                EXPECT_GT(at.indirect_error[c], 0);
            }
        }
        EXPECT_EQ(e[0].surroundings, glm::vec3(0));
    }
}

// Glass in between does not block light, here as for shadow rays; the surface behind it is hit.
TEST(Reference, GlassDoesNotBlockLight)
{
    const auto irradiance = [](bool glass) {
        scene::Scene scene;
        scene.materials.resize(2);
        scene.materials[1].transmission = 1;
        scene.meshes.push_back(rectangle({2, 2}));
        test::add_object(scene, 0);
        add_sun(scene, {0, -1, 0}, glm::vec3(1));
        scene.meshes.push_back(rectangle({2, 2}));
        scene.meshes.edit(scene.meshes.size() - 1).parts[0].material = 1;
        if (glass) {
            test::add_object(scene, 1, scene::none, test::translation(0, 0.3, 0));
            test::add_object(scene, 1, scene::none, test::translation(0, 0.4, 0));
        }
        const World world(test::finished(scene));
        ReferenceOptions options;
        options.samples = 256;
        return world.irradiance({point_at({0, 0.7f, 0}, {0, -1, 0})}, options)[0].indirect.x;
    };
    EXPECT_FLOAT_EQ(irradiance(false), irradiance(true));
    EXPECT_GT(irradiance(false), 0.5f);
}

std::vector<IrradiancePoint> points_of_cornell(const World& world, int side)
{
    std::vector<IrradiancePoint> points;
    const scene::View view = scene::make_view(world.state, 0, {side, side});
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            glm::vec3 origin, direction;
            float tnear, tfar;
            view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
            const ray::Hit hit = world.rays.closest_single(origin, tnear, direction, tfar, ray::Sides::front);
            if (hit.object == scene::none) continue;
            points.push_back(reference::irradiance_point(*world.scene, world.rays, hit.object, hit.triangle, hit.u,
                                                         hit.v, -direction, points.size()));
        }
    return points;
}

// Two seeds differ by as much as both report: over many points, z has mean 0 and variance 1, slightly more with the 30
// degrees of freedom of its estimate (30 / 28).
TEST(Reference, SeedsDifferByTheReportedError)
{
    const World world(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), 3);
    const auto points = points_of_cornell(world, 24);
    ASSERT_GT(points.size(), 300u);
    ReferenceOptions options;
    options.samples = 1024;
    options.seed = 1;
    const auto a = world.irradiance(points, options);
    options.seed = 2;
    const auto b = world.irradiance(points, options);
    double sum = 0, square = 0, worst = 0;
    int count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double error = std::hypot(a[i].indirect_error.y, b[i].indirect_error.y);
        if (!(error > 0)) continue;
        const double z = static_cast<double>(a[i].indirect.y - b[i].indirect.y) / error;
        sum += z, square += z * z, worst = std::max(worst, std::abs(z));
        ++count;
    }
    ASSERT_GT(count, 300);
    EXPECT_LT(std::abs(sum / count), 4 / std::sqrt(count));
    EXPECT_NEAR(square / count, 30.0 / 28, 4 * 1.6 / std::sqrt(count));
    EXPECT_LT(worst, 6);
}

// The error falls as paths are added, at least as fast as for random sampling.
TEST(Reference, ErrorFallsWithMorePaths)
{
    const World world(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), 1);
    const auto points = points_of_cornell(world, 12);
    double error[2];
    for (int i = 0; i < 2; ++i) {
        ReferenceOptions options;
        options.samples = i == 0 ? 64 : 1024;
        double sum = 0;
        for (const IrradianceEstimate& e : world.irradiance(points, options))
            sum += static_cast<double>(glm::dot(e.indirect_error, e.indirect_error));
        error[i] = std::sqrt(sum);
    }
    EXPECT_LT(error[1], error[0] / 3);
}

// Lights are sampled one at a time; the sum equals the separate results.
TEST(Reference, SumOfSingleLightsEqualsAllLights)
{
    const auto scene_with = [](int mask) {
        scene::Scene scene = closed_room();
        const glm::vec3 colors[] = {{8, 1, 1}, {0.2f, 0.4f, 0.1f}, {0.1f, 3, 0.3f}};
        for (int l = 0; l < 3; ++l) {
            if (!(mask & (1 << l))) continue;
            scene::Light light;
            light.color = colors[l];
            light.node = scene.add_node("", scene::none, test::translation(0.5 * l - 0.5, 0.3 * l, 0.2));
            scene.lights.push_back(light);
        }
        return test::finished(scene);
    };
    ReferenceOptions options;
    options.samples = 1 << 14;
    options.bounces = 2;
    const std::vector<IrradiancePoint> points{point_at({0, -0.5f, 0}, {0, -1, 0}),
                                              point_at({0.3f, 0.1f, -0.4f}, {0.6f, 0.8f, 0}, 5)};
    const auto together = World(scene_with(7)).irradiance(points, options);
    std::vector<glm::dvec3> sum(2, glm::dvec3(0)), variance(2, glm::dvec3(0));
    for (int l = 0; l < 3; ++l) {
        options.seed = 1 + static_cast<std::uint64_t>(l);
        const auto one = World(scene_with(1 << l)).irradiance(points, options);
        for (std::size_t i = 0; i < 2; ++i) {
            sum[i] += glm::dvec3(one[i].indirect);
            variance[i] += glm::dvec3(one[i].indirect_error * one[i].indirect_error);
        }
    }
    for (std::size_t i = 0; i < 2; ++i)
        for (int c = 0; c < 3; ++c) {
            const double own = static_cast<double>(together[i].indirect_error[c]);
            EXPECT_NEAR(static_cast<double>(together[i].indirect[c]), sum[i][c],
                        4.5 * std::sqrt(variance[i][c] + own * own));
        }
}

TEST(Reference, SameBytesForAnyThreadCountAndAnyOtherPoints)
{
    const World world(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), 2);
    const auto points = points_of_cornell(world, 10);
    ReferenceOptions options;
    options.samples = 100, options.bounces = 2;
    const auto one = world.irradiance(points, options, 1);
    for (const int threads : {2, 5}) {
        const auto many = world.irradiance(points, options, threads);
        ASSERT_EQ(one.size(), many.size());
        EXPECT_TRUE(same_bits(one, many)) << threads;
    }
    const auto alone = world.irradiance({points[17]}, options, 1);
    EXPECT_EQ(alone[0].indirect, one[17].indirect);
    options.seed = 9;
    EXPECT_NE(world.irradiance({points[17]}, options, 1)[0].indirect, one[17].indirect);
}

TEST(Reference, StopsWhenInterrupted)
{
    const World world(std::make_shared<const scene::Scene>(scene::make_builtin("cornell")));
    const auto points = points_of_cornell(world, 10);
    Tasks tasks(2);
    ReferenceOptions options;
    options.samples = 1000;
    EXPECT_THROW(reference::reference_irradiance(world.state, world.rays, points, options, tasks, nullptr,
                                                 [](const ProgressStep&) { return false; }),
                 InterruptedError);
}

// The frame of a renderer: an emitter beside a weak light lights the floor as it does alone, and as Lambert says.
TEST(ReferenceFrame, AnEmitterBesideAWeakLightLightsTheFloor)
{
    constexpr float k_radiance = 3, k_albedo = 0.5f;
    std::vector<Vec3> square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> down{0, 1, 2, 0, 2, 3}, up{0, 2, 1, 0, 3, 2};
    const auto center = [&](bool weak, float& truth) {
        SceneBuilder builder;
        const MaterialId emitter =
            builder.material({.base_color = {0, 0, 0}, .emissive = {k_radiance, k_radiance, k_radiance}});
        const MaterialId floor = builder.material({.base_color = {k_albedo, k_albedo, k_albedo}, .roughness = 1});
        builder.instance(builder.mesh({.positions = square, .indices = down}), emitter,
                         Transform::translation(0, 1, 0));
        builder.instance(builder.mesh({.positions = square, .indices = up}), floor, Transform::scaling(20, 1, 20));
        if (weak) builder.light({.color = {1e-3f, 1e-3f, 1e-3f}}, Transform::translation(0.2, 0.5, 0));
        Camera camera;
        camera.transform = Transform::look_at({1.5f, 0.5f, 0}, {1, 0, 0});
        camera.vertical_fov = 0.02;
        builder.camera(camera);
        RenderOptions options;
        options.size = {8, 8};
        options.reference = ReferenceLightOptions{.spp = 1024, .bounces = 0};
        const Frame frame = Renderer(options).render(builder.finish(), 1);
        double sum = 0;
        for (const float value : frame.layers.front().values()) sum += static_cast<double>(value);
        truth = static_cast<float>(k_albedo / k_pi * k_radiance * under_emitter({1, 0}, 1));
        return static_cast<float>(sum / (8 * 8 * 3));
    };
    float truth = 0;
    const float alone = center(false, truth), beside = center(true, truth);
    EXPECT_NEAR(beside, alone, 0.02f * alone);
    EXPECT_NEAR(alone, truth, 0.05f * truth);   // a dielectric's diffuse part is a little darker
}

}   // namespace
}   // namespace gnomon
