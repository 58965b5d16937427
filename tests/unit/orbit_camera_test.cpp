// SPDX-License-Identifier: Apache-2.0
#ifdef GNOMON_VIEWER
#include "viewer/orbit_camera.h"

#include <gtest/gtest.h>

#include "scene/builtin/builtin.h"

namespace gnomon::viewer {
namespace {

scene::View some_view()
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    const scene::SceneState state(scene, 0);
    return scene::make_view(state, 0, {64, 48});
}

void expect_near(const glm::vec3& a, const glm::vec3& b, float room)
{
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], room) << "axis " << axis;
}

TEST(OrbitCamera, StartsAtTheSceneCamera)
{
    const scene::View view = some_view();
    OrbitCamera camera;
    camera.follow(view, 2);
    const scene::View own = camera.view(view.size);
    expect_near(own.eye, view.eye, 1e-5f);
    expect_near(own.forward, view.forward, 1e-5f);
    expect_near(own.right, view.right, 1e-5f);
    expect_near(own.up, view.up, 1e-5f);
    EXPECT_FLOAT_EQ(own.pixel_spread, view.pixel_spread);
}

TEST(OrbitCamera, OrbitsItsPivotAndStaysUpright)
{
    OrbitCamera camera;
    camera.follow(some_view(), 2);
    const glm::vec3 pivot = camera.pivot();
    for (int i = 0; i < 20; ++i) {
        camera.orbit(0.3f, 0.2f);
        const scene::View view = camera.view({64, 48});
        EXPECT_NEAR(glm::length(view.eye - pivot), 2, 1e-4f);
        expect_near(view.eye + 2.0f * view.forward, pivot, 1e-4f);
        EXPECT_GT(view.up.y, 0) << "the camera stays upright";
    }
    camera.zoom(0.5f);
    EXPECT_NEAR(glm::length(camera.view({64, 48}).eye - pivot), 1, 1e-4f);
}

TEST(OrbitCamera, LooksAndFliesFromTheEye)
{
    OrbitCamera camera;
    camera.follow(some_view(), 2);
    const scene::View before = camera.view({64, 48});
    camera.look(0.4f, 0.1f);
    const scene::View after = camera.view({64, 48});
    expect_near(after.eye, before.eye, 1e-4f);
    EXPECT_GT(glm::dot(after.forward, before.right), 0) << "to the right";
    EXPECT_GT(after.forward.y, before.forward.y);
    camera.fly(1, 0, 0);
    expect_near(camera.view({64, 48}).eye, after.eye + after.forward, 1e-4f);
    const glm::vec3 target(0.3f, 0.2f, -0.1f);
    camera.aim(target);
    const scene::View aimed = camera.view({64, 48});
    expect_near(aimed.eye + camera.distance() * aimed.forward, target, 1e-4f);
}

TEST(OrbitCamera, PansByTheSameFractionOfTheViewAtAnyDistance)
{
    for (const float distance : {0.5f, 5.0f}) {
        OrbitCamera camera;
        camera.follow(some_view(), distance);
        const glm::vec3 before = camera.pivot();
        const scene::View view = camera.view({64, 48});
        camera.pan(0.5f, 0);   // half the height to the right: the scene follows the pointer, the eye moves left
        const glm::vec3 went = camera.pivot() - before;
        EXPECT_LT(glm::dot(went, view.right), 0);
        EXPECT_NEAR(glm::length(went), glm::length(view.up) * distance, 1e-3f * distance);
    }
}

}   // namespace
}   // namespace gnomon::viewer
#endif
