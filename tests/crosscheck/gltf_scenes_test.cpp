// SPDX-License-Identifier: Apache-2.0
// Real glTF scenes: static and moving triangles, frame counts and positions, against known values.
#include "io/load.h"
#include "scene/state.h"
#include "support.h"

namespace gnomon {
namespace {

struct Expected {
    const char* file;
    std::uint64_t moving, still, objects, objects_moving;
    int frames;
};

class GltfScenes : public testing::TestWithParam<Expected> {};

TEST_P(GltfScenes, CountsMatchKnownValues)
{
    const Expected& expected = GetParam();
    GNOMON_NEED_SCENE(file, expected.file);
    const scene::Scene scene = io::load_scene(file);
    const scene::Statistics statistics = scene.statistics();
    EXPECT_EQ(statistics.triangles_dynamic, expected.moving);
    EXPECT_EQ(statistics.triangles - statistics.triangles_dynamic, expected.still);
    EXPECT_EQ(statistics.objects, expected.objects);
    EXPECT_EQ(statistics.objects_dynamic, expected.objects_moving);
    EXPECT_EQ(scene.timeline.frames, expected.frames);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
}

INSTANTIATE_TEST_SUITE_P(Files, GltfScenes,
                         testing::Values(Expected{"gltf/CesiumMilkTruck.glb", 1536, 2088, 3, 2, 31},
                                         Expected{"gltf/BoxAnimated.glb", 62, 192, 2, 1, 90},
                                         Expected{"gltf/InterpolationTest.glb", 108, 2, 10, 9, 42},
                                         Expected{"gltf/cannon.glb", 2468, 0, 2, 2, 41},
                                         Expected{"cornell/refpt/cornell_box.gltf", 0, 34, 1, 0, 1}));

TEST(GltfTruck, WheelsRotateAboutTheirAxlesAndNothingElseMoves)
{
    GNOMON_NEED_SCENE(file, "gltf/CesiumMilkTruck.glb");
    auto scene = std::make_shared<scene::Scene>(io::load_scene(file));
    scene::SceneState state(scene, 0);
    std::vector<scene::ObjectId> wheels;
    for (std::size_t o = 0; o < scene->objects.size(); ++o)
        if (scene->objects[o].dynamic) wheels.push_back(static_cast<scene::ObjectId>(o));
    ASSERT_EQ(wheels.size(), 2u);
    const glm::mat4 before = state.object_matrix(wheels[0]);
    EXPECT_EQ(state.advance(0.4).moved, wheels);
    const glm::mat4 after = state.object_matrix(wheels[0]);
    // The axle (z) and the position stay; the spokes (x) rotate.
    EXPECT_LT(glm::length(after[2] - before[2]), 1e-6f);
    EXPECT_LT(glm::length(after[3] - before[3]), 1e-6f);
    EXPECT_GT(glm::length(after[0] - before[0]), 0.1f);
}

TEST(GltfCornell, CameraAndColoursMatchKnownValues)
{
    GNOMON_NEED_SCENE(file, "cornell/refpt/cornell_box.gltf");
    const scene::Scene scene = io::load_scene(file);
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_EQ(glm::dvec3(scene.world_matrix(scene.cameras[0].node, 0)[3]), glm::dvec3(0, 1, 3.5));
    ASSERT_EQ(scene.materials.size(), 3u);
    EXPECT_EQ(scene.materials[1].base_color, glm::vec3(0.63f, 0.065f, 0.05f));
    EXPECT_EQ(scene.materials[1].metallic, 0);
    EXPECT_EQ(scene.materials[1].roughness, 1);
}

}   // namespace
}   // namespace gnomon
