// SPDX-License-Identifier: Apache-2.0
// Values that a host hands over for the closing of the shutter, and surfaces that cameras do not see.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/pose_between.h"
#include "tests/host_scene.h"

namespace gnomon {
namespace {

using test::plain;
using test::square;

constexpr Size k_size{48, 16};

// A bright square in front of the camera that may move and deform.
struct Stage {
    test::Shape shape = square(0.5f);
    InstanceId instance;
    MaterialId glow, paint;
    LightId spot;
    Scene scene;

    Stage() : scene(make()) {}
    Scene make()
    {
        SceneBuilder builder;
        glow = builder.material(glow_of({1, 1, 1}));
        instance = builder.instance(builder.mesh(shape.mesh()), glow, place(0), {.mobility = Mobility::may_deform});
        // A wall behind it, under a spot beside them.
        paint = builder.material(paint_of(0.5f));
        builder.instance(builder.mesh(square(4).mesh()), paint, Transform::translation(0, 0, -6));
        spot = builder.light(spot_of(200, 0.2f), Transform::translation(3, 0, 0));
        return builder.finish();
    }
    static Material glow_of(const Vec3& color)
    {
        return {.model = ShadingModel::unlit, .base_color = color, .double_sided = true};
    }
    static Material paint_of(float grey) { return {.base_color = {grey, grey, grey}, .roughness = 1}; }
    static Light spot_of(float candela, float outer)
    {
        return {
            .type = LightType::spot, .color = {candela, candela, candela}, .inner_angle = 0.05f, .outer_angle = outer};
    }
    static Transform place(double x) { return Transform::translation(x, 0, -2); }
};

Camera camera_at(double x)
{
    Camera camera = test::camera_along_z();
    camera.transform = Transform::translation(x, 0, 0);
    return camera;
}

RenderOptions options(double shutter)
{
    RenderOptions made = plain(k_size);
    made.samples = k_adaptive_samples;
    made.shutter = shutter;
    made.exposure = 0;
    return made;
}

// The mean of sharp images, at even steps from the opening to the closing.
template <class InputAt>
std::vector<float> mean_of_steps(const Stage& stage, const InputAt& input_at)
{
    RenderOptions sharp = options(0);
    sharp.samples = 16;
    Renderer renderer(sharp);
    std::vector<float> sum;
    constexpr int k_steps = 64;
    for (int i = 0; i < k_steps; ++i) {
        const std::vector<float> image = renderer.render(stage.scene, input_at((i + 0.5) / k_steps)).layer("")->copy();
        sum.resize(image.size());
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += image[k] / k_steps;
    }
    return sum;
}

// An image of the shutter's opening, with the pixel filter of mean_of_steps().
std::vector<float> blurred(const Stage& stage, const FrameInput& input)
{
    RenderOptions made = options(180);
    made.samples = 64;
    return Renderer(made).render(stage.scene, input).layer("")->copy();
}

double mean_difference(const std::vector<float>& a, const std::vector<float>& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    return sum / static_cast<double>(a.size());
}

FrameInput from_camera(double x = 0)
{
    FrameInput input;
    input.time = 0.0;
    input.camera = camera_at(x);
    return input;
}

TEST(ClosingValues, ObjectsAreBlurredFromTheirPlaceAtTheOpeningToThatAtTheClosing)
{
    const Stage stage;
    FrameInput input = from_camera();
    input.transforms = {{stage.instance, Stage::place(-1), Stage::place(1)}};
    const Frame frame = Renderer(options(180)).render(stage.scene, input);
    const std::vector<float> truth = mean_of_steps(stage, [&](double at) {
        FrameInput step = from_camera();
        step.transforms = {{stage.instance, Stage::place(-1 + 2 * at)}};
        return step;
    });
    EXPECT_LT(mean_difference(frame.layer("")->copy(), truth), 0.02);
    // Layers that are not blurred are those of the middle.
    EXPECT_NE(frame.layer("id")->id(k_size.width / 2, k_size.height / 2), 0u);
}

// The middle of the trace of a square four pixels wide that moves by 160.
std::vector<float> trace_of_a_fast_square(double exposure)
{
    const Stage stage;
    RenderOptions made = options(180);
    made.size = {192, 32}, made.exposure = exposure;
    FrameInput input = from_camera();
    const auto narrow = [](double x) { return Stage::place(x) * Transform::scaling(0.5, 1, 1); };
    input.transforms = {{stage.instance, narrow(-10), narrow(10)}};
    input.lights = {{stage.spot, Stage::spot_of(0, 0.2f)}};
    const std::vector<float> image = Renderer(made).render(stage.scene, input).layer("")->copy();
    std::vector<float> values;
    for (int x = 24; x < 168; ++x)
        for (int y = 14; y < 18; ++y) values.push_back(image[static_cast<std::size_t>(3 * (y * made.size.width + x))]);
    return values;
}

// Seen at eight times alone, it was eight squares.
TEST(ClosingValues, AFastObjectLeavesAnEvenTrace)
{
    double sum = 0;
    const std::vector<float> values = trace_of_a_fast_square(0);
    for (const float value : values) {
        EXPECT_LT(value, 0.07f);
        sum += static_cast<double>(value);
    }
    EXPECT_NEAR(sum / static_cast<double>(values.size()), 4.0 / 160, 0.001);
}

// Where most pixels are far above white, those that met it by chance were as bright as those that did not were black.
TEST(ClosingValues, AFastBrightObjectLeavesNoBlackDots)
{
    for (const float value : trace_of_a_fast_square(9)) EXPECT_NEAR(value, 4.0f / 160, 0.6f * 4 / 160);
}

TEST(ClosingValues, VerticesAreBlurred)
{
    const Stage stage;
    const auto moved = [&](double x) {
        std::vector<Vec3> positions = stage.shape.positions;
        for (Vec3& p : positions) p.x += static_cast<float>(x);
        return positions;
    };
    const std::vector<Vec3> open = moved(-1), close = moved(1);
    FrameInput input = from_camera();
    input.vertices = {{.instance = stage.instance, .positions = open, .closing_positions = close}};
    const Frame frame = Renderer(options(180)).render(stage.scene, input);
    std::vector<Vec3> step_positions;
    const std::vector<float> truth = mean_of_steps(stage, [&](double at) {
        step_positions = moved(-1 + 2 * at);
        FrameInput step = from_camera();
        step.vertices = {{.instance = stage.instance, .positions = step_positions}};
        return step;
    });
    EXPECT_LT(mean_difference(frame.layer("")->copy(), truth), 0.02);
}

TEST(ClosingValues, LightsChangeWhileTheShutterIsOpen)
{
    const Stage stage;
    FrameInput input = from_camera();
    input.lights = {{stage.spot, Stage::spot_of(50, 0.1f), Stage::spot_of(400, 0.5f)}};
    const std::vector<float> image = blurred(stage, input);
    const std::vector<float> truth = mean_of_steps(stage, [&](double at) {
        const auto f = static_cast<float>(at);
        FrameInput step = from_camera();
        step.lights = {{stage.spot, Stage::spot_of(50 + 350 * f, 0.1f + 0.4f * f)}};
        return step;
    });
    input.lights[0].closing.reset();
    const std::vector<float> still = blurred(stage, input);
    EXPECT_GT(mean_difference(image, still), 0.005);
    EXPECT_LT(mean_difference(image, truth), 0.1 * mean_difference(image, still));
}

TEST(ClosingValues, MaterialsChangeWhileTheShutterIsOpen)
{
    const Stage stage;
    FrameInput input = from_camera();
    input.materials = {{stage.glow, Stage::glow_of({1, 0, 0}), Stage::glow_of({0, 0.5f, 1})},
                       {stage.paint, Stage::paint_of(0), Stage::paint_of(0.9f)}};
    const std::vector<float> image = blurred(stage, input);
    const std::vector<float> truth = mean_of_steps(stage, [&](double at) {
        const auto f = static_cast<float>(at);
        FrameInput step = from_camera();
        step.materials = {{stage.glow, Stage::glow_of({1 - f, 0.5f * f, f})}, {stage.paint, Stage::paint_of(0.9f * f)}};
        return step;
    });
    input.materials[0].closing.reset(), input.materials[1].closing.reset();
    const std::vector<float> still = blurred(stage, input);
    EXPECT_GT(mean_difference(image, still), 0.01);
    EXPECT_LT(mean_difference(image, truth), 0.05 * mean_difference(image, still));
}

TEST(ClosingValues, OfAnotherKindAreRefused)
{
    const Stage stage;
    Renderer renderer(options(180));
    FrameInput input = from_camera();
    Light sun = Stage::spot_of(5, 0.1f);
    sun.type = LightType::directional;
    input.lights = {{stage.spot, Stage::spot_of(5, 0.1f), sun}};
    EXPECT_NE(test::usage_error([&] { renderer.render(stage.scene, input); }), "");
    input.lights.clear();
    Material glass = Stage::paint_of(1);
    glass.transmission = 1;
    input.materials = {{stage.paint, Stage::paint_of(1), glass}};
    EXPECT_NE(test::usage_error([&] { renderer.render(stage.scene, input); }), "");
}

TEST(ClosingValues, CamerasAreBlurred)
{
    const Stage stage;
    FrameInput input = from_camera(-1);
    input.camera_closing = camera_at(1);
    const Frame frame = Renderer(options(180)).render(stage.scene, input);
    const std::vector<float> truth = mean_of_steps(stage, [&](double at) { return from_camera(-1 + 2 * at); });
    EXPECT_LT(mean_difference(frame.layer("")->copy(), truth), 0.02);
    FrameInput alone = from_camera();
    alone.camera.reset();
    alone.camera_closing = camera_at(1);
    Renderer renderer(options(180));
    EXPECT_NE(test::usage_error([&] { renderer.render(stage.scene, alone); }), "");
}

TEST(ClosingValues, HaveNoEffectWithoutAShutter)
{
    const Stage stage;
    FrameInput input = from_camera();
    input.transforms = {{stage.instance, Stage::place(-1)}};
    const std::vector<float> still = Renderer(options(0)).render(stage.scene, input).layer("")->copy();
    input.transforms = {{stage.instance, Stage::place(-1), Stage::place(1)}};
    EXPECT_EQ(Renderer(options(0)).render(stage.scene, input).layer("")->copy(), still);
}

// A blurred frame leaves what moved at some place of its way. The next frame must not show that.
TEST(ClosingValues, FramesAreThoseOfANewRendererWhateverWasBlurredBefore)
{
    const Stage stage;
    RenderOptions made = options(180);
    made.motion = true;
    Renderer kept(made);
    const auto input_of = [&](int frame) {
        FrameInput input = from_camera();
        // It stops where the shutter opened: after frames 2 and 4, only the closing value is gone.
        const double x = std::array{0.0, 0.2, 0.4, 0.4, 0.8, 0.8}[static_cast<std::size_t>(frame)];
        input.transforms = {{stage.instance, Stage::place(x)}};
        const bool changes = frame == 1 || frame == 2 || frame == 4;
        input.lights = {{stage.spot, Stage::spot_of(50, 0.4f)}};
        input.materials = {{stage.glow, Stage::glow_of({1, 0, 0})}};
        if (changes) input.transforms[0].closing = Stage::place(x + 0.5);
        if (changes) input.lights[0].closing = Stage::spot_of(300, 0.2f);
        if (changes) input.materials[0].closing = Stage::glow_of({0, 0, 1});
        return input;
    };
    for (int frame = 0; frame < 6; ++frame) {
        const std::vector<float> image = kept.render(stage.scene, input_of(frame)).layer("")->copy();
        const Frame fresh = Renderer(options(180)).render(stage.scene, input_of(frame));
        EXPECT_EQ(image, fresh.layer("")->copy()) << frame;
    }
    // Motion leads from the middle of the frame before, which was sharp, to the middle of this one.
    kept.render(stage.scene, input_of(0));
    const Frame moved = kept.render(stage.scene, input_of(1));
    const double pixels_per_metre = k_size.height / 2.0 / 2;
    EXPECT_NEAR(moved.layer("motion")->value(k_size.width / 2 + 2, k_size.height / 2), (0.2 + 0.25) * pixels_per_metre,
                1e-3);
}

TEST(PoseBetween, WhatTurnsKeepsItsSize)
{
    const glm::dmat4 first = glm::scale(glm::dmat4(1), glm::dvec3(2, 3, -1));
    const glm::dmat4 second = glm::rotate(glm::dmat4(1), 2.0, glm::dvec3(0, 0, 1)) * first;
    EXPECT_EQ(scene::pose_between(first, first, 0.3), first);
    for (const double fraction : {0.0, 0.25, 0.5, 1.0}) {
        const glm::dmat4 pose = scene::pose_between(first, second, fraction);
        EXPECT_NEAR(glm::length(glm::dvec3(pose[0])), 2, 1e-12);
        EXPECT_NEAR(glm::length(glm::dvec3(pose[1])), 3, 1e-12);
        EXPECT_LT(glm::determinant(pose), 0);
    }
    const glm::dmat4 half = scene::pose_between(first, second, 0.5);
    EXPECT_NEAR(std::atan2(half[0].y, half[0].x), 1.0, 1e-9);
    // What is skewed is blended element by element.
    glm::dmat4 skewed(1);
    skewed[1].x = 0.5;
    EXPECT_NEAR(scene::pose_between(skewed, glm::dmat4(1), 0.5)[1].x, 0.25, 1e-12);
}

// An emitter before a wall and beside a mirror.
struct LitWall {
    InstanceId emitter, wall;
    Scene scene;

    explicit LitWall(bool hidden) : scene(make(hidden)) {}
    Scene make(bool hidden)
    {
        SceneBuilder builder;
        const MaterialId paint = builder.material({.base_color = {0.5f, 0.5f, 0.5f}});
        wall = builder.instance(builder.mesh(square(4).mesh()), paint, Transform::translation(0, 0, -6));
        // It shines towards +Z: its axis is turned round.
        const Transform turned = Transform::rotation({0, 1, 0}, 3.141592653589793);
        AreaLight light;
        light.radiance = {5, 5, 5};
        light.hidden_from_camera = hidden;
        emitter = builder.area_light(light, Transform::translation(0, 0, -3) * turned).instance;
        return builder.finish();
    }
};

TEST(HiddenFromCamera, CamerasSeeWhatIsBehind)
{
    FrameInput input;
    input.camera = test::camera_along_z();
    const auto middle = [&](const LitWall& emitter) {
        const Frame frame = Renderer(plain({16, 16})).render(emitter.scene, input);
        return std::pair(frame.layer("")->value(8, 8), emitter.scene.instance_of(frame.layer("id")->id(8, 8)));
    };
    const LitWall seen(false), hidden(true);
    EXPECT_EQ(middle(seen), (std::pair<float, InstanceId>(5, seen.emitter)));
    EXPECT_EQ(middle(hidden).second, hidden.wall);
    EXPECT_LT(middle(hidden).first, 1);
    const Frame frame = Renderer(plain({16, 16})).render(hidden.scene, input);
    EXPECT_FLOAT_EQ(frame.layer("depth")->value(8, 8), 6);
}

TEST(HiddenFromCamera, MirrorsAndLightMeetItAllTheSame)
{
    const auto rendered = [](bool hidden) {
        SceneBuilder builder;
        AreaLight light;
        light.radiance = {5, 5, 5};
        light.hidden_from_camera = hidden;
        builder.area_light(light, Transform::translation(0, 0, 1));   // behind the camera, shining towards -Z
        const MaterialId mirror = builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0});
        builder.instance(builder.mesh(square(4).mesh()), mirror, Transform::translation(0, 0, -2));
        FrameInput input;
        input.camera = test::camera_along_z();
        return Renderer(plain({16, 16})).render(builder.finish(), input).layer("")->copy();
    };
    const std::vector<float> image = rendered(true);
    EXPECT_EQ(image, rendered(false));
    EXPECT_NEAR(image[3 * (8 * 16 + 8)], 5, 0.01f);
}

}   // namespace
}   // namespace gnomon
