// SPDX-License-Identifier: Apache-2.0
// Patches of a scene that stands on a ground a hundred times as wide: where they are, and what light bounces between
// them, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gnomon/gnomon.h"
#include "patches/surface_patches.h"
#include "scene_helpers.h"
#include "world.h"

namespace gnomon {
namespace {

using patches::Patch;
using patches::PatchId;
using patches::SurfacePatches;
using test::World;

constexpr float k_half = 1;       // of a cube on the ground
constexpr float k_ground = 300;   // half the width of the ground

scene::Mesh cube()
{
    scene::Mesh mesh;
    for (int corner = 0; corner < 8; ++corner)
        mesh.positions.emplace_back(corner & 1 ? k_half : -k_half, corner & 2 ? 2 * k_half : 0,
                                    corner & 4 ? k_half : -k_half);
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 4, 2}, {2, 4, 6},
                      {1, 3, 5}, {3, 7, 5}, {2, 6, 3}, {3, 6, 7}, {0, 1, 4}, {1, 5, 4}};
    mesh.parts = {{0, 0, 12}};
    return mesh;
}

// @param quads  of the ground, along each side
scene::Mesh ground(int quads)
{
    scene::Mesh mesh;
    const float step = 2 * k_ground / static_cast<float>(quads);
    for (int z = 0; z <= quads; ++z)
        for (int x = 0; x <= quads; ++x)
            mesh.positions.emplace_back(static_cast<float>(x) * step - k_ground, 0,
                                        static_cast<float>(z) * step - k_ground);
    const auto row = static_cast<std::uint32_t>(quads + 1);
    for (std::uint32_t z = 0; z + 1 < row; ++z)
        for (std::uint32_t x = 0; x + 1 < row; ++x) {
            const std::uint32_t first = z * row + x;
            mesh.triangles.emplace_back(first, first + row, first + 1);
            mesh.triangles.emplace_back(first + 1, first + row, first + row + 1);
        }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

scene::Scene cube_on_ground(int quads)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].double_sided = true;
    scene.meshes.push_back(cube()), scene.meshes.push_back(ground(quads));
    test::add_object(scene, 0);
    test::add_object(scene, 1);
    scene.finish();
    return scene;
}

class GroundPatches : public testing::TestWithParam<int> {};

// Most patches are near the cube, and those of the ground are the wider the farther away they are.
TEST_P(GroundPatches, AreWhereTheDetailIs)
{
    World world(cube_on_ground(GetParam()));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    std::size_t near = 0;
    double area = 0;
    for (const Patch& patch : patches.patches()) {
        const float away = glm::length(patch.position);
        near += away < 8 * k_half ? 1 : 0;
        area += static_cast<double>(patch.area);
        EXPECT_LT(patch.radius, std::max(0.5f * k_half, 0.7f * away));
    }
    EXPECT_GT(2 * near, patches.patches().size());
    EXPECT_GT(patches.patches().size(), 4096u);
    EXPECT_NEAR(area, 2.0 * (24 + 4.0 * 300 * 300), 1e-3 * area);
}

// What is asked for a point is a patch around it, on tiles of every size.
TEST_P(GroundPatches, AreFoundAtTheirPlaces)
{
    World world(cube_on_ground(GetParam()));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const auto triangles = static_cast<std::uint32_t>(world.rays.geometry(1).mesh->triangles.size());
    std::uint32_t state = 1;
    const auto number = [&] {   // 0 to 1
        state = state * 1664525u + 1013904223u;
        return static_cast<float>(state >> 8) * 0x1p-24f;
    };
    std::size_t found = 0;
    constexpr std::size_t k_points = 4000;
    for (std::size_t i = 0; i < k_points; ++i) {
        const std::uint32_t t =
            std::min(static_cast<std::uint32_t>(number() * static_cast<float>(triangles)), triangles - 1);
        glm::vec3 p[3];
        world.rays.geometry(1).corners(t, p);
        // Half of the points lie along a line through the middle of the ground.
        float u = number(), v = number();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        if (i % 2 == 0 && triangles == 2) v = (1 - 0.02f * number()) * (1 - u);
        const glm::vec3 at = (1 - u - v) * p[0] + u * p[1] + v * p[2];
        for (const bool front : {false, true}) {
            const glm::vec3 above = at + glm::vec3(0, front ? 1e-3f : -1e-3f, 0);
            const PatchId patch = patches.patch_at(world.rays, 1, t, u, v, front, above);
            if (patch == patches::k_no_patch) continue;
            ++found;
            const Patch& of = patches.patches()[patch];
            EXPECT_LE(glm::length(at - of.position), 1.01f * of.radius) << at.x << ' ' << at.z;
            EXPECT_GT(front ? of.normal.y : -of.normal.y, 0.9f);
        }
    }
    EXPECT_GT(found, 2 * k_points * 98 / 100);
}

INSTANTIATE_TEST_SUITE_P(Quads, GroundPatches, testing::Values(1, 64));

// Two walls that lean together over a ground, under a sun: most of the light between them has bounced more than twice.
Scene leaning_walls(bool grounded)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.9f, 0.9f, 0.9f}, .roughness = 1, .ior = 1});
    const std::vector<std::uint32_t> quad{0, 1, 2, 0, 2, 3};
    constexpr int k_strips = 16;
    for (const float side : {-1.0f, 1.0f})
        for (int strip = 0; strip < k_strips; ++strip) {
            const float low = 2.0f * static_cast<float>(strip) / k_strips, high = low + 2.0f / k_strips;
            const float x = side * (1.4f - 0.45f * low), y = side * (1.4f - 0.45f * high);
            const std::vector<Vec3> wall{{x, low, -2}, {x, low, 2}, {y, high, 2}, {y, high, -2}};
            builder.instance(builder.mesh({.positions = wall, .indices = quad}), white);
        }
    const float half = grounded ? 600.0f : 6.0f;
    const std::vector<Vec3> ground{{-half, 0, -half}, {-half, 0, half}, {half, 0, half}, {half, 0, -half}};
    builder.instance(builder.mesh({.positions = ground, .indices = quad}), white);
    builder.light({.type = LightType::directional, .color = {3, 3, 3}},
                  Transform::rotation({1, 0, 0}, -std::numbers::pi / 2));
    Camera camera;
    camera.transform = Transform::look_at({0, 1, 5}, {0, 0.6, 0});
    camera.vertical_fov = 0.5;
    builder.camera(camera);
    return builder.finish();
}

double mean_indirect(const Frame& frame)
{
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        double sum = 0;
        for (const float value : layer.copy()) sum += static_cast<double>(value);
        return sum / static_cast<double>(layer.copy().size());
    }
    throw std::runtime_error("no layer of indirect light");
}

// On a ground to the horizon, patches were as wide as the walls, and a bounce between the walls was too small a part of
// the ground's light to be computed: .75 of the light was left.
TEST(GroundLight, BouncesAsMuchAsOnASmallGround)
{
    for (const bool grounded : {false, true}) {
        const Scene scene = leaning_walls(grounded);
        RenderOptions options;
        options.size = {96, 64};
        options.layers = true;
        const double got = mean_indirect(Renderer(options).render(scene, 1));
        options.reference = ReferenceLightOptions{128};
        const double truth = mean_indirect(Renderer(options).render(scene, 1));
        EXPECT_GT(truth, 0.1);
        EXPECT_NEAR(got / truth, 1, 0.04) << (grounded ? "to the horizon" : "small");
    }
}

}   // namespace
}   // namespace gnomon
