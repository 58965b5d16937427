// SPDX-License-Identifier: Apache-2.0
// Light of a sky that is seen through an opening, held against the integral over the opening.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene_helpers.h"
#include "world.h"

namespace gnomon {
namespace {

constexpr double k_half_width = 0.5, k_half_length = 0.7, k_height = 3;   // of the opening, above the floor
constexpr float k_radiance = 2, k_reflectance = 0.02f;

scene::Mesh square()
{
    scene::Mesh mesh;
    mesh.positions = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    return mesh;
}

// Square steps of a few pixels at two heights: no lattice of cache points fits them.
scene::Mesh steps()
{
    constexpr int k_across = 24;
    constexpr float k_wide = 2.6f / k_across, k_rise = 0.02f;
    scene::Mesh mesh;
    for (int i = 0; i < k_across; ++i)
        for (int k = 0; k < k_across; ++k) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            const float x = k_wide * static_cast<float>(i) - 1.3f, z = k_wide * static_cast<float>(k) - 1.3f;
            const float y = (i + k) % 2 == 0 ? k_rise : 0.0f;
            for (const glm::vec2 at : {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0)})
                mesh.positions.emplace_back(x + k_wide * at.x, y, z + k_wide * at.y);
            mesh.triangles.push_back({first, first + 1, first + 2});
            mesh.triangles.push_back({first, first + 2, first + 3});
        }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

// A dark floor below a wide ceiling with an opening, under an even sky, seen from below the ceiling.
// @param lid       half the width of a square above the opening that sways a little; 0: none
// @param of_steps  steps() lie on the floor
Scene floor_below_an_opening(double lid = 0, bool of_steps = false)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].base_color = glm::vec3(k_reflectance);
    scene.materials[0].roughness = 1, scene.materials[0].ior = 1, scene.materials[0].double_sided = true;
    scene.meshes.push_back(square());
    const auto add = [&](const glm::dvec3& at, const glm::dvec3& half) {
        test::add_object(scene, 0, scene::none, glm::scale(glm::translate(glm::dmat4(1), at), half));
    };
    const double far = 50;
    add({0, of_steps ? -0.01 : 0, 0}, {2 * far, 1, 2 * far});
    if (of_steps) {
        scene.meshes.push_back(steps());
        test::add_object(scene, 1, scene::none, glm::dmat4(1));
    }
    add({-far - k_half_width, k_height, 0}, {far, 1, 2 * far}),
        add({far + k_half_width, k_height, 0}, {far, 1, 2 * far});
    add({0, k_height, -far - k_half_length}, {k_half_width, 1, far});
    add({0, k_height, far + k_half_length}, {k_half_width, 1, far});
    if (lid > 0) {
        const scene::NodeId node = scene.add_node("lid", scene::none);
        scene.nodes[node].transform = std::make_shared<test::SwayTrack>(glm::dvec3(0, k_height + 0.1, 0), 3, 0.02);
        test::add_object(scene, 0, node, glm::scale(glm::dmat4(1), glm::dvec3(lid, 1, lid)));
        scene.timeline.frames = 3, scene.timeline.fps = 2, scene.timeline.end = 1;
    }
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(k_radiance);
    scene::Camera camera;
    camera.node = scene.add_node(
        "camera", scene::none,
        glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0, 2.5, 0)), -0.5 * k_pi, glm::dvec3(1, 0, 0)));
    camera.vertical_fov = 0.9;
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

// What the floor reflects at a place.
double reflected(double x, double z)
{
    constexpr int k_steps = 40;
    double sum = 0;
    for (int i = 0; i < k_steps; ++i)
        for (int k = 0; k < k_steps; ++k) {
            const double dx = k_half_width * ((2 * i + 1.0) / k_steps - 1) - x;
            const double dz = k_half_length * ((2 * k + 1.0) / k_steps - 1) - z;
            const double square = dx * dx + dz * dz + k_height * k_height;
            sum += k_height * k_height / (square * square);
        }
    const double area = 4 * k_half_width * k_half_length / (k_steps * k_steps);
    return static_cast<double>(k_reflectance * k_radiance) / k_pi * area * sum;
}

constexpr int k_size = 64;

std::vector<float> light_of(const Frame& frame)
{
    for (const Layer& layer : frame.layers)
        if (layer.name == "indirect") return layer.copy();
    throw std::runtime_error("no layer of indirect light");
}

RenderOptions options_of_layers()
{
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    options.samples = 1;
    return options;
}

struct Compared {
    double mean = 0, error = 0, most = 0;   // of the ratio to the integral; of its deviation from 1
};

Compared compare(const Scene& scene)
{
    const std::vector<float> light = light_of(Renderer(options_of_layers()).render(scene, 1));
    EXPECT_EQ(light.size(), std::size_t{3 * k_size * k_size});
    Compared result;
    double square = 0, sum = 0;
    const double half = 2.5 * std::tan(0.45);
    for (int y = 0; y < k_size; ++y)
        for (int x = 0; x < k_size; ++x) {
            const double u = half * ((2 * x + 1.0) / k_size - 1), v = half * ((2 * y + 1.0) / k_size - 1);
            const double ratio =
                static_cast<double>(light[static_cast<std::size_t>(3 * (y * k_size + x))]) / reflected(u, v);
            sum += ratio, square += (ratio - 1) * (ratio - 1);
            result.most = std::max(result.most, std::abs(ratio - 1));
        }
    result.mean = sum / (k_size * k_size);
    result.error = std::sqrt(square / (k_size * k_size));
    testing::Test::RecordProperty("mean", std::to_string(result.mean));
    testing::Test::RecordProperty("error", std::to_string(result.error));
    testing::Test::RecordProperty("most", std::to_string(result.most));
    return result;
}

// With undivided directions, what a place sees of the sky changes by whole directions, of which such an opening holds
// six: the mean is .944 then, the error .13, and .33 at most.
TEST(SkyOpening, LightsAFloorEvenly)
{
    const Compared floor = compare(floor_below_an_opening());
    EXPECT_NEAR(floor.mean, 1, 0.01);
    EXPECT_LT(floor.error, 0.03);
    EXPECT_LT(floor.most, 0.08);
}

// Steps are lit one by one, from half as many directions. Three of these are in the opening, and undivided ones make an
// error of .25. Some pixels show the floor between two steps.
TEST(SkyOpening, LightsSmallStepsEvenly)
{
    const Compared floor = compare(floor_below_an_opening(0, true));
    EXPECT_NEAR(floor.mean, 1, 0.02);
    EXPECT_LT(floor.error, 0.09);
}

// A moving lid takes away the light of all parts that it covers, and gives it back.
TEST(SkyOpening, IsClosedByAMovingLid)
{
    const Scene open = floor_below_an_opening(), closed = floor_below_an_opening(3);
    Renderer renderer(options_of_layers());
    float brightest = 0, left = 0;
    for (const float value : light_of(renderer.render(open, 1))) brightest = std::max(brightest, value);
    for (const int frame : {1, 2})
        for (const float value : light_of(renderer.render(closed, frame))) left = std::max(left, std::abs(value));
    EXPECT_GT(brightest, 1e-3f);
    EXPECT_LT(left, 0.03f * brightest);   // 2 % come from beyond the ceiling, whose sides are open
}

TEST(SkyOpening, IsPartlyClosedByAMovingLid)
{
    const Scene open = floor_below_an_opening(), partly = floor_below_an_opening(0.5);
    Renderer renderer(options_of_layers()), fresh(options_of_layers());
    renderer.render(partly, 1);
    const std::vector<float> whole = light_of(renderer.render(open, 1)), warm = light_of(renderer.render(partly, 2)),
                             cold = light_of(fresh.render(partly, 2));
    EXPECT_EQ(warm, cold);
    double sum = 0, sum_whole = 0;
    for (std::size_t i = 0; i < warm.size(); ++i) {
        sum += static_cast<double>(warm[i]), sum_whole += static_cast<double>(whole[i]);
        EXPECT_LE(warm[i], 1.001f * whole[i]);
    }
    EXPECT_GT(sum, 0.1 * sum_whole);
    EXPECT_LT(sum, 0.6 * sum_whole);
}

}   // namespace
}   // namespace gnomon
