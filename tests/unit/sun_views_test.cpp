// SPDX-License-Identifier: Apache-2.0
// The views of a sun, over a scene that stands on a wide ground.

#include <gtest/gtest.h>

#include "light_views/projection.h"
#include "scene/scene_bounds.h"
#include "scene_helpers.h"

namespace gnomon::light_views {
namespace {

// Half the width of a view.
float half_width(const ViewProjection& view)
{
    return glm::length(view.across);
}

bool contains(const ViewProjection& view, const glm::vec3& point)
{
    const glm::vec4 clip = view.clip_from_world * glm::vec4(point, 1);
    return std::max(std::abs(clip.x), std::abs(clip.y)) <= 1.001f && clip.z >= -1e-3f && clip.z <= 1.001f;
}

TEST(SunViews, GetWiderStepByStep)
{
    scene::Light sun;
    sun.type = scene::LightType::directional;
    scene::LightState state;
    state.direction = glm::normalize(glm::vec3(1, -2, 0.5f));
    SceneBounds bounds;
    bounds.whole.add(glm::vec3(-500, 0, -500)), bounds.whole.add(glm::vec3(500, 10, 500));
    bounds.dense.add(glm::vec3(440, 0, 20)), bounds.dense.add(glm::vec3(450, 10, 30));
    ProjectionOptions options;
    EXPECT_EQ(view_count(sun, bounds, options), 2);
    options.widening = 8;
    ASSERT_EQ(view_count(sun, bounds, options), 4);   // the whole is 82 times as wide
    const std::vector<ViewProjection> views = project(sun, state, bounds, 256, options);
    ASSERT_EQ(views.size(), 4u);
    for (std::size_t v = 1; v < views.size(); ++v) {
        EXPECT_GT(half_width(views[v]), 1.5f * half_width(views[v - 1]));
        EXPECT_LT(half_width(views[v]), 9 * half_width(views[v - 1]));
        for (const float x : {440.0f, 450.0f})
            for (const float z : {20.0f, 30.0f}) EXPECT_TRUE(contains(views[v], {x, 5, z})) << v;
    }
    for (const float x : {-499.0f, 499.0f})
        for (const float z : {-499.0f, 499.0f}) EXPECT_TRUE(contains(views.back(), {x, 5, z}));
    // Scenes that are not wide have the views of before.
    bounds.dense.add(glm::vec3(100, 0, -400));
    EXPECT_EQ(view_count(sun, bounds, options), 2);
}

// Of few triangles a tenth are a ground's: the ground that the library adds does not count, or the dense part of the
// bounds would reach to its horizon.
TEST(SunViews, AnAddedGroundIsNoDensePart)
{
    scene::Scene scene;
    scene.materials.resize(1);
    const auto add = [&](float half, bool by_default) {
        scene::Mesh mesh;
        mesh.positions = {{-half, 0, -half}, {-half, half, half}, {half, 0, half}, {half, 0, -half}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{0, 0, 2}};
        scene.meshes.push_back(std::move(mesh));
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1));
        scene.nodes.back().by_default = by_default;
    };
    add(1, false), add(300, true);
    scene.finish();
    const scene::SceneBounds bounds = scene::clip_bounds(scene);
    EXPECT_LT(bounds.dense.diagonal(), 4);
    EXPECT_GT(bounds.whole.diagonal(), 800);
}

}   // namespace
}   // namespace gnomon::light_views
