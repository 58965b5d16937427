// SPDX-License-Identifier: Apache-2.0
// Scenes far from the origin of their coordinates: the images of the same scene near it, and positions as in the file.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>

#include "gnomon/gnomon.h"
#include "scene/near_origin.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon {
namespace {

constexpr double k_east = 327680, k_north = -5242880;   // metres: survey coordinates, exact in single precision

// A block on a floor of 16 x 16 m, whose vertices lie at an offset.
std::string block_on_floor(double east, double north)
{
    std::string text;
    const auto corner = [&](double x, double y, double z) {
        text += fmt::format("v {:.4f} {:.4f} {:.4f}\n", x + east, y, z + north);
    };
    for (const auto& [x, z] : {std::pair(-8.0, -8.0), {-8.0, 8.0}, {8.0, 8.0}, {8.0, -8.0}}) corner(x, 0, z);
    for (const double y : {0.0, 3.0})
        for (const auto& [x, z] : {std::pair(-2.0, -2.0), {-2.0, 2.0}, {2.0, 2.0}, {2.0, -2.0}}) corner(x, y, z);
    return text + "f 1 2 3 4\nf 9 10 11 12\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";
}

Scene loaded(const test::ScratchFolder& folder, double east, double north)
{
    std::ofstream(folder / "a.obj") << block_on_floor(east, north);
    LoadOptions options;
    options.ground = false;
    return load(folder / "a.obj", options);
}

RenderOptions small()
{
    RenderOptions options;
    options.size = {64, 64};
    return options;
}

// Before, rays left the floor some metres above it: contacts had dark rims.
TEST(NearOrigin, ASceneFarAwayLooksAsItDoesNearTheOrigin)
{
    const test::ScratchFolder folder;
    Renderer near(small()), far(small());
    const Frame expected = near.render(loaded(folder, 0, 0), 1), found = far.render(loaded(folder, k_east, k_north), 1);
    EXPECT_TRUE(expected.to_srgb8() == found.to_srgb8());
}

TEST(NearOrigin, PositionsAreThoseOfTheFile)
{
    const test::ScratchFolder folder;
    const Scene scene = loaded(folder, k_east, k_north);
    const SceneInfo info = scene.info();
    EXPECT_FLOAT_EQ(info.bounds_low[0], k_east - 8);
    EXPECT_FLOAT_EQ(info.bounds_high[2], k_north + 8);

    // A camera above the middle looks down on the block.
    Renderer renderer(small());
    FrameInput input;
    input.camera.emplace().transform =
        Transform::translation(k_east, 20, k_north) * Transform::rotation({1, 0, 0}, -1.5707963267948966);
    const Frame frame = renderer.render(scene, input);
    const Pick pick = renderer.pick(32, 32);
    ASSERT_TRUE(pick.hit);
    EXPECT_NEAR(pick.position.x, k_east, 1);
    EXPECT_NEAR(pick.position.y, 3, 1e-3);
    EXPECT_NEAR(pick.position.z, k_north, 1);
    EXPECT_NEAR(pick.depth, 17, 1e-3);
    EXPECT_FLOAT_EQ(renderer.bounds().low.x, k_east - 8);
    EXPECT_TRUE(renderer.camera() == *input.camera);
    // The middle of the image, by the frame's own matrix.
    const std::array<double, 16>& m = frame.world_to_image.m;
    const double x = m[0] * k_east + m[4] * 3 + m[8] * k_north + m[12];
    const double w = m[3] * k_east + m[7] * 3 + m[11] * k_north + m[15];
    EXPECT_NEAR(x / w, .5, 1e-6);

    // Transforms are handed over as they are reported.
    const InstanceId instance = scene.instances().front();
    EXPECT_NEAR(scene.transform(instance).m[12], 0, 1e-9);
    EXPECT_NEAR(renderer.world_transform(instance).m[12], 0, 1e-9);
    input.transforms = {{instance, Transform::translation(0, -1, 0)}};
    renderer.render(scene, input);
    EXPECT_NEAR(renderer.transform(instance).m[13], -1, 1e-9);
    EXPECT_NEAR(renderer.world_transform(instance).m[14], 0, 1e-9);
    EXPECT_NEAR(renderer.bounds().low.x, k_east, 64);   // spheres around what moves
}

// What a builder adds to a file is placed in the coordinates of the file, and so are lights that are given by numbers.
TEST(NearOrigin, PartsAreAddedInTheCoordinatesOfTheFile)
{
    const test::ScratchFolder folder;
    SceneBuilder builder(loaded(folder, k_east, k_north));
    const Vec3 corners[] = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}};
    const std::uint32_t indices[] = {0, 1, 2};
    const InstanceId added = builder.instance(builder.mesh({.positions = corners, .indices = indices}), {},
                                              Transform::translation(k_east, 5, k_north));
    const Scene scene = builder.finish();
    EXPECT_EQ(scene.transform(added).m[12], k_east);
    EXPECT_EQ(scene.transform(added).m[14], k_north);
    EXPECT_FLOAT_EQ(scene.info().bounds_high[1], 5);
    EXPECT_FLOAT_EQ(scene.info().bounds_low[0], k_east - 8);

    const Scene lit = scene.with_light_specs({fmt::format("point {} 9 {} 1 1 1", k_east, k_north)});
    EXPECT_EQ(lit.transform(lit.node(lit.lights().front())).m[12], k_east);
}

// A triangle of one metre that a root node's track places, and its mesh's distance from the origin of its coordinates.
scene::Scene moving_triangle(const glm::vec3& in_mesh)
{
    scene::Scene scene;
    scene.materials.emplace_back();
    scene::Mesh mesh;
    for (const glm::vec3& corner : {glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 1)})
        mesh.positions.push_back(in_mesh + corner);
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    scene.meshes.push_back(std::move(mesh));
    const scene::NodeId node = scene.add_node("moves", scene::none);
    const auto at = [&](double x) { return glm::translate(glm::dmat4(1), {x, 0, k_north}); };
    scene.nodes[node].transform = std::make_shared<test::JumpTrack>(1, at(k_east + 0.25), at(k_east + 1.25));
    scene.nodes[node].mesh = 0;
    scene.finish();
    return scene;
}

TEST(NearOrigin, TracksOfRootNodesAreReducedInDoublePrecision)
{
    scene::Scene scene = moving_triangle(glm::vec3(0));
    const glm::dmat4 before = scene.world_matrix(0, 0), after = scene.world_matrix(0, 2);
    const glm::dvec3 origin = scene::bring_near(scene);
    EXPECT_LT(glm::distance(origin, glm::dvec3(k_east, 0, k_north)), 8);
    EXPECT_EQ(glm::dvec3(scene.world_matrix(0, 0)[3]), glm::dvec3(before[3]) - origin);
    EXPECT_EQ(glm::dvec3(scene.world_matrix(0, 2)[3]), glm::dvec3(after[3]) - origin);
    EXPECT_EQ(scene.nodes[0].transform->changing().size(), 1u);
}

// Rays are traced in the mesh's own coordinates, whose step stays the same: what follows from it must fit them.
TEST(NearOrigin, AMovingMeshOfFarVerticesStays)
{
    scene::Scene scene = moving_triangle(glm::vec3(k_east, 0, 0));
    EXPECT_EQ(scene::bring_near(scene), glm::dvec3(0));
}

TEST(NearOrigin, ScenesNearTheOriginStay)
{
    const test::ScratchFolder folder;
    EXPECT_EQ(loaded(folder, 64, 0).info().bounds_low[0], 56);
    const Scene scene = loaded(folder, 64, 0);
    EXPECT_NEAR(scene.camera(scene.cameras().front()).transform.m[12], 64, 40);
}

}   // namespace
}   // namespace gnomon
