// SPDX-License-Identifier: Apache-2.0
// While the camera stands still, tiles keep the first hits that nothing changed, and images are those of renderers that
// remember nothing.
#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "gnomon/gnomon.h"
#include "same_frames.h"

namespace gnomon {
namespace {

// A room that is open to the sky on one side, with a mirror, three kinds of lights and three boxes that may move, of
// which one never does.
struct World {
    SceneBuilder builder;
    MaterialId grey, mirror;
    std::vector<InstanceId> boxes;
    LightId bulb;
    std::optional<Scene> made;
    const Scene& scene() const { return *made; }

    // @param alone  where there is one box in the light of one bulb behind it
    explicit World(float roughness = 0, const std::optional<Transform>& alone = {})
    {
        grey = builder.material({.base_color = {0.6f, 0.5f, 0.4f}});
        mirror = builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness});
        const std::vector<Vec3> square = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
        const std::vector<std::uint32_t> two = {0, 1, 2, 0, 2, 3};
        const MeshId flat = builder.mesh({.positions = square, .indices = two});
        builder.instance(flat, grey, Transform::scaling(3, 3, 3));
        builder.instance(flat, grey,
                         Transform::translation(-2.5, 1, 0) * Transform::rotation({0, 0, 1}, -1.5707963) *
                             Transform::scaling(1.5, 1, 3));
        builder.instance(flat, mirror,
                         Transform::translation(0.8, 1, -2) * Transform::rotation({1, 0, 0}, 1.5707963) *
                             Transform::scaling(1, 1, 1));
        const std::vector<Vec3> corners = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                           {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
        const std::vector<std::uint32_t> sides = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                                  1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
        const MeshId cube = builder.mesh({.positions = corners, .indices = sides});
        if (alone) {
            boxes.push_back(builder.instance(cube, grey, *alone, {.mobility = Mobility::may_move}));
            builder.light({.color = {12, 12, 10}}, Transform::translation(0.3, 2.2, 3));
            made = builder.finish();
            return;
        }
        for (int i = 0; i < 2; ++i)
            boxes.push_back(builder.instance(cube, grey, placed(i, 0), {.mobility = Mobility::may_move}));
        builder.instance(cube, grey, Transform::translation(1.2, 0.2, -0.6) * Transform::scaling(0.2, 0.2, 0.2),
                         {.mobility = Mobility::may_move});
        bulb = builder.light({.color = {12, 12, 10}}, Transform::translation(0.5, 2.2, 0.5));
        builder.light({.type = LightType::spot, .color = {15, 20, 25}, .outer_angle = 0.6},
                      Transform::look_at({-1.5, 2.5, 1.5}, {0, 0, 0}));
        builder.light({.type = LightType::directional, .color = {0.8f, 0.7f, 0.5f}},
                      Transform::look_at({3, 4, 2}, {0, 0, 0}));
        made = builder.finish();
    }
    static Transform placed(int box, double at)
    {
        return Transform::translation(box == 0 ? at : -1.2, 0.3 + 0.2 * box, box == 0 ? 0.4 : at) *
               Transform::scaling(0.15, 0.15, 0.15);
    }
};

RenderOptions options()
{
    RenderOptions of;
    of.size = {200, 130};
    of.samples = k_adaptive_samples;
    of.threads = 2;
    return of;
}

FrameInput input(float eye_x = 0, bool orthographic = false)
{
    Camera camera;
    camera.transform = Transform::look_at({eye_x, 1.7, 4}, {0, 0.5, 0});
    if (orthographic) camera.orthographic_height = 3.0;
    FrameInput of;
    of.time = 0.0;
    of.camera = camera;
    return of;
}

std::uint64_t pixels(const RenderOptions& of)
{
    return static_cast<std::uint64_t>(of.size.width) * static_cast<std::uint64_t>(of.size.height);
}

// Boxes move, vanish and come back; now and then a light or a material changes.
void expect_same_as_anew(const RenderOptions& of, bool orthographic = false, float roughness = 0)
{
    const World world(roughness);
    Renderer renderer(of);
    FrameInput all = input(0, orthographic);
    int kept_frames = 0;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-1.5, 1.5);
    for (int frame = 0; frame < 12; ++frame) {
        SCOPED_TRACE(testing::Message() << "frame " << frame);
        FrameInput change = input(0, orthographic);
        if (frame > 0) {
            const int box = frame % 2;
            change.transforms = {
                {NodeId(world.boxes[static_cast<std::size_t>(box)]), World::placed(box, place(random))}};
            std::erase_if(all.transforms, [&](const NodeTransform& t) { return t.node == change.transforms[0].node; });
            all.transforms.push_back(change.transforms[0]);
        }
        if (frame == 5 || frame == 7) {
            change.visibility = {{NodeId(world.boxes[1]), frame == 7}};
            all.visibility = change.visibility;
        }
        if (frame == 8) change.lights = all.lights = {{world.bulb, {.color = {5, 9, 12}}}};
        const Frame got = renderer.render(world.scene(), change);
        test::expect_same(got, Renderer(of).render(world.scene(), all));
        if (got.counters.primary_rays < pixels(of)) ++kept_frames;
    }
    // The first two frames, and those after another light, are traced whole.
    EXPECT_GE(kept_frames, 6);
}

TEST(KeptTiles, ImagesAreThoseOfNewRenderers)
{
    expect_same_as_anew(options());
}

TEST(KeptTiles, ImagesOfOneSampleAndOneBounceAreThoseOfNewRenderers)
{
    RenderOptions of = options();
    of.samples = 1, of.bounces = 1;
    expect_same_as_anew(of);
}

TEST(KeptTiles, RoughReflectionsAreThoseOfNewRenderers)
{
    expect_same_as_anew(options(), false, 0.35f);
}

TEST(KeptTiles, LightOfASunIsThatOfNewRenderers)
{
    RenderOptions of = options();
    of.sun_size = 4;
    expect_same_as_anew(of);
}

TEST(KeptTiles, ParallelViewsAreThoseOfNewRenderers)
{
    RenderOptions of = options();
    of.samples = 1, of.indirect = Indirect::off;
    expect_same_as_anew(of, true);
}

TEST(KeptTiles, LightOfTheQuadTreeIsThatOfNewRenderers)
{
    RenderOptions of = options();
    of.samples = 1, of.indirect = Indirect::quadtree;
    expect_same_as_anew(of);
}

// Cache points below a box that stands on the ground are left out as long as it stands there: the ground before it
// takes light from them again, although neither the box nor its shadow touches what is seen of it.
TEST(KeptTiles, TheGroundBeforeABoxIsThatOfNewRenderers)
{
    const auto placed = [](double x, double z) {
        return Transform::translation(x, 0.25, z) * Transform::scaling(0.25, 0.25, 0.25);
    };
    const World world(0, placed(0, 0));
    RenderOptions of = options();
    of.samples = 1;
    Renderer renderer(of);
    int kept_frames = 0;
    for (int frame = 0; frame < 10; ++frame) {
        SCOPED_TRACE(testing::Message() << "frame " << frame);
        FrameInput change = input();
        change.transforms = {{NodeId(world.boxes[0]), placed(0.05 * frame, 0.3 * (frame % 3))}};
        const Frame got = renderer.render(world.scene(), change);
        test::expect_same(got, Renderer(of).render(world.scene(), change));
        if (got.counters.primary_rays < pixels(of)) ++kept_frames;
    }
    EXPECT_GE(kept_frames, 6);
}

TEST(KeptTiles, ClipsOfAStillCameraAreThoseOfNewRenderers)
{
    RenderOptions of = options();
    of.size = {128, 96}, of.samples = 1;
    const Scene scene = load("builtin:cornell");
    Renderer renderer(of);
    for (int frame = 1; frame <= 6; ++frame) {
        const Frame got = renderer.render(scene, {.frame = frame});
        test::expect_same(got, Renderer(of).render(scene, {.frame = frame}));
        EXPECT_EQ(got.counters.primary_rays<pixels(of), frame> 2) << frame;
    }
}

// Neither frames of a camera that moves, nor measurements, nor frames that trace every shadow ray have any.
TEST(KeptTiles, BelongToACameraThatStandsStill)
{
    const World world;
    RenderOptions fresh = options();
    fresh.keep_image = false;
    RenderOptions every_ray = options();
    every_ray.shadow_culling = ShadowCulling::off;
    Renderer renderer(options()), measured(fresh), traced(every_ray);
    for (int frame = 0; frame < 5; ++frame) {
        FrameInput moves = input(0.1f * static_cast<float>(frame)), stands = input();
        moves.transforms = stands.transforms = {{NodeId(world.boxes[0]), World::placed(0, 0.1 * frame)}};
        EXPECT_GE(renderer.render(world.scene(), moves).counters.primary_rays, pixels(fresh));
        EXPECT_GE(measured.render(world.scene(), stands).counters.primary_rays, pixels(fresh));
        EXPECT_GE(traced.render(world.scene(), stands).counters.primary_rays, pixels(fresh));
    }
}

TEST(KeptTiles, DoNotOutliveACancelledFrame)
{
    const World world;
    Renderer renderer(options());
    const auto moved = [&](double at) {
        FrameInput of = input();
        of.transforms = {{NodeId(world.boxes[0]), World::placed(0, at)}};
        return of;
    };
    for (int frame = 0; frame < 3; ++frame) renderer.render(world.scene(), moved(0.1 * frame));
    int steps = 0;
    EXPECT_THROW(renderer.render(world.scene(), moved(1), [&](const ProgressStep&) { return ++steps < 8; }),
                 InterruptedError);
    test::expect_same(renderer.render(world.scene(), moved(0.5)),
                      Renderer(options()).render(world.scene(), moved(0.5)));
}

// Little memory costs time alone.
TEST(KeptTiles, TakeNoMoreMemoryThanThereIs)
{
    const World world;
    RenderOptions of = options();
    of.samples = 1, of.indirect = Indirect::off, of.memory = 8;
    Renderer renderer(of);
    for (int frame = 0; frame < 4; ++frame) {
        FrameInput change = input();
        change.transforms = {{NodeId(world.boxes[0]), World::placed(0, 0.1 * frame)}};
        test::expect_same(renderer.render(world.scene(), change), Renderer(of).render(world.scene(), change));
    }
}

}   // namespace
}   // namespace gnomon
