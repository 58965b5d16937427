// SPDX-License-Identifier: Apache-2.0
// What an image shows behind a scene, and the ground that catches shadows.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

// A cube, as a file without light, camera or material.
Scene cube(const test::ScratchFolder& scratch, std::optional<bool> ground = {})
{
    const auto file = scratch / "cube.obj";
    std::ofstream out(file);
    for (int i = 0; i < 8; ++i) out << "v " << (i & 1) << " " << (i >> 1 & 1) << " " << (i >> 2 & 1) << "\n";
    out << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    out.close();
    LoadOptions options;
    options.ground = ground;
    return load(file.string(), options);
}

RenderOptions small(BackgroundKind background)
{
    RenderOptions options;
    options.size = {96, 96};
    options.background = background;
    return options;
}

TEST(Background, GroundShowsTheStudioWhereNothingHidesIt)
{
    const test::ScratchFolder scratch;
    Renderer with(small(BackgroundKind::environment)), without(small(BackgroundKind::environment));
    const Frame ground = with.render(cube(scratch), 1), bare = without.render(cube(scratch, false), 1);
    const Layer &a = ground.layers[0], &b = bare.layers[0];
    // At the image's lower corners, far from the cube, the ground is nearly as bright as what lies behind it.
    for (const int x : {0, 95}) EXPECT_NEAR(a.value(x, 95, 1) / b.value(x, 95, 1), 1, 0.12);
    // Beside the cube's lower edge there is a shadow.
    float darkest = 1;
    for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 96; ++x) {
            if (a.value(x, y, 1) == b.value(x, y, 1)) continue;
            darkest = std::min(darkest, a.value(x, y, 1) / b.value(x, y, 1));
        }
    EXPECT_LT(darkest, 0.6f);
    // Above the horizon, nothing changes.
    for (int x = 0; x < 96; x += 5) EXPECT_EQ(a.value(x, 0, 0), b.value(x, 0, 0));
}

TEST(Background, GroundHasNoId)
{
    const test::ScratchFolder scratch;
    RenderOptions options = small(BackgroundKind::environment);
    options.ids = true;
    Renderer with(options), without(options);
    const Frame ground = with.render(cube(scratch), 1), bare = without.render(cube(scratch, false), 1);
    const Layer &a = *ground.layer("id"), &b = *bare.layer("id");
    int cube_pixels = 0;
    for (int y = 0; y < 96; ++y)
        for (int x = 0; x < 96; ++x) {
            EXPECT_EQ(a.id(x, y), b.id(x, y));
            cube_pixels += a.id(x, y) != 0;
        }
    EXPECT_GT(cube_pixels, 500);
    EXPECT_EQ(a.id(0, 95), 0u);
    // The lower corner shows the ground.
    EXPECT_FALSE(with.pick(0, 95).hit);
    EXPECT_TRUE(with.pick(48, 48).hit);
}

TEST(Background, DoesNotChangeTheExposure)
{
    const test::ScratchFolder scratch;
    std::vector<double> exposures;
    for (const BackgroundKind background :
         {BackgroundKind::environment, BackgroundKind::color, BackgroundKind::transparent}) {
        RenderOptions options = small(background);
        options.exposure.reset();
        Renderer renderer(options);
        exposures.push_back(renderer.render(cube(scratch), 1).exposure);
    }
    EXPECT_NE(exposures[0], 0);
    EXPECT_NEAR(exposures[1], exposures[0], 0.05);
    EXPECT_EQ(exposures[2], exposures[1]);
}

TEST(Background, TransparentKeepsTheSceneAndItsShadowsAlone)
{
    const test::ScratchFolder scratch;
    Renderer renderer(small(BackgroundKind::transparent));
    const Frame frame = renderer.render(cube(scratch), 1);
    const Layer* alpha = frame.layer("alpha");
    ASSERT_TRUE(alpha);
    EXPECT_EQ(alpha->value(48, 48), 1);
    EXPECT_LT(alpha->value(0, 95), 0.12f);
    EXPECT_EQ(alpha->value(0, 0), 0);
    EXPECT_EQ(frame.layers[0].value(0, 95, 1), 0);   // the ground has no colour
    int shadows = 0;
    for (const float a : alpha->values()) shadows += a > 0.2f && a < 0.95f;
    EXPECT_GT(shadows, 50);
    // Without a ground there are no shadows.
    Renderer bare(small(BackgroundKind::transparent));
    const Frame floating = bare.render(cube(scratch, false), 1);
    for (const float a : floating.layer("alpha")->values()) EXPECT_TRUE(a == 0 || a == 1);
    // PNG: four channels, the colour not multiplied.
    const std::vector<std::uint8_t> bytes = frame.to_srgb8_alpha();
    EXPECT_EQ(bytes.size(), std::size_t{96} * 96 * 4);
    EXPECT_EQ(bytes[(48 * 96 + 48) * 4 + 3], 255);
    frame.write(scratch / "cube.png");
    frame.write(scratch / "cube.exr");
}

TEST(Background, OneColourIsShownAsItIs)
{
    const test::ScratchFolder scratch;
    RenderOptions options = small(BackgroundKind::color);
    options.background_color[0] = 1, options.background_color[1] = 0.8f, options.background_color[2] = 0;
    options.exposure = 2;
    Renderer renderer(options);
    const Frame frame = renderer.render(cube(scratch), 1);
    const std::vector<std::uint8_t> bytes = frame.to_srgb8();
    EXPECT_EQ(bytes[0], 255);
    EXPECT_EQ(bytes[1], 204);
    EXPECT_EQ(bytes[2], 0);
    EXPECT_NE(bytes[(48 * 96 + 48) * 3 + 2], 0);
    // A host's memory gets the same.
    std::vector<std::uint8_t> rgba(std::size_t{96} * 96 * 4);
    FrameInput input;
    Output output;
    output.format = PixelFormat::rgba8;
    output.data = rgba.data(), output.bytes = rgba.size();
    input.outputs.push_back(output);
    renderer.render(cube(scratch), input);
    for (std::size_t p = 0; p < std::size_t{96} * 96; ++p)
        for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(rgba[4 * p + c], bytes[3 * p + c]);
}

TEST(Background, GlassShowsWhatIsBehindAndKeepsItsReflections)
{
    // A blended pane lets half of the backdrop through.
    SceneBuilder b;
    Material half;
    half.base_color = {0.5f, 0.5f, 0.5f};
    half.alpha = 0.5f;
    half.alpha_mode = AlphaMode::blend;
    half.double_sided = true;
    const Vec3 positions[] = {{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}};
    const std::uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    Mesh mesh;
    mesh.positions = positions, mesh.indices = indices;
    b.instance(b.mesh(mesh), {b.material(half)});
    Camera camera;
    camera.transform.m[14] = 5;
    b.camera(camera);
    const Scene scene = b.finish();
    Renderer renderer(small(BackgroundKind::transparent));
    const Frame frame = renderer.render(scene, 1);
    EXPECT_NEAR(frame.layer("alpha")->value(48, 48), 0.5f, 1e-6);
}

TEST(Background, RefusesWhatItCannotShow)
{
    RenderOptions options = small(BackgroundKind::transparent);
    options.overlay = Overlay::shadow_states;
    EXPECT_THROW(check_options(options), UsageError);
    options.overlay = Overlay::none;
    options.renderer = RenderMethod::raster;
    EXPECT_NO_THROW(check_options(options));
    options = small(BackgroundKind::color);
    options.background_color[1] = 2;
    EXPECT_THROW(check_options(options), UsageError);
}

TEST(Background, BuiltInStudioReplacesOtherSurroundings)
{
    const test::ScratchFolder scratch;
    const Scene scene = load("builtin:cornell").with_environment("builtin:studio");
    EXPECT_EQ(scene.info().lights.size(), 17u);
    // Lights that the user gives replace a studio that came by itself.
    const Scene lit = cube(scratch).with_light_specs({"point 0 5 0 10 10 10"});
    EXPECT_EQ(lit.lights().size(), 1u);
    Renderer renderer(small(BackgroundKind::environment));
    EXPECT_EQ(renderer.render(lit, 1).layers[0].value(0, 95, 1), 0);
}

}   // namespace
}   // namespace gnomon
