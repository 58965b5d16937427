// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/emissive_lights.h"

#include <gtest/gtest.h>

#include <ctime>

#include "sanitized.h"
#include "scene/state.h"

namespace gnomon::scene {
namespace {

MaterialId add_material(Scene& scene, const glm::vec3& emissive, bool double_sided = false)
{
    Material material;
    material.emissive = emissive;
    material.double_sided = double_sided;
    scene.materials.push_back(material);
    return static_cast<MaterialId>(scene.materials.size() - 1);
}

// Adds a rectangle with corner p, on a node that `world` rotates and translates.
NodeId add_quad(Scene& scene, MaterialId material, const glm::vec3& p, const glm::vec3& u, const glm::vec3& v,
                const glm::dmat4& world = glm::dmat4(1))
{
    Mesh mesh;
    mesh.positions = {p, p + u, p + u + v, p + v};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{material, 0, 2}};
    scene.meshes.push_back(mesh);
    const NodeId node = scene.add_node("quad", none, world);
    scene.nodes[node].mesh = static_cast<MeshId>(scene.meshes.size() - 1);
    return node;
}

// The flux of all lights: pi times the intensity, for a cosine profile over a hemisphere.
glm::vec3 total_flux(const Scene& scene)
{
    glm::vec3 sum(0);
    for (const Light& light : scene.lights) sum += light.color * static_cast<float>(k_pi);
    return sum;
}

TEST(Emitters, KeepTheFlux)
{
    Scene scene;
    // Facing down, 2 x 3, under a node that moves it up and rotates it about the vertical.
    const glm::dmat4 world = glm::dmat4(glm::dmat3(0, 0, -1, 0, 1, 0, 1, 0, 0));
    glm::dmat4 placed = world;
    placed[3] = {5, 4, 1, 1};
    add_quad(scene, add_material(scene, {10, 20, 5}), {0, 0, 0}, {2, 0, 0}, {0, 0, 3}, placed);
    add_quad(scene, add_material(scene, {0, 0, 0}), {0, 0, -3}, {10, 0, 0}, {0, 0, 8});
    scene.finish();
    add_emitter_lights(scene);

    ASSERT_EQ(scene.lights.size(), 16u);
    const glm::vec3 expected = glm::vec3(10, 20, 5) * static_cast<float>(6 * k_pi);
    EXPECT_LT(glm::length(total_flux(scene) - expected), 1e-4f * glm::length(expected));

    // The lights are just below the quad, point down, and form a 4 x 4 grid over all of it.
    const SceneState state(std::make_shared<const Scene>(scene), 0);
    Box3 box;
    for (LightId i = 0; i < scene.lights.size(); ++i) {
        const LightState& light = state.light(i);
        EXPECT_NEAR(light.direction.y, -1, 1e-5f);
        EXPECT_LT(light.position.y, 4.0f);
        EXPECT_GT(light.position.y, 3.9f);
        box.add(light.position);
    }
    EXPECT_NEAR(box.size().x, 3 * 0.75f, 1e-4f);   // local z points along world x
    EXPECT_NEAR(box.size().z, 2 * 0.75f, 1e-4f);
    EXPECT_NEAR(box.low.x, 5 + 3 * 0.125f, 1e-4f);
    EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Emitters, IrradianceEqualsThatOfTheSurface)
{
    Scene scene;
    add_quad(scene, add_material(scene, glm::vec3(8)), {-0.5f, 4, -0.5f}, {1, 0, 0}, {0, 0, 1});
    add_quad(scene, add_material(scene, {0, 0, 0}), {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
    scene.finish();
    add_emitter_lights(scene);
    const SceneState state(std::make_shared<const Scene>(scene), 0);
    for (const float x : {0.0f, 1.0f, 3.0f}) {
        const glm::vec3 point(x, 0, 0);
        float lights = 0;
        for (LightId i = 0; i < scene.lights.size(); ++i) {
            const LightSample sample = illuminate(scene.lights[i], state.light(i), point);
            lights += sample.irradiance.x * sample.to_light.y;
        }
        // Integrate the rectangle numerically: L cos cos / d^2 dA.
        double surface = 0;
        constexpr int n = 100;
        for (int i = 0; i < n * n; ++i) {
            const int column = i % n, row = i / n;
            const glm::dvec3 to((column + 0.5) / n - 0.5 - static_cast<double>(x), 4, (row + 0.5) / n - 0.5);
            const double square = glm::dot(to, to);
            surface += 8 * (16 / square) / square / (n * n);
        }
        EXPECT_NEAR(lights, surface, 0.02 * surface) << x;
    }
}

TEST(Emitters, ManyEmittersKeepTheFlux)
{
    Scene scene;
    const MaterialId emitter = add_material(scene, glm::vec3(50));
    for (int i = 0; i < 40; ++i)
        add_quad(scene, emitter, {static_cast<float>(2 * i), 5, 0}, {1, 0, 0},
                 {0, 0, 1 + 0.1f * static_cast<float>(i)});
    scene.finish();
    add_emitter_lights(scene);
    EXPECT_EQ(scene.lights.size(), 16u);
    float area = 0;
    for (int i = 0; i < 40; ++i) area += 1 + 0.1f * static_cast<float>(i);
    EXPECT_NEAR(total_flux(scene).x, 50 * area * k_pi, 1e-3 * 50 * area * k_pi);
}

TEST(Emitters, LightHoweverDimAndSmallAndBesideOtherLights)
{
    const auto lights = [](const glm::vec3& emissive, float size, bool has_light) {
        Scene scene;
        add_quad(scene, add_material(scene, emissive), {0, 5, 0}, {size, 0, 0}, {0, 0, size});
        add_quad(scene, add_material(scene, {0, 0, 0}), {-5, 0, -5}, {10, 0, 0}, {0, 0, 10});
        scene.finish();
        if (has_light) {
            scene.lights.emplace_back();
            scene.lights[0].node = scene.add_node("light", none);
            scene.finish();
        }
        add_emitter_lights(scene);
        return scene.lights.size();
    };
    EXPECT_EQ(lights(glm::vec3(10), 2, false), 16u);
    EXPECT_EQ(lights(glm::vec3(0.5f), 2, false), 16u);
    EXPECT_EQ(lights(glm::vec3(10), 0.01f, false), 16u);
    EXPECT_EQ(lights(glm::vec3(10), 2, true), 17u);
    EXPECT_EQ(lights(glm::vec3(0), 2, false), 0u);
}

TEST(Emitters, TwoSidedEmittersShineToBothSidesButNotIntoWhatTheyLieOn)
{
    const auto directions = [](float height) {
        Scene scene;
        add_quad(scene, add_material(scene, glm::vec3(10), true), {4, height, 4}, {0, 0, 2}, {2, 0, 0});
        const MaterialId white = add_material(scene, glm::vec3(0));
        add_quad(scene, white, {0, 10, 0}, {10, 0, 0}, {0, 0, 10});
        add_quad(scene, white, {0, 0, 0}, {0, 0, 10}, {10, 0, 0});
        scene.finish();
        add_emitter_lights(scene);
        const SceneState state(std::make_shared<const Scene>(scene), 0);
        glm::vec2 up_and_down(0);
        for (LightId l = 0; l < scene.lights.size(); ++l)
            (state.light(l).direction.y > 0 ? up_and_down.x : up_and_down.y) += scene.lights[l].color.x;
        return up_and_down;
    };
    EXPECT_NEAR(directions(5).x, 40, 0.01);   // radiance times area, per side
    EXPECT_NEAR(directions(5).y, 40, 0.01);
    EXPECT_EQ(directions(9.99f).x, 0);   // right under the ceiling
    EXPECT_NEAR(directions(9.99f).y, 40, 0.01);
}

TEST(Emitters, HandlesADeepNodeHierarchyQuickly)
{
    Scene scene;
    add_quad(scene, add_material(scene, {10, 10, 10}), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (int i = 0; i < 60'000; ++i) {
        const NodeId node = scene.add_node("quad", static_cast<NodeId>(i), glm::dmat4(1));
        scene.nodes[node].mesh = 0;
    }
    scene.finish();
    const std::clock_t start = std::clock();
    add_emitter_lights(scene);
    EXPECT_FALSE(scene.lights.empty());
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 4.0 * test::k_patience);
}

TEST(Emitters, LightsMoveWithTheirSurface)
{
    Scene scene;
    const NodeId node = add_quad(scene, add_material(scene, glm::vec3(10)), {0, 5, 0}, {2, 0, 0}, {0, 0, 2});
    add_quad(scene, add_material(scene, {0, 0, 0}), {-5, 0, -5}, {10, 0, 0}, {0, 0, 10});
    scene.finish();
    add_emitter_lights(scene);
    ASSERT_FALSE(scene.lights.empty());
    for (const Light& light : scene.lights) EXPECT_EQ(scene.nodes[light.node].parent, node);
}

}   // namespace
}   // namespace gnomon::scene
