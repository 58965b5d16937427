// SPDX-License-Identifier: Apache-2.0
// The lobe of rough surfaces keeps all energy, is sampled as its density says, and shows emission and the background as
// bright as they are, at every roughness.
#include "shading/glossy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gnomon/gnomon.h"
#include "shading/lobe_shared.h"
#include "shading/shading.h"

namespace gnomon {
namespace {

shading::SurfacePoint surface(float roughness, float cosine, const glm::vec3& specular)
{
    shading::SurfacePoint s;
    s.normal = s.geometric_normal = s.smooth_normal = {0, 0, 1};
    s.to_viewer = {std::sqrt(1 - cosine * cosine), 0, cosine};
    s.specular = specular;
    s.roughness = roughness;
    return s;
}

constexpr float k_roughness[] = {0.06f, 0.1f, 0.2f, 0.4f, 0.7f, 1.0f};
constexpr float k_cosines[] = {0.05f, 0.2f, 0.5f, 0.9f, 1.0f};

// The mean of what the lobe reflects over its density, from a regular pattern.
glm::vec3 sampled_albedo(const shading::SurfacePoint& s)
{
    constexpr int k_side = 200;
    glm::dvec3 sum(0);
    for (int i = 0; i < k_side; ++i)
        for (int j = 0; j < k_side; ++j) {
            const glm::vec3 direction = shading::sample_glossy(s, (static_cast<float>(i) + 0.5f) / k_side,
                                                               (static_cast<float>(j) + 0.5f) / k_side);
            const float density = shading::glossy_density(s, direction);
            if (density > 0) sum += glm::dvec3(shading::reflect_glossy(s, direction) / density);
        }
    return glm::vec3(sum / static_cast<double>(k_side * k_side));
}

TEST(Glossy, WhiteMetalReflectsAllLight)
{
    for (const float roughness : k_roughness)
        for (const float cosine : k_cosines) {
            const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(1));
            EXPECT_NEAR(sampled_albedo(s).x, 1, 0.015) << roughness << ' ' << cosine;
            EXPECT_NEAR(shading::glossy_albedo(s).x, 1, 1e-3) << roughness << ' ' << cosine;
        }
}

TEST(Glossy, AlbedoIsThatOfTheSampledLobe)
{
    for (const float roughness : k_roughness)
        for (const float cosine : k_cosines)
            for (const float specular : {0.04f, 0.5f}) {
                const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(specular));
                EXPECT_NEAR(sampled_albedo(s).x, shading::glossy_albedo(s).x, 0.015) << roughness << ' ' << cosine;
            }
}

// Rows of the table are made when they are first needed, and the table has all of them.
TEST(Glossy, AlbedoIsInterpolatedInTheTable)
{
    constexpr int k_side = GNOMON_ALBEDO_SIDE;
    for (const int row : {3, 17, 30})
        for (const int column : {5, 20}) {
            shading::SurfacePoint s = surface(static_cast<float>(row) / (k_side - 1),
                                              static_cast<float>(column) / (k_side - 1), glm::vec3(0.5f));
            s.f90 = 1;
            const float before = shading::glossy_albedo(s).x;
            const std::span<const glm::vec2> table = shading::glossy_albedo_table();
            ASSERT_EQ(table.size(), static_cast<std::size_t>(k_side) * k_side);
            const glm::vec2 parts = table[static_cast<std::size_t>(row * k_side + column)];
            const float kept = parts.x + parts.y;
            EXPECT_NEAR(before, (0.5f * parts.x + parts.y) * (1 + 0.5f * (1 - kept) / kept), 1e-5f);
            EXPECT_EQ(before, shading::glossy_albedo(s).x);
        }
}

// Integrated over the sphere, on a grid that is fine around the mirror direction.
TEST(Glossy, DensityIntegratesToOne)
{
    for (const float roughness : {0.4f, 0.7f, 1.0f})
        for (const float cosine : {0.2f, 0.6f, 1.0f}) {
            const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(1));
            constexpr int k_rows = 900, k_columns = 900;
            double sum = 0;
            for (int i = 0; i < k_rows; ++i)
                for (int j = 0; j < k_columns; ++j) {
                    const double z = -1 + 2 * (i + 0.5) / k_rows, phi = 2 * k_pi * (j + 0.5) / k_columns;
                    const double r = std::sqrt(1 - z * z);
                    sum += static_cast<double>(
                        shading::glossy_density(s, glm::vec3(r * std::cos(phi), r * std::sin(phi), z)));
                }
            EXPECT_NEAR(sum * 4 * k_pi / (k_rows * k_columns), 1, 0.01) << roughness << ' ' << cosine;
        }
}

// The light of points is reflected by the same lobe, without the energy given back: a factor for all directions.
TEST(Glossy, IsTheLobeThatReflectsTheLightOfPoints)
{
    for (const float roughness : k_roughness) {
        const shading::SurfacePoint s = surface(roughness, 0.7f, {0.9f, 0.5f, 0.3f});
        const glm::vec3 mirror(-s.to_viewer.x, 0, s.to_viewer.z);
        glm::vec3 first(0);
        for (const glm::vec3& off : {glm::vec3(0), glm::vec3(0.03f, 0.02f, 0), glm::vec3(-0.02f, 0.05f, 0)}) {
            const glm::vec3 to_light = glm::normalize(mirror + off);
            const glm::vec3 ratio =
                shading::reflect_glossy(s, to_light) / shading::reflect_light(s, to_light, glm::vec3(1));
            if (first == glm::vec3(0)) first = ratio;
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(ratio[c], 0.999f) << roughness;
                EXPECT_NEAR(ratio[c], first[c], 1e-3f * first[c]) << roughness;
            }
        }
    }
}

struct Ball {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;
    Ball()
    {
        constexpr int k_rings = 24, k_sides = 36;
        for (int y = 0; y <= k_rings; ++y)
            for (int x = 0; x < k_sides; ++x) {
                const double v = k_pi * y / k_rings, u = 2 * k_pi * x / k_sides;
                positions.push_back({static_cast<float>(std::sin(v) * std::cos(u)), static_cast<float>(std::cos(v)),
                                     static_cast<float>(std::sin(v) * std::sin(u))});
            }
        for (std::uint32_t y = 0; y < k_rings; ++y)
            for (std::uint32_t x = 0; x < k_sides; ++x) {
                const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
                    return (y + dy) * k_sides + (x + dx) % k_sides;
                };
                for (const std::uint32_t i : {at(0, 0), at(1, 0), at(0, 1), at(1, 0), at(1, 1), at(0, 1)})
                    indices.push_back(i);
            }
    }
};

enum class Around : std::uint8_t { emissive_room, background };

// The least and the largest radiance of a convex object of one material, seen in surroundings of radiance 1.
std::pair<float, float> in_a_furnace(const Material& material, Around around)
{
    static const Ball ball;
    SceneBuilder builder;
    const MeshId mesh = builder.mesh({.positions = ball.positions, .indices = ball.indices});
    builder.instance(mesh, builder.material(material));
    if (around == Around::emissive_room) {
        Material wall{.base_color = {0, 0, 0}, .roughness = 1};
        wall.emissive = {1, 1, 1};
        wall.double_sided = true;
        builder.instance(mesh, builder.material(wall), Transform::scaling(9, 9, 9));
    } else {
        builder.background({1, 1, 1});
    }
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
    camera.vertical_fov = 0.35;   // the ball fills the image
    builder.camera(camera);
    RenderOptions options;
    options.size = {12, 12};
    options.reference = ReferenceLightOptions{.spp = 2048, .bounces = 0};
    const Frame frame = Renderer(options).render(builder.finish(), 1);
    const auto values = frame.layers.front().values();
    return {*std::min_element(values.begin(), values.end()), *std::max_element(values.begin(), values.end())};
}

TEST(GlossyFrame, WhiteMetalVanishesAtEveryRoughness)
{
    for (const Around around : {Around::emissive_room, Around::background})
        for (const float roughness : {0.0f, 0.04f, 0.06f, 0.1f, 0.2f, 0.4f, 0.7f, 1.0f}) {
            const auto [least, most] =
                in_a_furnace({.base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness}, around);
            EXPECT_GT(least, 0.95f) << roughness << ' ' << static_cast<int>(around);
            EXPECT_LT(most, 1.05f) << roughness << ' ' << static_cast<int>(around);
        }
}

TEST(GlossyFrame, WhiteDielectricGainsNoEnergy)
{
    for (const float roughness : {0.1f, 0.4f, 1.0f}) {
        const auto [least, most] =
            in_a_furnace({.base_color = {1, 1, 1}, .metallic = 0, .roughness = roughness}, Around::emissive_room);
        EXPECT_GT(least, 0.93f) << roughness;
        EXPECT_LT(most, 1.07f) << roughness;
    }
}

}   // namespace
}   // namespace gnomon
