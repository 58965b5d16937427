// SPDX-License-Identifier: Apache-2.0
// Frames under an environment image and under suns with a size: closed forms, the reference, and the same bytes however
// they are made.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene/defaults/surroundings.h"

namespace gnomon {
namespace {

constexpr double k_half_turn = 3.14159265358979323846;

Material matte(float albedo)
{
    // Without a specular reflection.
    return {.base_color = {albedo, albedo, albedo}, .roughness = 1, .ior = 1};
}

// A ball of radius 1 with smooth normals.
MeshId add_ball(SceneBuilder& builder, int rings = 48)
{
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    const int around = 2 * rings;
    for (int r = 0; r <= rings; ++r)
        for (int a = 0; a <= around; ++a) {
            const double polar = k_half_turn * r / rings, turn = 2 * k_half_turn * (a % around) / around;
            positions.push_back({static_cast<float>(std::sin(polar) * std::cos(turn)),
                                 static_cast<float>(std::cos(polar)),
                                 static_cast<float>(-std::sin(polar) * std::sin(turn))});
        }
    for (int r = 0; r < rings; ++r)
        for (int a = 0; a < around; ++a) {
            const auto at = static_cast<std::uint32_t>(r * (around + 1) + a),
                       row = static_cast<std::uint32_t>(around + 1);
            indices.insert(indices.end(), {at, at + row, at + 1, at + 1, at + row, at + row + 1});
        }
    return builder.mesh({.positions = positions, .indices = indices, .normals = positions});
}

void set_even_sky(SceneBuilder& builder)
{
    const std::vector<float> white(2 * 3, 1.0f);
    builder.environment({.width = 2, .height = 1, .pixels = white});
}

// A sky that is blue above and brown below, with a bright square and a small sun.
std::vector<float> uneven_sky(int width, int height)
{
    std::vector<float> pixels(static_cast<std::size_t>(width * height * 3));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float* p = pixels.data() + 3 * (y * width + x);
            const float up = 1 - 2 * static_cast<float>(y) / static_cast<float>(height);
            p[0] = up > 0 ? 0.5f : 0.2f, p[1] = up > 0 ? 0.7f : 0.15f, p[2] = up > 0 ? 1.0f : 0.1f;
            if (x > width / 8 && x < width / 4 && y > height / 5 && y < height / 3) p[0] += 6, p[1] += 5, p[2] += 4;
            if (std::abs(x - 5 * width / 8) <= 1 && std::abs(y - height / 4) <= 1)
                p[0] += 400, p[1] += 380, p[2] += 350;
        }
    return pixels;
}

Camera orthographic(double height)
{
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 5}, {0, 0, 0});
    camera.orthographic_height = height;
    return camera;
}

std::vector<float> colours(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

RenderOptions options_of(int size)
{
    RenderOptions options;
    options.size = {size, size};
    options.indirect = Indirect::off;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

TEST(EnvironmentFrame, AMatteBallUnderAnEvenSkyIsEvenAtAllOrientations)
{
    constexpr float k_albedo = 0.5f;
    SceneBuilder builder;
    builder.instance(add_ball(builder), builder.material(matte(k_albedo)));
    set_even_sky(builder);
    builder.camera(orthographic(2.2));
    const std::vector<float> image = colours(Renderer(options_of(64)).render(builder.finish(), 1));
    double square = 0;
    int count = 0;
    for (const float value : image) {
        if (value > 0.9f) continue;   // the sky
        const double relative = static_cast<double>(value / k_albedo);
        EXPECT_GE(relative, 0.97);
        EXPECT_LE(relative, 1.005);
        square += (relative - 1) * (relative - 1), ++count;
    }
    ASSERT_GT(count, 3 * 64 * 64 / 2);
    EXPECT_LE(std::sqrt(square / count), 0.01);
}

// What reflects all light vanishes in an even sky, whatever its roughness.
TEST(EnvironmentFrame, WhiteMaterialsVanishInAnEvenSky)
{
    for (const float metallic : {0.0f, 1.0f})
        for (const float roughness : {0.0f, 0.04f, 0.08f, 0.12f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f}) {
            SceneBuilder builder;
            builder.instance(add_ball(builder),
                             builder.material({.base_color = {1, 1, 1}, .metallic = metallic, .roughness = roughness}));
            set_even_sky(builder);
            builder.camera(orthographic(2.2));
            double sum = 0;
            const std::vector<float> image = colours(Renderer(options_of(32)).render(builder.finish(), 1));
            for (const float value : image) {
                EXPECT_LE(value, 1.005f) << metallic << ' ' << roughness;
                EXPECT_GE(value, 0.9f) << metallic << ' ' << roughness;
                sum += static_cast<double>(value);
            }
            EXPECT_GE(sum / static_cast<double>(image.size()), 0.985) << metallic << ' ' << roughness;
        }
}

// Nor do balls beside each other, which light and mirror each other: what one lobe sees of the sky and of the others is
// all of the lobe, and bounced light comes from what hides the sky alone.
TEST(EnvironmentFrame, WhiteBallsBesideEachOtherShowNoMoreThanTheSky)
{
    struct Case {
        float metallic, roughness;
    };
    for (const auto& [metallic, roughness] :
         {Case{1, 0.1f}, Case{1, 0.35f}, Case{1, 0.75f}, Case{0, 0.1f}, Case{0, 0.35f}, Case{0, 0.5f}, Case{0, 1}}) {
        SceneBuilder builder;
        const MeshId ball = add_ball(builder);
        const MaterialId white =
            builder.material({.base_color = {1, 1, 1}, .metallic = metallic, .roughness = roughness});
        for (const Vec3& at : {Vec3{-1.02f, -0.6f, 0}, Vec3{1.02f, -0.6f, 0}, Vec3{0, 1.15f, 0}, Vec3{0, 0, -1.6f}})
            builder.instance(ball, white, Transform::translation(at.x, at.y, at.z));
        set_even_sky(builder);
        builder.camera(orthographic(4.6));
        double sum = 0;
        RenderOptions options = options_of(64);
        if (metallic == 0) options.indirect = Indirect::visible;
        const std::vector<float> image = colours(Renderer(options).render(builder.finish(), 1));
        int dark = 0;
        for (const float value : image) {
            EXPECT_LE(value, 1.005f) << metallic << ' ' << roughness;
            sum += static_cast<double>(value);
            if (value < 0.95f) ++dark;   // where paths end between the balls
        }
        EXPECT_GE(sum / static_cast<double>(image.size()), 0.985) << metallic << ' ' << roughness;
        EXPECT_LE(dark, static_cast<int>(image.size()) / 8) << metallic << ' ' << roughness;
    }
}

enum class Shapes : std::uint8_t { matte, metal };

// Balls on a floor: matte and glazed ones, or one of rough metal.
Scene shapes(Shapes which)
{
    SceneBuilder builder;
    const MeshId ball = add_ball(builder, 32);
    const std::vector<Vec3> square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> up{0, 2, 1, 0, 3, 2};
    const MaterialId grey = builder.material(matte(0.6f));
    builder.instance(builder.mesh({.positions = square, .indices = up}), grey,
                     Transform::translation(0, -1, 0) * Transform::scaling(12, 1, 12));
    if (which == Shapes::matte) {
        builder.instance(ball, grey, Transform::translation(-1.1, 0, 0));
        builder.instance(ball, grey, Transform::translation(1.1, 0, 0));
        builder.instance(ball, builder.material({.base_color = {0.6f, 0.2f, 0.2f}, .roughness = 0.5f}),
                         Transform::translation(0, 1.2, -0.8) * Transform::scaling(0.6, 0.6, 0.6));
    } else {
        builder.instance(ball, builder.material({.base_color = {0.9f, 0.8f, 0.6f}, .metallic = 1, .roughness = 0.4f}));
    }
    const std::vector<float> sky = uneven_sky(128, 64);
    builder.environment({.width = 128, .height = 64, .pixels = sky});
    Camera camera;
    camera.transform = Transform::look_at({1.5f, 2.2f, 5.5f}, {0, 0, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    return builder.finish();
}

struct Difference {
    double nrmse = 0, mean_ratio = 0;
};

Difference against_reference(Shapes which, int paths)
{
    RenderOptions options = options_of(40);
    const Scene scene = shapes(which);
    const std::vector<float> image = colours(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{paths, 0, 0};
    const std::vector<float> truth = colours(Renderer(options).render(scene, 1));
    double square = 0, sum = 0, sum_truth = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        square += std::pow(static_cast<double>(image[i] - truth[i]), 2);
        sum += static_cast<double>(image[i]), sum_truth += static_cast<double>(truth[i]);
    }
    const auto count = static_cast<double>(image.size());
    return {std::sqrt(square / count) / (sum_truth / count), sum / sum_truth};
}

TEST(EnvironmentFrame, ShapesUnderAnUnevenSkyAreAsTheReferenceHasThem)
{
    const Difference difference = against_reference(Shapes::matte, 4096);
    EXPECT_LE(difference.nrmse, 0.06);
    EXPECT_NEAR(difference.mean_ratio, 1, 0.01);
}

// The floor's image in the metal is missing from neither.
TEST(EnvironmentFrame, RoughMetalReflectsWhatTheReferenceSays)
{
    const Difference difference = against_reference(Shapes::metal, 2048);
    EXPECT_LE(difference.nrmse, 0.1);
    EXPECT_NEAR(difference.mean_ratio, 1, 0.02);
}

// Each frame of a clip with dynamic objects: after other frames, alone, on one thread, and without what is remembered.
// The ground that a scene without surroundings gets shows what lies behind it where nothing stands, and a shadow below
// what does: in frames and in the reference.
TEST(EnvironmentFrame, AGroundCatchesTheShadowThatTheReferenceSays)
{
    SceneBuilder builder;
    builder.instance(add_ball(builder), builder.material(matte(0.2f)));
    scene::Scene made = *api::scene_of(builder.finish());
    scene::add_default_camera(made);
    scene::add_surroundings(made, {.ground = true});
    const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(std::move(made)));
    RenderOptions options = options_of(48);
    options.indirect = Indirect::visible;
    const std::vector<float> image = colours(Renderer(options).render(scene, 1));
    options.reference = ReferenceLightOptions{.spp = 256};
    const std::vector<float> reference = colours(Renderer(options).render(scene, 1));
    // By blocks in the lowest part of the image, which shows the ground.
    constexpr int k_size = 48, k_block = 8;
    float least = 1e9f, most = 0;
    for (int x0 = 0; x0 < k_size; x0 += k_block) {
        double sum = 0, truth = 0;
        for (int y = k_size - k_block / 2; y < k_size; ++y)
            for (int x = x0; x < x0 + k_block; ++x) {
                sum += static_cast<double>(image[static_cast<std::size_t>(3 * (y * k_size + x) + 1)]);
                truth += static_cast<double>(reference[static_cast<std::size_t>(3 * (y * k_size + x) + 1)]);
            }
        EXPECT_NEAR(sum / truth, 1, 0.07) << x0;
        least = std::min(least, static_cast<float>(truth)), most = std::max(most, static_cast<float>(truth));
    }
    EXPECT_LT(least, 0.9f * most);
}

TEST(EnvironmentFrame, HasTheSameBytesColdWarmAndOnAnyNumberOfThreads)
{
    SceneBuilder sky(load("builtin:spheres?objects=20&dynamic=5"));
    const std::vector<float> pixels = uneven_sky(64, 32);
    sky.environment({.width = 64, .height = 32, .pixels = pixels});
    const Scene scene = sky.finish();
    RenderOptions options = options_of(64);
    options.sun_size = 2;
    Renderer warm(options);
    for (const int frame : {1, 2, 3, 3, 10}) {
        const std::vector<float> image = colours(warm.render(scene, frame));
        EXPECT_EQ(colours(Renderer(options).render(scene, frame)), image) << frame;
        RenderOptions one = options;
        one.threads = 1;
        EXPECT_EQ(colours(Renderer(one).render(scene, frame)), image) << frame;
        one.shadow_culling = ShadowCulling::off;
        EXPECT_EQ(colours(Renderer(one).render(scene, frame)), image) << frame;
    }
}

// A still view traces no ray again.
TEST(EnvironmentFrame, AStillViewCostsNoRays)
{
    const Scene scene = shapes(Shapes::matte);
    Renderer renderer(options_of(64));
    EXPECT_GT(renderer.render(scene, 1).counters.shadow.rays, 10'000u);
    renderer.render(scene, 1);
    EXPECT_EQ(renderer.render(scene, 1).counters.shadow.rays, 0u);
}

// A preview casts few rays, shows about the same, and leaves no trace in other frames, nor these in it.
TEST(EnvironmentFrame, APreviewShowsRoughlyTheSameWithFewRays)
{
    SceneBuilder sky(load("builtin:spheres?objects=20&dynamic=5"));
    const std::vector<float> pixels = uneven_sky(64, 32);
    sky.environment({.width = 64, .height = 32, .pixels = pixels});
    const Scene moving = sky.finish();
    for (const Scene& scene : {shapes(Shapes::matte), shapes(Shapes::metal), moving})
        for (const bool interactive : {false, true}) {
            RenderOptions options = options_of(64);
            options.interactive = interactive;
            FrameInput input, preview;
            input.frame = preview.frame = scene.frame_count();
            preview.preview = true;
            Renderer fresh(options), kept(options);
            const Frame truth = fresh.render(scene, input), rough = kept.render(scene, preview);
            EXPECT_FALSE(rough.complete);
            EXPECT_TRUE(truth.complete);
            EXPECT_LT(2 * rough.counters.shadow.rays, truth.counters.shadow.rays);
            const std::vector<float> image = colours(truth), about = colours(rough);
            double square = 0, sum = 0, sum_about = 0;
            for (std::size_t i = 0; i < image.size(); ++i) {
                square += std::pow(static_cast<double>(about[i] - image[i]), 2);
                sum += static_cast<double>(image[i]), sum_about += static_cast<double>(about[i]);
            }
            EXPECT_NEAR(sum_about / sum, 1, 0.02);
            EXPECT_LT(std::sqrt(square / static_cast<double>(image.size())),
                      0.1 * sum / static_cast<double>(image.size()));
            EXPECT_NE(about, image);

            EXPECT_EQ(colours(kept.render(scene, input)), image) << "after a preview";
            EXPECT_EQ(colours(kept.render(scene, preview)), about) << "after a frame";
            options.shadow_culling = ShadowCulling::off;
            kept.set_options(options);
            EXPECT_EQ(colours(kept.render(scene, preview)), about);
            EXPECT_EQ(colours(kept.render(scene, input)), image);
        }

    // What sees all of the image above it is the same.
    FrameInput preview;
    preview.preview = true;
    SceneBuilder builder;
    builder.instance(add_ball(builder), builder.material(matte(0.5f)));
    set_even_sky(builder);
    builder.camera(orthographic(2.2));
    const Scene ball = builder.finish();
    EXPECT_EQ(colours(Renderer(options_of(32)).render(ball, preview)),
              colours(Renderer(options_of(32)).render(ball, 1)));
    // Nothing is rough without an image.
    EXPECT_TRUE(Renderer(options_of(32)).render(load("builtin:cornell"), preview).complete);
}

// A turned image, frame by frame, with the renderer kept: the bytes of a new one. Rays go to what changed alone: of an
// even sky next to nothing, of one with a sun the cells that the sun left and those where it is now.
TEST(EnvironmentFrame, ATurnedImageKeepsWhatIsSeenInOtherDirections)
{
    for (const bool has_sun : {false, true})
        for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
            std::vector<float> sky = uneven_sky(64, 32);
            if (!has_sun)
                for (float& value : sky) value = std::min(value, 1.0f);
            const auto image_turned = [&](std::size_t by) {
                std::vector<float> pixels(sky.size());
                for (std::size_t y = 0; y < 32; ++y)
                    for (std::size_t x = 0; x < 64; ++x)
                        for (std::size_t c = 0; c < 3; ++c)
                            pixels[3 * (64 * y + (x + by) % 64) + c] = sky[3 * (64 * y + x) + c];
                return pixels;
            };
            RenderOptions options = options_of(32);
            options.indirect = indirect;
            SceneBuilder builder(load("builtin:spheres?objects=20&dynamic=0"));
            std::vector<float> pixels = image_turned(0);
            builder.environment({.width = 64, .height = 32, .pixels = pixels});
            Scene scene = builder.finish();
            Renderer kept(options);
            const FrameInput input;
            const std::uint64_t first = kept.render(scene, input).counters.shadow.rays;
            kept.render(scene, input);   // points remember from the second frame on
            for (const std::size_t by : {1, 40}) {
                pixels = image_turned(by);
                SceneBuilder edit(scene);
                edit.environment({.width = 64, .height = 32, .pixels = pixels});
                scene = edit.finish();
                const Frame frame = kept.render(scene, input);
                EXPECT_EQ(colours(frame), colours(Renderer(options).render(scene, input))) << by;
                EXPECT_LT(frame.counters.shadow.rays, has_sun ? first * 4 / 5 : first / 14) << by;
            }
            // While the last image stays, a frame costs what it costs without others before it.
            Renderer other(options);
            std::uint64_t still = 0;
            for (int frame = 0; frame < 3; ++frame) still = other.render(scene, input).counters.shadow.rays;
            EXPECT_LT(still, first / 100);
            kept.render(scene, input);
            EXPECT_EQ(kept.render(scene, input).counters.shadow.rays, still);
        }
}

// The floor under a straight edge: the visible part of the sun's disc is a segment of a circle.
TEST(SunFrame, HasThePenumbraOfADisc)
{
    constexpr double k_height = 0.5, k_diameter = 16;
    constexpr int k_size = 40;
    const std::vector<Vec3> square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> up{0, 2, 1, 0, 3, 2}, down{0, 1, 2, 0, 2, 3};
    SceneBuilder builder;
    const MaterialId grey = builder.material(matte(0.5f));
    builder.instance(builder.mesh({.positions = square, .indices = up}), grey, Transform::scaling(20, 1, 20));
    // A half-plane over x < 0, seen from below alone.
    builder.instance(builder.mesh({.positions = square, .indices = down}), grey,
                     Transform::translation(-50, k_height, 0) * Transform::scaling(100, 1, 100));
    builder.light({.type = LightType::directional, .color = {2, 2, 2}},
                  Transform::rotation({1, 0, 0}, -k_half_turn / 2));
    Camera camera;
    camera.transform = Transform::look_at({0, 5, 0}, {0, 0, 0}, {0, 0, -1});
    camera.orthographic_height = 0.5;
    builder.camera(camera);
    const Scene scene = builder.finish();
    RenderOptions options = options_of(k_size);
    options.sun_size = k_diameter;
    const double reach = k_height * std::tan(k_diameter / 2 * k_half_turn / 180);
    for (const bool reference : {false, true}) {
        if (reference) options.reference = ReferenceLightOptions{4, 0, 0};
        const std::vector<float> image = colours(Renderer(options).render(scene, 1));
        double square_sum = 0;
        for (int y = 0; y < k_size; ++y)
            for (int x = 0; x < k_size; ++x) {
                const double t = std::clamp(0.5 * ((x + 0.5) / k_size - 0.5) / reach, -1.0, 1.0);
                const double share = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / k_half_turn;
                const double value = static_cast<double>(image[static_cast<std::size_t>(3 * (y * k_size + x))]);
                const double error = value * k_half_turn - share;   // 2 lux, albedo .5
                EXPECT_NEAR(error, 0, 0.02) << x << ' ' << reference;
                square_sum += error * error;
            }
        EXPECT_LE(std::sqrt(square_sum / (k_size * k_size)), 0.01) << reference;
    }
}

// Without a size, nothing changes; with a small one, nearly nothing.
TEST(SunFrame, ASmallSunIsNearlyAPoint)
{
    const Scene scene = load("builtin:spheres?objects=20&dynamic=5");
    RenderOptions options = options_of(32);
    const std::vector<float> point = colours(Renderer(options).render(scene, 2));
    options.sun_size = 0.05;
    const std::vector<float> small = colours(Renderer(options).render(scene, 2));
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < point.size(); ++i)
        sum += std::abs(static_cast<double>(point[i] - small[i])), all += static_cast<double>(point[i]);
    EXPECT_LE(sum / all, 0.01);
}

}   // namespace
}   // namespace gnomon
