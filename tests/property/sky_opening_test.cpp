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

// A dark floor below a wide ceiling with an opening, under an even sky, seen from below the ceiling.
// @param lid  half the width of a square above the opening that sways a little; 0: none
Scene floor_below_an_opening(double lid = 0)
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
    add({0, 0, 0}, {2 * far, 1, 2 * far});
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

// With undivided directions, what a place sees of the sky changes by whole directions, of which such an opening holds
// six: the mean is .944 then, the error .13, and .33 at most.
TEST(SkyOpening, LightsAFloorEvenly)
{
    const std::vector<float> light = light_of(Renderer(options_of_layers()).render(floor_below_an_opening(), 1));
    ASSERT_EQ(light.size(), std::size_t{3 * k_size * k_size});
    double square = 0, sum = 0, most = 0;
    const double half = 2.5 * std::tan(0.45);
    for (int y = 0; y < k_size; ++y)
        for (int x = 0; x < k_size; ++x) {
            const double u = half * ((2 * x + 1.0) / k_size - 1), v = half * ((2 * y + 1.0) / k_size - 1);
            const double ratio =
                static_cast<double>(light[static_cast<std::size_t>(3 * (y * k_size + x))]) / reflected(u, v);
            sum += ratio, square += (ratio - 1) * (ratio - 1), most = std::max(most, std::abs(ratio - 1));
        }
    const double error = std::sqrt(square / (k_size * k_size));
    RecordProperty("error", std::to_string(error));
    RecordProperty("most", std::to_string(most));
    RecordProperty("mean", std::to_string(sum / (k_size * k_size)));
    EXPECT_NEAR(sum / (k_size * k_size), 1, 0.01);
    EXPECT_LT(error, 0.03);
    EXPECT_LT(most, 0.08);
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
