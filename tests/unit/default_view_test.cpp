// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/default_view.h"

#include <gtest/gtest.h>

#include "io/load.h"
#include "scene/builtin/studio.h"
#include "scene/defaults/framing.h"
#include "scene/defaults/surface_points.h"
#include "scene/defaults/surroundings.h"
#include "scene/view.h"
#include "support.h"

namespace gnomon::scene {
namespace {

constexpr int k_all = 63;

// Adds rectangles: sides of a box as bits (low x, high x, low y, ...), whose fronts face out of it, or into it.
void add_box(Mesh& mesh, const glm::vec3& low, const glm::vec3& size, bool inward, int sides = k_all)
{
    for (int i = 0; i < 6; ++i) {
        if (!(sides & (1 << i))) continue;
        const int axis = i / 2;
        const bool high = i % 2;
        glm::vec3 p = low, u(0), v(0);
        if (high) p[axis] += size[axis];
        u[(axis + 1) % 3] = size[(axis + 1) % 3];
        v[(axis + 2) % 3] = size[(axis + 2) % 3];
        if (high == inward) std::swap(u, v);
        const auto n = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec3& corner : {p, p + u, p + u + v, p + v}) mesh.positions.push_back(corner);
        mesh.triangles.emplace_back(n, n + 1, n + 2);
        mesh.triangles.emplace_back(n, n + 2, n + 3);
    }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
}

Scene scene_of(Mesh mesh)
{
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes.push_back(std::move(mesh));
    scene.nodes.resize(1);
    scene.nodes[0].mesh = 0;
    scene.finish();
    return scene;
}

SceneState state_of(const Scene& scene)
{
    return {std::make_shared<Scene>(scene), 0};
}

// A house: walls with an inner and an outer face.
Mesh house()
{
    Mesh mesh;
    add_box(mesh, {0, 0, 0}, {12, 4, 8}, false);
    for (int room = 0; room < 3; ++room)
        add_box(mesh, {0.2f + 3.9f * static_cast<float>(room), 0.2f, 0.2f}, {3.7f, 3.6f, 7.6f}, true);
    return mesh;
}

// A cup: outside, inside, open above.
Mesh cup()
{
    Mesh mesh;
    add_box(mesh, {0, 0, 0}, {1, 1.2f, 1}, false, k_all & ~8);
    add_box(mesh, {0.05f, 0.05f, 0.05f}, {0.9f, 1.15f, 0.9f}, true, k_all & ~8);
    return mesh;
}

TEST(DefaultView, InteriorIsBelievedOnlyIfItCannotBeSeenFromOutside)
{
    const Scene rooms = scene_of(house()), drink = scene_of(cup());
    EXPECT_LT(share_seen_from_outside(state_of(rooms)), 0.5f);
    EXPECT_GT(share_seen_from_outside(state_of(drink)), 0.7f);
    ASSERT_TRUE(find_interior(rooms));
    EXPECT_TRUE(believed_interior(state_of(rooms)));
    EXPECT_FALSE(believed_interior(state_of(drink)));
    // From outside, the cup is whole in the image.
    const DefaultView view = choose_view(state_of(drink));
    EXPECT_FALSE(view.room);
    EXPECT_GT(glm::length(view.eye - glm::dvec3(0.5, 0.6, 0.5)), 1.5);
}

// The front of a jug lies behind its lip as the back of a stage lies behind its opening, but no walls lead there.
TEST(DefaultView, AJugWithALipIsNoStage)
{
    GNOMON_NEED_SCENE(jug, "real/jug_01_4k-transformed/jug_01_4k-transformed.glb");
    GNOMON_NEED_SCENE(stage, "real/cornell_box/scene.gltf");
    const auto is_stage = [](const std::filesystem::path& file) {
        Scene scene = io::load_scene(file);
        const auto interior = find_interior(scene);
        return interior && interior->stage;
    };
    EXPECT_FALSE(is_stage(jug));
    EXPECT_TRUE(is_stage(stage));
}

TEST(DefaultView, AvoidsTheUnseenBacksOfOneSidedSurfaces)
{
    for (const bool away : {false, true}) {
        Mesh panel;
        add_box(panel, {0, 0, 0}, {2, 1.5f, 1}, away, 32);   // the side at high z, facing +Z or -Z
        const DefaultView view = choose_view(state_of(scene_of(panel)));
        EXPECT_EQ(view.eye.z < 0, away);
        const Scene scene = scene_of(panel);
        glm::dmat4 world(view.axes);
        world[3] = glm::dvec4(view.eye, 1);
        EXPECT_GT(test_image_of(state_of(scene), view.camera, world).shown(), 0.2f);
    }
}

TEST(TestImage, ShowsFrontsAtTheirDepths)
{
    Mesh mesh;
    add_box(mesh, {-1, -1, -1}, {2, 2, 2}, false);
    const Scene scene = scene_of(mesh);
    const TestImage image = draw_test_image(state_of(scene), {0, 0, 5}, glm::dmat3(1), {.near = 0.1});
    const TestPixel& middle = image.pixels[image.pixels.size() / 2 + 32];
    EXPECT_NEAR(middle.depth, 4, 1e-5);
    EXPECT_NEAR(middle.normal.z, 1, 1e-6);
    EXPECT_NEAR(middle.position.z, 1, 1e-6);
    EXPECT_EQ(image.shown_of_all(), 1);
    const double expected = 1 / (4 * std::tan(0.35));   // half the cube's front over half the image
    EXPECT_NEAR(static_cast<double>(image.shown()), expected * expected, 0.02);
    // From inside, an outward box has no fronts; beyond the near plane nothing is drawn.
    EXPECT_EQ(draw_test_image(state_of(scene), {0, 0, 0}, glm::dmat3(1), {.near = 0.1}).shown(), 0);
    EXPECT_EQ(draw_test_image(state_of(scene), {0, 0, 5}, glm::dmat3(1), {.near = 10}).shown(), 0);
}

TEST(Surroundings, ObjectsStandInTheStudioOnAGround)
{
    Mesh mesh;
    add_box(mesh, {-1, 2, -1}, {2, 2, 2}, false);
    Scene scene = scene_of(mesh);
    const Statistics before = scene.statistics();
    const Box3 bounds = scene.bounds(0);
    add_default_camera(scene);
    add_surroundings(scene);
    EXPECT_EQ(scene.background.kind, Background::Kind::image);
    EXPECT_EQ(scene.background.environment, studio_environment());
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_TRUE(scene.objects[1].by_default);
    EXPECT_TRUE(scene.materials[scene.meshes[scene.objects[1].mesh].parts[0].material].catches_shadows);
    EXPECT_NEAR(scene.world_matrix(scene.objects[1].node, 0)[3].y, 2, 0.01);
    // It does not count.
    EXPECT_EQ(scene.statistics().triangles, before.triangles);
    EXPECT_EQ(scene.bounds(0).low, bounds.low);
    EXPECT_EQ(scene.bounds(0).high, bounds.high);
}

TEST(Surroundings, OwnLightsSufficeIfTheyReachHalfOfWhatIsInView)
{
    for (const bool reaches : {true, false}) {
        Mesh mesh;
        add_box(mesh, {-1, 0, -1}, {2, 2, 2}, false);
        Scene scene = scene_of(mesh);
        Light light;
        light.type = LightType::point;
        light.color = glm::vec3(10);
        light.node = scene.add_node("light", none);
        // In front of the faces that the camera sees, or behind.
        scene.nodes[light.node].local[3] = glm::dvec4(reaches ? 4 : -4, reaches ? 5 : -5, reaches ? 6 : -6, 1);
        scene.lights.push_back(light);
        scene.finish();
        add_default_camera(scene);
        EXPECT_EQ(reached_by_lights(scene).share >= 0.5f, reaches);
        const Scene bare = scene;
        SurroundingsOptions no_fill;
        no_fill.fill = 0;
        add_surroundings(scene, no_fill);
        EXPECT_EQ(scene.background.kind == Background::Kind::color, reaches);
        EXPECT_EQ(scene.objects.size(), reaches ? 1u : 2u);
        // What is beyond the box is not black in any case: a studio stands there whose light is a part of the file's.
        Scene filled = bare;
        add_surroundings(filled);
        ASSERT_EQ(filled.background.kind, Background::Kind::image);
        const float studio = luminance(studio_environment()->irradiance({0, 1, 0}));
        const float fill = luminance(filled.background.environment->irradiance({0, 1, 0}));
        EXPECT_NEAR(fill, reaches ? SurroundingsOptions{}.fill * reached_by_lights(bare).bright : studio, 0.01f * fill);
    }
}

TEST(Surroundings, RoomsAndImagesWithoutGapsKeepTheirLightsAlone)
{
    for (const bool close : {false, true}) {
        Mesh mesh;
        add_box(mesh, {-1, 0, -1}, {2, 2, 2}, true, close ? 63 : 31);   // open at high z
        add_box(mesh, {-0.3f, 0, -0.3f}, {0.6f, 0.8f, 0.6f}, false);
        Scene scene = scene_of(mesh);
        Light light;
        light.type = LightType::point;
        light.color = glm::vec3(1);
        light.node = scene.add_node("light", none);
        scene.nodes[light.node].local[3] = glm::dvec4(0, 1.8, 0.6, 1);
        scene.lights.push_back(light);
        scene.finish();
        add_default_camera(scene);
        add_surroundings(scene);
        EXPECT_EQ(scene.background.kind, Background::Kind::color) << close;
    }
}

// A floor on which something small stands is cut off by the image's sides. What stands there is whole, and large.
TEST(DefaultView, WideFloorsAreNotFramed)
{
    for (const float half : {1.4f, 8.0f}) {
        Scene scene;
        scene.materials.emplace_back();
        for (const bool floor : {true, false}) {
            Mesh mesh;
            if (floor)
                add_box(mesh, {-half, -0.01f, -half}, {2 * half, 0.01f, 2 * half}, false);
            else
                add_box(mesh, {-0.5f, 0, -0.5f}, {1, 1, 1}, false);
            scene.meshes.push_back(std::move(mesh));
            scene.nodes.emplace_back().mesh = floor ? 0 : 1;
        }
        scene.finish();
        const bool wide = half > 2;
        EXPECT_EQ(surrounding_objects(state_of(scene)).size(), wide ? 2u : 0u);
        const DefaultView view = choose_view(state_of(scene));
        glm::dmat4 world(view.axes);
        world[3] = glm::dvec4(view.eye, 1);
        const TestImage image = test_image_of(state_of(scene), view.camera, world);
        std::size_t box = 0;
        for (const TestPixel& pixel : image.pixels) box += pixel.object == 1;
        EXPECT_EQ(static_cast<float>(box) > 0.2f * static_cast<float>(image.pixels.size()), wide) << box;
    }
}

// The top of a box is lit, and its sides ten thousand times less, or a tenth as much.
TEST(Surroundings, WhatShowsBlackBesideTheRestIsNotReached)
{
    for (const bool dim : {true, false}) {
        Mesh mesh;
        add_box(mesh, {-1, 0, -1}, {2, 1, 2}, false);
        Scene scene = scene_of(mesh);
        const auto add_sun = [&](const glm::dvec3& towards, float lux) {
            Light light;
            light.type = LightType::directional;
            light.color = glm::vec3(lux);
            light.node = scene.add_node("sun", none);
            const glm::dvec3 back = glm::normalize(towards), right = glm::normalize(glm::cross({0, 0, 1}, back));
            scene.nodes[light.node].local =
                glm::dmat4(glm::dmat3(right, glm::cross(back, right), back));   // it shines along its -Z
            scene.lights.push_back(light);
        };
        add_sun({0, 1, 1e-9}, 10);
        add_sun({1, 0.1, 1}, dim ? 1e-3f : 1.0f);
        scene.finish();
        add_default_camera(scene);
        EXPECT_EQ(reached_by_lights(scene).share < 0.5f, dim);
    }
}

TEST(Surroundings, LandscapesLieUnderTheSky)
{
    Mesh mesh;
    add_box(mesh, {-20, -1, -15}, {40, 1, 30}, false);
    add_box(mesh, {-2, 0, -2}, {4, 6, 4}, false);
    Scene scene = scene_of(mesh);
    add_default_camera(scene);
    add_surroundings(scene);
    EXPECT_EQ(scene.background.kind, Background::Kind::sky);
    // What stands beside the landscape's edge casts its shadow on a ground.
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_TRUE(scene.objects[1].by_default);
}

TEST(Surroundings, GroundCanBeChosen)
{
    Mesh mesh;
    add_box(mesh, {-1, 0, -1}, {2, 2, 2}, false);
    Scene with = scene_of(mesh), without = with;
    for (Scene* scene : {&with, &without}) add_default_camera(*scene);
    SurroundingsOptions options;
    options.ground = false;
    add_surroundings(without, options);
    EXPECT_EQ(without.objects.size(), 1u);
    EXPECT_EQ(without.background.kind, Background::Kind::image);
    options.ground = true;
    add_surroundings(with, options);
    EXPECT_EQ(with.objects.size(), 2u);
}

TEST(Studio, LightsEvenlyAndHasSomethingToMirror)
{
    const auto studio = studio_environment();
    // A white surface that faces up, the camera or the sides is neither dark nor glaring.
    for (const glm::vec3& normal : {glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0)}) {
        EXPECT_GT(luminance(studio->ambient(normal)), 0.4f);
        EXPECT_LT(luminance(studio->ambient(normal)), 2.0f);
    }
    float least = k_infinity, most = 0;
    for (int i = 0; i < 64 * 32; ++i) {
        const float value =
            luminance(studio->radiance(Environment::direction_at((i % 64 + 0.5) / 64, (i / 64 + 0.5) / 32)));
        least = std::min(least, value), most = std::max(most, value);
    }
    EXPECT_GT(most / least, 15);
}

}   // namespace
}   // namespace gnomon::scene
