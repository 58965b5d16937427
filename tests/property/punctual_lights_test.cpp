// SPDX-License-Identifier: Apache-2.0
// KHR_lights_punctual in absolute units: the radiance of a matte floor below lights of a glTF file, by closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "api/scene_access.h"
#include "gltf_document.h"
#include "host_scene.h"

namespace gnomon {
namespace {

constexpr int k_size = 64;
constexpr double k_half = 2;       // of the floor's side, which the image shows from above
constexpr double k_albedo = 0.5;   // in green

// The radiance that each pixel of the floor sends up, in the middle channel.
struct Floor {
    Frame frame;
    double at(int x, int y) const { return static_cast<double>(frame.layers.front().value(x, y, 1)); }
    // The point of a pixel: x to the right, z down.
    static glm::dvec3 point(int x, int y)
    {
        return {k_half * ((2 * x + 1.0) / k_size - 1), 0, k_half * ((2 * y + 1.0) / k_size - 1)};
    }
};

/// @param light  its properties
/// @param node   of the light
Floor lit_by(const std::string& light, const std::string& node)
{
    test::Document document;
    const int positions = document.positions({-2, 0, 2, 2, 0, 2, 2, 0, -2, -2, 0, -2});
    const int indices = document.accessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5123, 1);
    scene::Scene made = document.load(
        fmt::format(
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":{},"material":0}}]}}],)"
            R"("materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.25,{},1,1],"metallicFactor":0}},)"
            R"("extensions":{{"KHR_materials_specular":{{"specularFactor":0}}}}}}],)"
            R"("cameras":[{{"type":"orthographic","orthographic":{{"xmag":2,"ymag":2,"znear":0.1,"zfar":50}}}}],)"
            R"("nodes":[{{"mesh":0}},{{"camera":0,"translation":[0,20,0],"rotation":[-0.70710678,0,0,0.70710678]}},)"
            R"({{{},"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],)"
            R"("scenes":[{{"nodes":[0,1,2]}}],"scene":0)",
            positions, indices, k_albedo, node),
        fmt::format(R"("extensionsUsed":["KHR_lights_punctual","KHR_materials_specular"],)"
                    R"("extensions":{{"KHR_lights_punctual":{{"lights":[{{{}}}]}}}},)",
                    light));
    EXPECT_TRUE(made.warnings.empty()) << made.warnings.front();
    const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(std::move(made)));
    return {Renderer(test::plain({k_size, k_size})).render(scene, 1)};
}

// The radiance by an irradiance.
double reflected(double irradiance)
{
    return irradiance * k_albedo / std::numbers::pi;
}

TEST(PunctualLights, APointLightOfSoManyCandelaFallsWithTheSquare)
{
    const glm::dvec3 light(0.5, 1.5, -0.25);
    const Floor floor =
        lit_by(R"("type":"point","intensity":7,"color":[1,0.5,0.25])", R"("translation":[0.5,1.5,-0.25])");
    for (const auto& [x, y] : {std::pair(3, 5), {20, 40}, {31, 31}, {40, 28}, {60, 60}}) {
        const glm::dvec3 way = light - Floor::point(x, y);
        const double square = glm::dot(way, way);
        const double truth = reflected(7 * 0.5 * way.y / (square * std::sqrt(square)));
        EXPECT_NEAR(floor.at(x, y), truth, 2e-3 * truth) << x << ' ' << y;
    }
}

// 1 - (distance / range)^4, as the extension recommends.
TEST(PunctualLights, ARangeFadesItOut)
{
    const Floor floor = lit_by(R"("type":"point","intensity":7,"range":2)", R"("translation":[0,1,0])");
    for (const auto& [x, y] : {std::pair(31, 31), {20, 40}, {10, 20}, {2, 2}}) {
        const glm::dvec3 way = glm::dvec3(0, 1, 0) - Floor::point(x, y);
        const double square = glm::dot(way, way), fade = std::max(0.0, 1 - square * square / 16);
        const double truth = reflected(7 * fade / (square * std::sqrt(square)));
        EXPECT_NEAR(floor.at(x, y), truth, 2e-3 * truth + 1e-6) << x << ' ' << y;
    }
}

// Full within the inner cone, none beyond the outer one, and the square of the cosines' share between.
TEST(PunctualLights, ASpotLightHasTwoCones)
{
    constexpr double k_inner = 0.3, k_outer = 0.7, k_height = 2;
    const Floor floor = lit_by(R"("type":"spot","intensity":11,"spot":{"innerConeAngle":0.3,"outerConeAngle":0.7})",
                               R"("translation":[0,2,0],"rotation":[-0.70710678,0,0,0.70710678])");
    int inside = 0, between = 0, outside = 0;
    for (int y = 1; y < k_size; y += 5)
        for (int x = 1; x < k_size; x += 5) {
            const glm::dvec3 way = glm::dvec3(0, k_height, 0) - Floor::point(x, y);
            const double square = glm::dot(way, way), cosine = way.y / std::sqrt(square), angle = std::acos(cosine);
            const double share =
                std::clamp((cosine - std::cos(k_outer)) / (std::cos(k_inner) - std::cos(k_outer)), 0.0, 1.0);
            const double truth = reflected(11 * share * share * cosine / square);
            EXPECT_NEAR(floor.at(x, y), truth, 3e-3 * truth + 1e-5) << x << ' ' << y;
            ++(angle < k_inner ? inside : angle < k_outer ? between : outside);
        }
    EXPECT_GT(inside, 5);
    EXPECT_GT(between, 20);
    EXPECT_GT(outside, 20);
}

TEST(PunctualLights, ADirectionalLightOfSoManyLuxIsEven)
{
    // 60 degrees from the vertical: light that travels along (0, -1/2, -sqrt(3)/2).
    const Floor floor = lit_by(R"("type":"directional","intensity":3)", R"("rotation":[-0.25881905,0,0,0.96592583])");
    for (const auto& [x, y] : {std::pair(3, 5), {31, 31}, {60, 60}})
        EXPECT_NEAR(floor.at(x, y), reflected(3 * 0.5), 1e-3 * reflected(1.5)) << x << ' ' << y;
}

}   // namespace
}   // namespace gnomon
