// SPDX-License-Identifier: Apache-2.0
// Frames in which nothing changed have the layers of the frame before, at no cost; whatever changes is seen at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "same_frames.h"

namespace gnomon {
namespace {

// A room with a box that may move, a mirror and a lamp.
struct World {
    SceneBuilder builder;
    MaterialId grey, mirror;
    InstanceId box;
    LightId lamp;
    std::optional<Scene> made;
    const Scene& scene() const { return *made; }

    World()
    {
        grey = builder.material({.base_color = {0.6f, 0.5f, 0.4f}});
        mirror = builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0});
        const std::vector<Vec3> square = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
        const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3};
        const MeshId flat = builder.mesh({.positions = square, .indices = indices});
        builder.instance(flat, grey, Transform::scaling(3, 3, 3));
        builder.instance(
            flat, mirror,
            Transform::translation(0, 1, -2) * Transform::rotation({1, 0, 0}, 1.5707963) * Transform::scaling(2, 1, 1));
        box = builder.instance(flat, grey, Transform::translation(0, 0.5, 0) * Transform::scaling(0.4, 1, 0.4),
                               {.mobility = Mobility::may_move});
        lamp = builder.light({.color = {20, 20, 20}}, Transform::translation(0.5, 2, 0.5));
        const std::vector<float> sky = {0.2f, 0.3f, 0.4f, 0.1f, 0.1f, 0.1f};
        builder.environment({.width = 1, .height = 2, .pixels = sky});
        made = builder.finish();
    }
};

RenderOptions options()
{
    RenderOptions of;
    of.size = {32, 24};
    of.samples = k_adaptive_samples;
    of.layers = of.ids = true;
    return of;
}

FrameInput input(float eye_x = 0)
{
    Camera camera;
    camera.transform = Transform::look_at({eye_x, 1.5, 4}, {0, 0.5, 0});
    FrameInput of;
    of.time = 0.0;
    of.camera = camera;
    return of;
}

TEST(KeptImage, AStillFrameCostsNothingAndIsThatOfANewRenderer)
{
    const World world;
    Renderer renderer(options());
    const Frame first = renderer.render(world.scene(), input());
    EXPECT_FALSE(first.counters.kept_image);
    for (int again = 0; again < 3; ++again) {
        const Frame frame = renderer.render(world.scene(), input());
        EXPECT_TRUE(frame.counters.kept_image);
        EXPECT_EQ(frame.counters.primary_rays + frame.counters.shadow.rays + frame.counters.indirect.rays, 0u);
        EXPECT_TRUE(frame.complete);
        EXPECT_EQ(frame.exposure, first.exposure);
        test::expect_same(frame, Renderer(options()).render(world.scene(), input()));
    }
}

TEST(KeptImage, IsNotAskedForByMeasurements)
{
    const World world;
    RenderOptions fresh = options();
    fresh.keep_image = false;
    Renderer renderer(fresh);
    for (int again = 0; again < 3; ++again) {
        const Frame frame = renderer.render(world.scene(), input());
        EXPECT_FALSE(frame.counters.kept_image);
        EXPECT_GT(frame.counters.primary_rays, 0u);
    }
}

// Each change is seen at once; the frame after it is kept again, once things have come to rest.
TEST(KeptImage, EndsWithWhateverChanges)
{
    World world;
    Renderer renderer(options());
    RenderOptions now = options();
    renderer.render(world.scene(), input());
    FrameInput all = input();   // all that is in force
    const auto expect_new = [&](const FrameInput& change, const char* what) {
        SCOPED_TRACE(what);
        const Frame frame = renderer.render(world.scene(), change);
        EXPECT_FALSE(frame.counters.kept_image);
        test::expect_same(frame, Renderer(now).render(world.scene(), all));
        FrameInput same = input();
        same.camera = change.camera;
        renderer.render(world.scene(), same);
        EXPECT_TRUE(renderer.render(world.scene(), same).counters.kept_image);
        test::expect_same(renderer.render(world.scene(), same), Renderer(now).render(world.scene(), all));
    };

    FrameInput change = input(0.25f);
    all.camera = change.camera;
    expect_new(change, "camera");
    change.transforms = {{NodeId(world.box), Transform::translation(0.3, 0.6, 0) * Transform::scaling(0.4, 1, 0.4)}};
    all.transforms = change.transforms;
    expect_new(change, "moved object");
    change.transforms.clear();
    Light brighter{.color = {30, 20, 10}};
    change.lights = all.lights = {{world.lamp, brighter}};
    expect_new(change, "light");
    change.lights.clear();
    change.materials = all.materials = {{world.grey, {.base_color = {0.2f, 0.6f, 0.3f}}}};
    expect_new(change, "material");
    change.materials.clear();
    change.visibility = all.visibility = {{NodeId(world.box), false}};
    expect_new(change, "hidden object");
    change.visibility.clear();
    now.sun_size = 1;
    renderer.set_options(now);
    expect_new(change, "option");
    now.size = {33, 24};
    renderer.set_options(now);
    expect_new(change, "size");
    const std::vector<float> sky = {0.1f, 0.1f, 0.9f, 0.1f, 0.3f, 0.1f};
    world.builder.environment({.width = 1, .height = 2, .pixels = sky});
    world.made = world.builder.finish();
    expect_new(change, "environment");
}

TEST(KeptImage, SurvivesNeitherCancelledFramesNorOtherScenes)
{
    const World world, other;
    Renderer renderer(options());
    renderer.render(world.scene(), input());
    EXPECT_TRUE(renderer.render(world.scene(), input()).counters.kept_image);
    EXPECT_THROW(renderer.render(world.scene(), input(0.5f), [](const ProgressStep&) { return false; }),
                 InterruptedError);
    const Frame after = renderer.render(world.scene(), input());
    EXPECT_FALSE(after.counters.kept_image);
    test::expect_same(after, Renderer(options()).render(world.scene(), input()));
    EXPECT_FALSE(renderer.render(other.scene(), input()).counters.kept_image);
}

TEST(KeptImage, LayersOfFramesThatAHostKeepsStay)
{
    const World world;
    Renderer renderer(options());
    const Frame first = renderer.render(world.scene(), input()), second = renderer.render(world.scene(), input());
    const std::vector<float> before(first.layers.front().values().begin(), first.layers.front().values().end());
    const Frame third = renderer.render(world.scene(), input(0.7f));
    const auto held = second.layers.front().values();
    EXPECT_TRUE(std::equal(before.begin(), before.end(), held.begin(), held.end()));
    EXPECT_NE(third.layers.front().values().data(), held.data());
}

}   // namespace
}   // namespace gnomon
