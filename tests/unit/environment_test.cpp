// SPDX-License-Identifier: Apache-2.0
#include "scene/environment.h"

#include <gtest/gtest.h>

#include "api/scene_access.h"

#include "base/bits.h"
#include "base/random.h"
#include "gnomon/gnomon.h"
#include "io/image/exr.h"
#include "scene/direction_grid.h"
#include "scene/scene.h"
#include "support.h"

namespace gnomon::scene {
namespace {

ImageF even(int width, int height, const glm::vec3& color)
{
    ImageF image(width, height, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = color[static_cast<int>(i % 3)];
    return image;
}

// A dim sky with a small bright sun and some noise.
ImageF sunny(int width, int height)
{
    ImageF image(width, height, 3);
    Random random(4);
    for (float& value : image.data) value = random.uniform(0.1f, 0.5f);
    for (int c = 0; c < 3; ++c) image.pixel(width / 5, height / 4)[c] = 900;
    return image;
}

glm::vec3 any_direction(Random& random)
{
    const float z = random.uniform(-1, 1), a = random.uniform(0, static_cast<float>(2 * k_pi));
    const float r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

void expect_near(const glm::vec3& a, const glm::vec3& b, float tolerance)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "channel " << c;
}

TEST(Environment, MapsDirectionsAsDocumented)
{
    expect_near(Environment::direction_at(0.5, 0.5), {0, 0, -1}, 1e-6f);
    expect_near(Environment::direction_at(0.75, 0.5), {1, 0, 0}, 1e-6f);
    expect_near(Environment::direction_at(0.3, 0), {0, 1, 0}, 1e-6f);
    expect_near(Environment::direction_at(0, 0.5), {0, 0, 1}, 1e-6f);

    // Looking up a texel's own direction returns that texel.
    const ImageF image = sunny(64, 32);
    const Environment environment(image);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) {
            const float* p = image.pixel(x, y);
            const glm::vec3 seen = environment.radiance(Environment::direction_at((x + 0.5) / 64, (y + 0.5) / 32));
            ASSERT_NEAR(seen.x, p[0], 2e-3f * (900 + p[0])) << x << ' ' << y;
            if (p[0] < 1 && std::abs(x - 12) > 1) {
                ASSERT_NEAR(seen.x, p[0], 1e-3f) << x << ' ' << y;
            }
        }
}

TEST(Environment, IsContinuousAcrossTheImageBorder)
{
    ImageF image = even(8, 4, glm::vec3(0));
    for (int y = 0; y < 4; ++y) image.pixel(0, y)[0] = 2;
    const Environment environment(image);
    EXPECT_NEAR(environment.radiance({0, 0, 1}).x, 1, 1e-4f);   // between the first column and the last
    EXPECT_NEAR(environment.radiance({-1e-7f, 0, 1}).x, 1, 1e-4f);
}

TEST(Environment, UniformSkyHasUniformIrradiance)
{
    const Environment environment(even(100, 50, {1, 2, 3}));
    expect_near(environment.flux(), static_cast<float>(4 * k_pi) * glm::vec3(1, 2, 3), 1e-4f);
    Random random(1);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 d = any_direction(random);
        expect_near(environment.radiance(d), {1, 2, 3}, 1e-5f);
        expect_near(environment.ambient(d), {1, 2, 3}, 2e-2f);
    }
}

// The upper half is bright, the lower black: irradiance / pi is (1 + cos) / 2 in closed form.
TEST(Environment, AmbientOfAHalfBrightSkyEqualsClosedForm)
{
    ImageF image = even(200, 100, glm::vec3(0));
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 200; ++x) image.pixel(x, y)[1] = 1;
    const Environment environment(image);
    for (const float y : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
        EXPECT_NEAR(environment.ambient({std::sqrt(1 - y * y), y, 0}).y, (1 + y) / 2, 0.03f);
}

TEST(MedianCut, KeepsTheEnergyInRegionsOfEqualFlux)
{
    for (const int count : {1, 2, 16, 64}) {
        ImageF image = even(128, 64, glm::vec3(0));
        Random random(2);
        for (float& value : image.data) value = random.uniform(0.5f, 1.5f);
        const Environment environment(image);
        const std::vector<EnvironmentLight> lights = environment.lights(count);
        ASSERT_EQ(lights.size(), static_cast<std::size_t>(count));
        glm::dvec3 sum(0);
        for (const EnvironmentLight& light : lights) {
            sum += glm::dvec3(light.flux);
            EXPECT_NEAR(glm::length(light.to_light), 1, 1e-5f);
            EXPECT_NEAR(light.flux.y, environment.flux().y / static_cast<float>(count),
                        0.2f * environment.flux().y / static_cast<float>(count));
        }
        expect_near(glm::vec3(sum), environment.flux(), 1e-4f * environment.flux().x);
    }
}

// The vector irradiance of an environment is preserved exactly, and with it the light through any plane: the sum of
// irradiance times direction equals the integral of radiance times direction.
TEST(MedianCut, KeepsTheVectorIrradiance)
{
    const ImageF image = sunny(128, 64);
    glm::dvec3 flow(0);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 128; ++x) {
            const double solid = 2 * k_pi / 128 * (std::cos(y * k_pi / 64) - std::cos((y + 1) * k_pi / 64));
            const float* p = image.pixel(x, y);
            flow += solid * (0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]) *
                    glm::dvec3(Environment::direction_at((x + 0.5) / 128, (y + 0.5) / 64));
        }
    glm::dvec3 sum(0);
    for (const EnvironmentLight& light : Environment(image).lights(16))
        sum += static_cast<double>(luminance(light.irradiance)) * glm::dvec3(light.to_light);
    expect_near(glm::vec3(sum), glm::vec3(flow), 1e-3f * static_cast<float>(glm::length(flow)));
}

// A sun stronger than the rest of the sky gets lights of its own.
TEST(MedianCut, GivesTheSunItsOwnLight)
{
    const Environment environment(sunny(128, 64));
    const glm::vec3 sun = Environment::direction_at((25 + 0.5) / 128, (16 + 0.5) / 64);
    float nearest = -1, strength = 0;
    for (const EnvironmentLight& light : environment.lights(16))
        if (glm::dot(light.to_light, sun) > nearest) nearest = glm::dot(light.to_light, sun), strength = light.flux.x;
    EXPECT_GT(nearest, 0.999f);
    EXPECT_GT(strength, 900 * 0.0017f);   // the texel's own solid angle is about 0.0017
}

TEST(MedianCut, AcceptsBlackSkiesAndSingleTexels)
{
    EXPECT_TRUE(Environment(even(8, 4, glm::vec3(0))).lights(16).empty());
    EXPECT_LE(Environment(even(1, 1, glm::vec3(1))).lights(16).size(), 1u);
    ImageF odd = even(4, 2, glm::vec3(1));
    odd.data[0] = std::numeric_limits<float>::quiet_NaN();
    odd.data[1] = std::numeric_limits<float>::infinity();
    odd.data[2] = -5;
    const Environment environment(std::move(odd));
    for (const EnvironmentLight& light : environment.lights(4)) EXPECT_TRUE(is_finite(light.irradiance));
}

// A furnace test: under a uniform white sky, an isolated white surface is as bright as the sky. All orientations of a
// sphere are visible; traced frames light by the image itself, and keep lights for what cannot.
TEST(EnvironmentLight, WhiteSurfaceInWhiteSkyIsWhite)
{
    const test::ScratchFolder scratch;
    io::ExrLayer layer{"", {"R", "G", "B"}, std::vector<float>(64 * 32 * 3, 1.0f)};
    io::write_exr(scratch / "white.exr", {64, 32}, std::span(&layer, 1));

    for (const ShadingModel model : {ShadingModel::whitted, ShadingModel::metallic_roughness}) {
        auto inside = std::make_shared<Scene>();
        Material white;
        white.model = model;
        white.base_color = glm::vec3(1);
        white.roughness = 1;
        white.double_sided = true;
        inside->materials.push_back(white);
        Mesh plane;
        plane.positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
        plane.triangles = {{0, 2, 1}, {0, 3, 2}};
        plane.parts = {{0, 0, 2}};
        inside->meshes.push_back(plane);
        const NodeId node = inside->add_node("plane", none);
        inside->nodes[node].mesh = 0;
        inside->finish();
        add_default_light(*inside);
        add_default_camera(*inside);

        const gnomon::Scene scene = api::public_scene(inside).with_environment(scratch / "white.exr");
        EXPECT_EQ(scene.info().lights.size(), 16u);   // the default sun is gone
        RenderOptions options;
        options.size = {32, 32};
        Renderer renderer(options);
        const Frame image = renderer.render(scene, 1);
        double sum = 0;
        for (const float value : image.layers[0].values()) {
            EXPECT_NEAR(value, 1.0f, 0.06f);
            sum += value;
        }
        EXPECT_NEAR(sum / static_cast<double>(image.layers[0].values().size()), 1, 0.03);
    }
}

TEST(EnvironmentLight, ReplacesTheDefaultLightOfARoom)
{
    const test::ScratchFolder scratch;
    io::ExrLayer layer{"", {"R", "G", "B"}, std::vector<float>(64 * 32 * 3, 1.0f)};
    io::write_exr(scratch / "white.exr", {64, 32}, std::span(&layer, 1));
    // A box of six walls that face inward, seen from inside.
    auto inside = std::make_shared<Scene>();
    inside->materials.emplace_back();
    Mesh box;
    for (int i = 0; i < 8; ++i) box.positions.emplace_back(i & 1 ? 4 : 0, i & 2 ? 3 : 0, i & 4 ? 5 : 0);
    box.triangles = {{0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}, {0, 4, 1}, {1, 4, 5},
                     {2, 3, 6}, {3, 7, 6}, {0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7}};
    box.parts = {{0, 0, 12}};
    inside->meshes.push_back(box);
    inside->nodes[inside->add_node("box", none)].mesh = 0;
    inside->finish();
    add_default_light(*inside);
    ASSERT_FALSE(inside->lights.empty());
    for (const Light& light : inside->lights) EXPECT_EQ(light.type, LightType::spot);
    const gnomon::Scene scene = api::public_scene(inside).with_environment(scratch / "white.exr");
    EXPECT_EQ(scene.lights().size(), 16u);
    for (const gnomon::LightId light : scene.lights())
        EXPECT_EQ(scene.light(light).type, gnomon::LightType::directional);
}

TEST(EnvironmentLight, RefusesInvalidNumbers)
{
    const gnomon::Scene scene = load("builtin:cornell");
    for (const int lights : {0, 3, 2048, -1}) EXPECT_THROW(scene.with_environment("any.hdr", lights), UsageError);
    EXPECT_THROW(scene.with_environment("/nowhere/any.hdr"), InputError);
}

TEST(Environment, AGridHasTheDirectionsOfTheImage)
{
    for (const auto& [columns, rows] : {std::pair{7, 3}, {64, 32}, {1000, 3}}) {
        const DirectionGrid grid(columns, rows);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                ASSERT_EQ(grid.at(x, y), Environment::direction_at((x + 0.5) / columns, (y + 0.5) / rows));
    }
}

TEST(Environment, AGridHasTheLongitudesOfItsDirections)
{
    int unlike_column = 0;   // rounding matters
    for (const auto& [columns, rows] : {std::pair{1, 1}, {7, 3}, {1000, 3}, {1024, 128}}) {
        const DirectionGrid grid(columns, rows);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const glm::vec3 d = grid.at(x, y);
                ASSERT_TRUE(same_bits(grid.longitude(x, y, d), std::atan2(d.x, -d.z))) << x << ' ' << y;
                unlike_column += grid.longitude(x, y, d) != grid.longitude(x, 0, grid.at(x, 0));
            }
    }
    EXPECT_GT(unlike_column, 1000);
}

// By the same formula as an image's own look-up.
TEST(Environment, AnImageMayBeLookedUpByAngles)
{
    ImageF image(6, 4, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i * i % 17);
    const Environment environment(image);
    for (const glm::vec3& d :
         {glm::vec3(0, 0, 1), glm::vec3(-1e-9f, 0, 1), glm::vec3(0, 1, 0), glm::vec3(0, -1, 0),
          glm::vec3(0.6f, 0, -0.8f), glm::vec3(0.6f, -0.64f, 0.48f), glm::vec3(-0.6f, 0.64f, 0.48f)})
        EXPECT_EQ(environment.radiance(d),
                  radiance_at(image, std::atan2(d.x, -d.z), std::acos(d.y) / static_cast<float>(k_pi)));
    // Behind, the first column meets the last.
    const glm::vec3 seam = environment.radiance({0, 0, 1});
    for (int c = 0; c < 3; ++c) {
        float mean = 0;
        for (const auto& [x, y] : {std::pair{0, 1}, {0, 2}, {5, 1}, {5, 2}}) mean += 0.25f * image.pixel(x, y)[c];
        EXPECT_NEAR(seam[c], mean, 1e-4f);
    }
}

}   // namespace
}   // namespace gnomon::scene
