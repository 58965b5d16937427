// SPDX-License-Identifier: Apache-2.0
// Surfaces of small triangles that rise and fall between cache points, against the path-traced reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene_helpers.h"

namespace gnomon {
namespace {

constexpr int k_size = 96;

// A roof of round tiles, as high as wide, under an even sky, seen from low above: tiles are some ten pixels wide.
Scene tiles()
{
    constexpr int k_tiles = 25, k_around = 8, k_along = 50;
    constexpr float k_width = 0.16f, k_length = 4;
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].base_color = glm::vec3(0.3f);
    scene.materials[0].roughness = 1, scene.materials[0].ior = 1;
    scene::Mesh mesh;
    const int columns = k_tiles * k_around;
    for (int j = 0; j <= k_along; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float angle = static_cast<float>(k_pi) * static_cast<float>(i % k_around) / k_around;
            mesh.positions.emplace_back(k_width * (static_cast<float>(i) / k_around - 0.5f * k_tiles),
                                        k_width * std::sin(angle), k_length * (0.5f - static_cast<float>(j) / k_along));
        }
    for (int j = 0; j < k_along; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i), b = a + 1,
                       c = a + static_cast<std::uint32_t>(columns) + 1, d = c + 1;
            mesh.triangles.emplace_back(a, b, d), mesh.triangles.emplace_back(a, d, c);
        }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    scene.meshes.push_back(std::move(mesh));
    test::add_object(scene, 0);
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(1);
    scene::Camera camera;
    const glm::dvec3 eye(-1.5, 1, 4);
    camera.node =
        scene.add_node("camera", scene::none, glm::inverse(glm::lookAt(eye, glm::dvec3(0), glm::dvec3(0, 1, 0))));
    camera.vertical_fov = 0.35;
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

std::vector<float> light_of(const RenderOptions& options)
{
    const Frame frame = Renderer(options).render(tiles(), 1);
    const auto layer = std::ranges::find(frame.layers, "indirect", &Layer::name);
    return layer->copy();
}

TEST(UnevenSurface, RoofTilesAreLitAsTheyAreSeen)
{
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    options.samples = 1;
    options.bounces = 1;
    const std::vector<float> got = light_of(options);
    options.reference = ReferenceLightOptions{64, 1, 0};
    const std::vector<float> truth = light_of(options);
    double square = 0, sum = 0, sum_truth = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < truth.size(); i += 3) {
        if (!(truth[i] > 0)) continue;
        const double error = static_cast<double>(got[i] - truth[i]);
        square += error * error, sum += static_cast<double>(got[i]), sum_truth += static_cast<double>(truth[i]),
            ++count;
    }
    const double mean = sum_truth / static_cast<double>(count);
    const double nrmse = std::sqrt(square / static_cast<double>(count)) / mean;
    RecordProperty("energy", std::to_string(sum / sum_truth));
    RecordProperty("nrmse", std::to_string(nrmse));
    EXPECT_GT(count, 0.7 * k_size * k_size);
    // .79 and .26 if cache points a spacing apart stand for what lies between them.
    EXPECT_NEAR(sum / sum_truth, 1, 0.06);
    EXPECT_LT(nrmse, 0.13);
}

}   // namespace
}   // namespace gnomon
