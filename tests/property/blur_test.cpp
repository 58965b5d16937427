// SPDX-License-Identifier: Apache-2.0
// LONG: motion and lens share the scenes and the measures of these tests.
// Motion blur and depth of field: their closed forms, what they leave alone, and the same bytes however a frame is
// made.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "api/scene_access.h"
#include "base/random.h"
#include "frame/frame_engine.h"
#include "gnomon/gnomon.h"
#include "same_frames.h"
#include "scene/lens.h"
#include "scene/track.h"
#include "trace/blur.h"

namespace gnomon {
namespace {

using scene::NodeId;

// Moves evenly during the first second.
class EvenTrack final : public scene::TransformTrack {
 public:
    explicit EvenTrack(const glm::dvec3& from, const glm::dvec3& speed) : from_(from), speed_(speed) {}
    glm::dmat4 evaluate(double time) const override
    {
        return glm::translate(glm::dmat4(1), from_ + speed_ * std::clamp(time, 0.0, 1.0));
    }
    std::vector<scene::Interval> changing() const override { return {{0, 1}}; }

 private:
    glm::dvec3 from_, speed_;
};

struct Board {
    glm::vec3 color{1};
    float side = 1;
    glm::dvec3 at{0};
    glm::dvec3 speed{0};
    scene::ShadingModel model = scene::ShadingModel::unlit;
    float metallic = 0;
    double turn = 0;   // radians about Y
};

// Squares that face the viewer, who looks along -Z. At the clip's 13th frame, half a second has passed.
Scene boards(const std::vector<Board>& boards, double orthographic_height, const glm::dvec3& camera_speed = {})
{
    scene::Scene made;
    for (const Board& board : boards) {
        scene::Material material;
        material.model = board.model;
        material.base_color = board.color, material.roughness = 1, material.ior = 1;
        material.metallic = board.metallic;
        scene::Mesh mesh;
        const float s = board.side / 2;
        mesh.positions = {{-s, -s, 0}, {s, -s, 0}, {s, s, 0}, {-s, s, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{static_cast<scene::MaterialId>(made.materials.size()), 0, 2}};
        made.materials.push_back(material);
        const NodeId node = made.add_node("board", scene::none,
                                          glm::rotate(glm::translate(glm::dmat4(1), board.at), board.turn, {0, 1, 0}));
        made.nodes[node].mesh = static_cast<scene::MeshId>(made.meshes.size());
        made.meshes.push_back(mesh);
        if (board.speed != glm::dvec3(0))
            made.nodes[node].transform = std::make_shared<EvenTrack>(board.at - 0.5 * board.speed, board.speed);
    }
    scene::Camera camera;
    camera.orthographic_height = orthographic_height;
    camera.node = made.add_node("camera", scene::none, glm::dmat4(1));
    if (camera_speed != glm::dvec3(0))
        made.nodes[camera.node].transform = std::make_shared<EvenTrack>(-0.5 * camera_speed, camera_speed);
    made.cameras.push_back(camera);
    made.background.kind = scene::Background::Kind::color;
    made.background.color = glm::vec3(0);
    made.timeline.end = 1, made.timeline.frames = 25;
    made.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(made)));
}

constexpr int k_frame = 13;

double shown(float x)
{
    return std::sqrt(static_cast<double>(x) / (1 + static_cast<double>(x)));
}

RenderOptions options_of(int samples)
{
    return {.size = {64, 64}, .samples = samples, .exposure = 0, .indirect = Indirect::off, .threads = 2};
}

Frame frame_of(const Scene& scene, const RenderOptions& options, int frame = k_frame)
{
    return Renderer(options).render(scene, frame);
}

double sum_of(const Frame& frame)
{
    double sum = 0;
    for (int y = 0; y < frame.size.height; ++y)
        for (int x = 0; x < frame.size.width; ++x) sum += static_cast<double>(frame.layer("")->value(x, y));
    return sum;
}

// The share of a pixel's column that a square covers, which moves by `way` pixels: the overlap of the pixel with the
// square, averaged over the way.
double coverage(double column, double low, double high, double way)
{
    constexpr int k_steps = 4096;
    double sum = 0;
    for (int i = 0; i < k_steps; ++i) {
        const double moved = way * ((i + 0.5) / k_steps - 0.5);
        sum += std::max(0.0, std::min(column + 1, high + moved) - std::max(column, low + moved));
    }
    return sum / k_steps;
}

// A square of 20 pixels moves by 16 while the shutter is open.
TEST(MotionBlur, RampOfAMovingSquareIsLinear)
{
    const Scene scene = boards({{.side = 20, .at = {0, 0, -5}, .speed = {16 * 48, 0, 0}}}, 64);
    for (const int samples : {64, k_adaptive_samples}) {
        RenderOptions options = options_of(samples);
        options.shutter = 180;
        const Frame frame = frame_of(scene, options);
        for (int x = 0; x < 64; ++x)
            EXPECT_NEAR(frame.layer("")->value(x, 32), coverage(x, 22, 42, 16), samples > 0 ? 1.0 / 64 : 1.0 / 32)
                << "column " << x << ", samples " << samples;
        EXPECT_EQ(frame.layer("")->value(32, 5), 0);
    }
}

TEST(MotionBlur, AShutterOfTwiceTheAngleBlursTwiceAsFar)
{
    const Scene scene = boards({{.side = 10, .at = {0, 0, -5}, .speed = {12 * 48, 0, 0}}}, 64);
    for (const double shutter : {90.0, 180.0, 360.0}) {
        RenderOptions options = options_of(64);
        options.shutter = shutter;
        const Frame frame = frame_of(scene, options);
        const double way = 12 * shutter / 180;
        for (int x = 0; x < 64; ++x)
            EXPECT_NEAR(frame.layer("")->value(x, 32), coverage(x, 27, 37, way), 1.0 / 40) << shutter << " " << x;
    }
}

TEST(MotionBlur, AMovingCameraBlursAsTheSceneWould)
{
    const Scene by_camera = boards({{.side = 20, .at = {0, 0, -5}}}, 64, {-16 * 48, 0, 0});
    RenderOptions options = options_of(64);
    options.shutter = 180;
    const Frame frame = frame_of(by_camera, options);
    for (int x = 0; x < 64; ++x) EXPECT_NEAR(frame.layer("")->value(x, 32), coverage(x, 22, 42, 16), 1.0 / 64) << x;
}

// At the clip's first frame, nothing has moved before it.
TEST(MotionBlur, NothingMovesBeforeTheClip)
{
    const Scene scene = boards({{.side = 20, .at = {8 * 48, 0, -5}, .speed = {16 * 48, 0, 0}}}, 64);
    RenderOptions options = options_of(64);
    options.shutter = 180;
    const Frame frame = frame_of(scene, options, 1);
    for (int x = 0; x < 64; ++x) {
        const double at_rest = x >= 22 && x < 42 ? 1 : 0;
        const double moving = coverage(x, 26, 46, 8);
        EXPECT_NEAR(frame.layer("")->value(x, 32), 0.5 * (at_rest + moving), 1.0 / 32) << x;
    }
}

TEST(MotionBlur, WhatStandsStillHasTheSameBytes)
{
    // A moving square on the left, still ones on the right, lit, with a shadow far from the latter.
    const Scene scene = boards({{.side = 8, .at = {-20, 16, -5}, .speed = {6 * 48, 0, 0}},
                                {.color = {0.3f, 0.6f, 0.2f}, .side = 9.3f, .at = {18, -7.2, -6}},
                                {.color = {0.8f, 0.1f, 0.2f}, .side = 6.1f, .at = {15, -12.7, -4}}},
                               64);
    for (const int samples : {1, 4, k_adaptive_samples}) {
        RenderOptions options = options_of(samples);
        const Frame still = frame_of(scene, options);
        options.shutter = 180;
        Renderer renderer(options);
        const Frame blurred = renderer.render(scene, k_frame);
        std::size_t different = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                bool same = true;
                for (int c = 0; c < 3; ++c)
                    same = same && still.layer("")->value(x, y, c) == blurred.layer("")->value(x, y, c);
                if (x >= 30 || y >= 30) {
                    EXPECT_TRUE(same) << x << " " << y << ", samples " << samples;
                }
                different += !same;
            }
        EXPECT_GT(different, samples == 1 ? 0u : 20u);
        EXPECT_LT(blurred.counters.samples.pixels - still.counters.samples.pixels, 64u * 64 / 4);
    }
}

// The filter of many samples reaches from blurred pixels into sharp ones and back, as that of adaptive samples does.
TEST(MotionBlur, EveryNumberOfSamplesHasThePixelFilter)
{
    const Scene scene = boards({{.side = 12, .at = {-9, 0, -5}, .speed = {6 * 48, 0, 0}},
                                {.color = {0.3f, 0.6f, 0.2f}, .side = 9.5f, .at = {0.4, 9.3, -6}},
                                {.color = {0.8f, 0.1f, 0.2f}, .side = 15.5f, .at = {18.4, -12.7, -7}}},
                               64);
    const auto image = [&](int samples, PixelFilter filter, double shutter) {
        RenderOptions options = options_of(samples);
        options.filter = filter, options.shutter = shutter;
        return frame_of(scene, options);
    };
    const auto apart = [](const Frame& a, const Frame& b, int x, int y) {
        return std::abs(a.layer("")->value(x, y) - b.layer("")->value(x, y));
    };
    const Frame adaptive = image(k_adaptive_samples, PixelFilter::automatic, 180);
    const Frame many = image(64, PixelFilter::blackman_harris, 180), box = image(64, PixelFilter::box, 180);
    const Frame sharp = image(64, PixelFilter::blackman_harris, 0);
    float largest = 0, largest_of_box = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            // Far from what moves, the image is that without a shutter.
            if (x >= 40 || y < 8) {
                EXPECT_EQ(apart(many, sharp, x, y), 0) << x << " " << y;
            } else if (x < 36) {
                largest = std::max(largest, apart(many, adaptive, x, y));
                largest_of_box = std::max(largest_of_box, apart(many, box, x, y));
            }
        }
    EXPECT_LT(largest, 0.03f);
    EXPECT_GT(largest_of_box, 0.05f);
}

// All over a rough metal that moves before a bright board, light is nearly the same. The samples of a pixel together
// reflect by its whole lobe: if each of them took a direction near those of the others, neighbours would differ by
// more than their mean.
TEST(MotionBlur, ARoughMetalHasNoDots)
{
    const Board metal{glm::vec3(0.8f), 4, {0, 0, -2}, {0.2, 0, 0}, scene::ShadingModel::metallic_roughness, 1};
    const Board behind_the_viewer{glm::vec3(1), 3, {1.5, 0, 2}, {}, scene::ShadingModel::unlit, 0, k_pi};
    const Scene scene = boards({metal, behind_the_viewer}, 1);
    RenderOptions options = options_of(k_adaptive_samples);
    options.size = {32, 32}, options.shutter = 180;
    const Frame frame = frame_of(scene, options);
    double square = 0, mean = 0;
    for (int y = 1; y < 32; ++y)
        for (int x = 1; x < 32; ++x) {
            const auto here = static_cast<double>(frame.layer("")->value(x, y, 1));
            const double apart = here - static_cast<double>(frame.layer("")->value(x - 1, y, 1));
            square += apart * apart, mean += here;
        }
    const double count = 31 * 31;
    EXPECT_GT(mean / count, 0.02);
    EXPECT_LT(std::sqrt(square / count), 0.4 * mean / count);
}

// What few rays of a sample bring says little about how much of it the lobe reflects.
TEST(MotionBlur, ARoughMetalReflectsAsMuchWithAnyNumberOfSamples)
{
    const Board metal{glm::vec3(0.8f), 4, {0, 0, -2}, {0.2, 0, 0}, scene::ShadingModel::metallic_roughness, 1};
    const Board behind_the_viewer{glm::vec3(1), 3, {1.5, 0, 2}, {}, scene::ShadingModel::unlit, 0, k_pi};
    const Scene scene = boards({metal, behind_the_viewer}, 1);
    const auto sum = [&](const RenderOptions& options) {
        const Frame frame = frame_of(scene, options);
        double all = 0;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) all += static_cast<double>(frame.layer("")->value(x, y));
        return all;
    };
    RenderOptions options = options_of(1);
    options.size = {32, 32};
    options.reference = ReferenceLightOptions{.spp = 1024};
    const double right = sum(options);
    options.reference.reset();
    for (const double shutter : {0.0, 180.0})
        for (const int samples : {1, 2, 4, 16, 64, int{k_adaptive_samples}}) {
            options.shutter = shutter, options.samples = samples;
            EXPECT_NEAR(sum(options), right, 0.04 * right) << "shutter " << shutter << ", samples " << samples;
        }
}

TEST(MotionBlur, AClosedShutterAndAStillSceneChangeNothing)
{
    const Scene moving = load("builtin:spheres?objects=20&dynamic=20&vertices=200");
    const Scene still = load("builtin:spheres?objects=20&dynamic=0&vertices=200");
    for (const int samples : {2, k_adaptive_samples}) {
        RenderOptions options{.size = {48, 32}, .samples = samples, .threads = 1, .layers = true};
        const Frame before = frame_of(moving, options, 2), before_still = frame_of(still, options, 2);
        options.shutter = 0;
        test::expect_same(frame_of(moving, options, 2), before);
        options.shutter = 180;
        test::expect_same(frame_of(still, options, 2), before_still);
    }
}

TEST(MotionBlur, SameBytesForAnyNumberOfThreadsAndAnyHistory)
{
    const Scene scene = load("builtin:spheres?objects=20&dynamic=20&vertices=200");
    RenderOptions options{.size = {56, 40}, .samples = k_adaptive_samples, .threads = 1, .layers = true};
    options.shutter = 180, options.f_number = 2, options.focus = 8;
    options.ids = true, options.motion = true;
    const Frame alone = frame_of(scene, options, 4);
    options.threads = 3;
    Renderer renderer(options);
    for (const int frame : {2, 3, 4, 7}) {
        const Frame one = renderer.render(scene, frame);
        if (frame == 4) test::expect_same(one, alone);
    }
    test::expect_same(renderer.render(scene, 4), alone);
    options.shadow_culling = ShadowCulling::off;
    test::expect_same(frame_of(scene, options, 4), alone);
}

TEST(MotionBlur, IdsDepthAndMotionAreThoseOfTheMiddle)
{
    const Scene scene = load("builtin:spheres?objects=20&dynamic=20&vertices=200");
    RenderOptions options{.size = {56, 40}, .samples = k_adaptive_samples, .threads = 1, .layers = true};
    options.ids = true, options.motion = true;
    const Frame sharp = frame_of(scene, options, 4);
    options.shutter = 180, options.aperture = 20, options.focus = 8;
    const Frame blurred = frame_of(scene, options, 4);
    for (const char* name : {"depth", "normal", "motion"}) {
        const auto a = sharp.layer(name)->values(), b = blurred.layer(name)->values();
        EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << name;
    }
    const auto a = sharp.layer("id")->ids(), b = blurred.layer("id")->ids();
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    const auto c = sharp.layer("")->values(), d = blurred.layer("")->values();
    EXPECT_FALSE(std::equal(c.begin(), c.end(), d.begin(), d.end()));
}

// A small bright square at twice the distance of what is sharp.
TEST(DepthOfField, APointBecomesADiscOfTheThinLensAndKeepsItsEnergy)
{
    constexpr double k_depth = 10, k_focus = 5, k_aperture = 1600;   // the last in millimetres
    const Scene scene = boards({{.color = glm::vec3(1), .side = 0.4f, .at = {0.07, 0.07, -k_depth}}}, 0);
    RenderOptions options = options_of(256);
    const double energy = sum_of(frame_of(scene, options));
    options.aperture = k_aperture, options.focus = k_focus;
    const double spread = 2 * std::tan(0.4) / 64;   // of a pixel
    const double diameter = 1e-3 * k_aperture * (k_depth - k_focus) / (k_depth * k_focus * spread);
    ASSERT_GT(diameter, 6);
    for (const int samples : {256, k_adaptive_samples}) {
        options.samples = samples;
        const Frame frame = frame_of(scene, options);
        EXPECT_NEAR(sum_of(frame) / energy, 1, 0.02) << samples;
        // The second moment along an axis of a disc is the sixteenth of its squared diameter; the square adds its own.
        double sum = 0, first = 0, second = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const double light = static_cast<double>(frame.layer("")->value(x, y));
                sum += light, first += light * x, second += light * x * x;
            }
        const double variance = second / sum - first / sum * (first / sum);
        const double side = 0.4 / (k_depth * spread);
        const double expected = diameter * diameter / 16 + (side * side + (samples > 0 ? 1 : 1.5)) / 12;
        EXPECT_NEAR(std::sqrt(variance / expected), 1, 0.03) << samples;
    }
}

// As above: a parallel view's disc does not depend on how far away the scene is, but on how far from what is sharp.
TEST(DepthOfField, AnOrthographicCameraHasTheLensOfAMetre)
{
    constexpr double k_aperture = 800, k_pixel = 0.1, k_diameter = 1e-3 * k_aperture * (10 - 5) / 5 / k_pixel;
    const Scene scene = boards({{.color = glm::vec3(1), .side = 0.4f, .at = {0.07, 0.07, -10}}}, 64 * k_pixel);
    RenderOptions options = options_of(256);
    const double energy = sum_of(frame_of(scene, options));
    options.focus = 5;
    for (const int samples : {256, k_adaptive_samples}) {
        options.samples = samples;
        options.aperture = k_aperture, options.f_number = 0;
        const Frame frame = frame_of(scene, options);
        EXPECT_NEAR(sum_of(frame) / energy, 1, 0.02) << samples;
        double sum = 0, first = 0, second = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                const double light = static_cast<double>(frame.layer("")->value(x, y));
                sum += light, first += light * x, second += light * x * x;
            }
        const double variance = second / sum - first / sum * (first / sum);
        const double expected = k_diameter * k_diameter / 16 + (16 + (samples > 0 ? 1 : 1.5)) / 12;
        EXPECT_NEAR(std::sqrt(variance / expected), 1, 0.03) << samples;
        options.aperture = 0, options.f_number = 1000 / k_aperture;
        test::expect_same(frame, frame_of(scene, options));
    }
}

// Computed anew, bounced light took three times as many rays.
TEST(DepthOfField, BouncedLightIsThatOfTheFrameWithoutLens)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options{.size = {48, 32}, .samples = k_adaptive_samples, .exposure = 0.0};
    const FrameCounters sharp = frame_of(scene, options, 5).counters;
    options.aperture = 200;
    const FrameCounters blurred = frame_of(scene, options, 5).counters;
    EXPECT_GT(blurred.samples.taken, 5 * sharp.samples.taken);
    EXPECT_LT(2 * blurred.indirect.rays, 3 * sharp.indirect.rays);
}

// A metal ball in a room that is lit by bounces.
Scene chrome(float reflectance, float roughness = 0)
{
    SceneBuilder builder;
    const auto quad = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& color) {
        const std::vector<Vec3> corners = {a, b, c, d};
        const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3};
        const MeshId mesh = builder.mesh({.positions = corners, .indices = indices});
        return builder.instance(mesh, builder.material({.base_color = color, .roughness = 1, .ior = 1}));
    };
    quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}, {0.7f, 0.7f, 0.7f});
    quad({-2, 0, -2}, {2, 0, -2}, {2, 4, -2}, {-2, 4, -2}, {0.7f, 0.3f, 0.3f});
    quad({-2, 0, 2}, {-2, 0, -2}, {-2, 4, -2}, {-2, 4, 2}, {0.3f, 0.7f, 0.3f});
    quad({2, 0, -2}, {2, 0, 2}, {2, 4, 2}, {2, 4, -2}, {0.3f, 0.3f, 0.7f});
    quad({-2, 4, -2}, {2, 4, -2}, {2, 4, 2}, {-2, 4, 2}, {0.7f, 0.7f, 0.7f});
    constexpr int k_rings = 24, k_sectors = 48;
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;
    for (int i = 0; i <= k_rings; ++i)
        for (int j = 0; j <= k_sectors; ++j) {
            const auto down = static_cast<float>(k_pi * i / k_rings);
            const auto around = static_cast<float>(2 * k_pi * j / k_sectors);
            const Vec3 n{std::sin(down) * std::sin(around), std::cos(down), std::sin(down) * std::cos(around)};
            normals.push_back(n), positions.push_back({0.8f * n.x, 0.9f + 0.8f * n.y, 0.8f * n.z});
            if (i == k_rings || j == k_sectors) continue;
            const auto at = static_cast<std::uint32_t>(i * (k_sectors + 1) + j);
            indices.insert(indices.end(), {at, at + k_sectors + 1, at + 1});
            indices.insert(indices.end(), {at + 1, at + k_sectors + 1, at + k_sectors + 2});
        }
    const MeshId ball = builder.mesh({.positions = positions, .indices = indices, .normals = normals});
    builder.instance(
        ball, builder.material(
                  {.base_color = {reflectance, reflectance, reflectance}, .metallic = 1, .roughness = roughness}));
    builder.light({.color = {20, 20, 20}}, Transform::translation(0.7, 3.5, 0.7));
    Camera camera;
    camera.transform = Transform::translation(0, 1.2, 4.5);
    builder.camera(camera);
    return builder.finish();
}

struct Blurred {
    ImageF color;
    FrameCounters counters;
};

// Samples through a lens.
Blurred blurred(const Scene& scene, bool in_full, std::optional<double> focus = {},
                Indirect indirect = Indirect::visible, const Size& size = {64, 48}, int samples = 64)
{
    frame::FrameEngine engine({.threads = 2});
    const RenderOptions options{
        .samples = samples, .aperture = 40, .focus = focus, .exposure = 0, .indirect = indirect};
    engine.advance(api::scene_of(scene), 0, options);
    frame::RenderRequest request;
    request.shutter.emplace();
    request.shutter->view_at = [&](const scene::SceneState& state, double) {
        return engine.view_in(state, 0, size, {});
    };
    request.blur_in_full = in_full;
    Blurred result;
    result.counters = engine.render(engine.make_view(0, size), request);
    result.color = engine.buffers().color;
    return result;
}

// Each sample's mirror image shows new places. Computed anew, their bounced light takes 3,600 more rays.
TEST(DepthOfField, MirroredBouncedLightIsSharedBetweenSamples)
{
    const Scene scene = chrome(0.9f);
    const Size size{160, 120};
    const Blurred shared = blurred(scene, false, {}, Indirect::visible, size),
                  computed = blurred(scene, true, {}, Indirect::visible, size);
    EXPECT_GT(computed.counters.indirect.rays, shared.counters.indirect.rays + 2500);
    double square = 0, more = 0;
    for (std::size_t i = 0; i < shared.color.data.size(); ++i) {
        const double apart = shown(shared.color.data[i]) - shown(computed.color.data[i]);
        square += apart * apart, more += apart;
    }
    const auto values = static_cast<double>(shared.color.data.size());
    EXPECT_LT(std::sqrt(square / values), 0.004);
    EXPECT_LT(std::abs(more / values), 0.0005);
}

// Where the frame without lens changes evenly, samples take its light; and that of lobes wherever it shows their
// surface.
TEST(DepthOfField, LightIsThatOfTheFrameWithoutLens)
{
    for (const float roughness : {0.0f, 1.0f}) {
        const Scene scene = chrome(0.9f, roughness);
        const auto render = [&](bool in_full) {
            return blurred(scene, in_full, 2, Indirect::visible, {96, 72}, k_adaptive_samples);
        };
        const Blurred taken = render(false), computed = render(true);
        double square = 0, more = 0;
        for (std::size_t i = 0; i < taken.color.data.size(); ++i) {
            const double apart = shown(taken.color.data[i]) - shown(computed.color.data[i]);
            square += apart * apart, more += apart;
        }
        const auto values = static_cast<double>(taken.color.data.size());
        // Computed anew, each sample's lobe has a few rays, which show as grain.
        EXPECT_LT(std::sqrt(square / values), roughness > 0 ? 0.0065 : 0.004);
        EXPECT_LT(std::abs(more / values), 0.0003);
        EXPECT_LT(4 * taken.counters.samples.shaded, 3 * computed.counters.samples.shaded);
        if (roughness > 0) {
            EXPECT_LT(20 * taken.counters.reflection_rays, computed.counters.reflection_rays);
        }
    }
}

// A ball that mirrors a twentieth of its surroundings: some samples follow its rays, with as much more weight.
TEST(DepthOfField, DimPathsAreFollowedByTheirShareOfSamples)
{
    const Scene scene = chrome(0.05f);
    const Blurred some = blurred(scene, false, 1.5, Indirect::off), all = blurred(scene, true, 1.5, Indirect::off);
    // Half of all rays are those of the frame at the lens's centre.
    EXPECT_LT(5 * some.counters.reflection_rays, 4 * all.counters.reflection_rays);
    double sum = 0, of_all = 0;
    for (int y = 22; y < 32; ++y)
        for (int x = 26; x < 38; ++x)
            for (int c = 0; c < 3; ++c)
                sum += static_cast<double>(some.color.pixel(x, y)[c]),
                    of_all += static_cast<double>(all.color.pixel(x, y)[c]);
    EXPECT_GT(of_all, 0.1);
    EXPECT_NEAR(sum / of_all, 1, 0.02);
}

TEST(DepthOfField, WhatIsInFocusHasTheSameBytes)
{
    const Scene scene = boards({{.color = {0.3f, 0.6f, 0.2f}, .side = 3, .at = {-1, 0, -5}},
                                {.color = {0.9f, 0.2f, 0.1f}, .side = 2, .at = {2.4, 0, -5}}},
                               0);
    RenderOptions options = options_of(k_adaptive_samples);
    const Frame sharp = frame_of(scene, options);
    options.f_number = 2.8, options.focus = 5;
    const Frame frame = frame_of(scene, options);
    for (int y = 24; y < 40; ++y)
        for (int x = 12; x < 28; ++x)
            EXPECT_EQ(frame.layer("")->value(x, y), sharp.layer("")->value(x, y)) << x << " " << y;
}

TEST(DepthOfField, AutomaticFocusIsThatOfTheMiddle)
{
    const Scene scene = boards({{.color = {0.3f, 0.6f, 0.2f}, .side = 4, .at = {0, 0, -7}}}, 0);
    RenderOptions options = options_of(k_adaptive_samples);
    options.aperture = 50;
    const Frame automatic = frame_of(scene, options);
    options.focus = 7;
    test::expect_same(automatic, frame_of(scene, options));
}

// 50 mm at f/2.8 is a lens of 17.9 mm; the field of view of 50 mm on a sensor 24 mm high is 27 degrees.
TEST(Lens, AnFNumberRefersToAFullFrameCamera)
{
    scene::View view;
    view.up = {0, 12.0f / 50, 0};
    EXPECT_NEAR(scene::lens_radius(view, 2.8), 0.050 / 2.8 / 2, 1e-7);
    EXPECT_NEAR(scene::lens_radius(view, 1.4), 0.050 / 2.8, 1e-7);
}

TEST(Lens, AllRaysOfAPlaceMeetInThePlaneOfFocus)
{
    scene::View view;
    view.size = {64, 48}, view.pixel_spread = 0.02f, view.shift = {0.1f, -0.2f};
    view.eye = {1, 2, 3}, view.right *= 0.6f, view.up *= 0.45f;
    const scene::Lens lens{.radius = 0.2f, .focus = 3};
    for (const glm::vec2 at : {glm::vec2(0), glm::vec2(1, 0), glm::vec2(-0.3f, 0.8f)}) {
        glm::vec3 origin, direction, centre, straight;
        float tnear, tfar;
        view.ray(10, 7, centre, straight, tnear, tfar);
        scene::lens_ray(view, lens, 10, 7, at, origin, direction, tnear, tfar);
        const glm::vec3 there = centre + straight * (lens.focus / glm::dot(straight, view.forward));
        const glm::vec3 here = origin + direction * (lens.focus / glm::dot(direction, view.forward));
        EXPECT_LT(glm::length(there - here), 1e-5f);
        EXPECT_NEAR(glm::length(origin - view.eye), lens.radius * glm::length(at), 1e-6f);
    }
    EXPECT_EQ(scene::circle_of_confusion(view, lens, 3), 0);
    EXPECT_NEAR(scene::circle_of_confusion(view, lens, 6), 0.4f * 3 / 6 / (3 * 0.02f), 1e-4f);
    EXPECT_NEAR(scene::circle_of_confusion(view, lens, k_infinity), 0.4f / (3 * 0.02f), 1e-4f);
}

TEST(Lens, RaysOfAnOrthographicViewMeetInThePlaneOfFocus)
{
    scene::View view;
    view.size = {64, 48}, view.orthographic = true, view.pixel_width = 0.02f, view.shift = {0.1f, -0.2f};
    view.eye = {1, 2, 3}, view.right *= 0.6f, view.up *= 0.45f, view.near = 0.5f, view.far = 20;
    const scene::Lens lens{.radius = 0.2f, .focus = 3};
    for (const glm::vec2 at : {glm::vec2(0), glm::vec2(1, 0), glm::vec2(-0.3f, 0.8f)}) {
        glm::vec3 origin, direction, centre, straight;
        float tnear, tfar;
        view.ray(10, 7, centre, straight, tnear, tfar);
        scene::lens_ray(view, lens, 10, 7, at, origin, direction, tnear, tfar);
        const float slant = 1 / glm::dot(direction, view.forward);
        EXPECT_LT(glm::length(centre + straight * lens.focus - origin - direction * (lens.focus * slant)), 1e-5f);
        EXPECT_NEAR(glm::length(origin - centre), lens.radius * glm::length(at), 1e-6f);
        EXPECT_NEAR(glm::length(direction), 1, 1e-6f);
        EXPECT_NEAR(tnear, view.near * slant, 1e-5f);
        EXPECT_NEAR(tfar, view.far * slant, 1e-4f);
        // What the ray meets is shown where it came from.
        const auto seen = scene::through_lens(view, lens, at).project(glm::dvec3(origin + 7.0f * direction));
        ASSERT_TRUE(seen);
        EXPECT_NEAR(seen->x, 10, 1e-4);
        EXPECT_NEAR(seen->y, 7, 1e-4);
    }
    EXPECT_EQ(scene::circle_of_confusion(view, lens, 3), 0);
    EXPECT_NEAR(scene::circle_of_confusion(view, lens, 6), 0.4f / 0.02f, 1e-4f);
}

// Root mean square of the differences, as shading::shown() has them, where a frame differs from one without blur.
double error_of(const ImageF& image, const ImageF& truth, const ImageF& sharp)
{
    double sum = 0, values = 0;
    for (std::size_t i = 0; i < image.data.size(); ++i) {
        if (std::abs(shown(truth.data[i]) - shown(sharp.data[i])) < 0.003) continue;
        const double apart = shown(image.data[i]) - shown(truth.data[i]);
        sum += apart * apart, ++values;
    }
    EXPECT_GT(values, 100);
    return std::sqrt(sum / values);
}

TEST(Blur, AdaptiveSamplesErrLessThanAsManyRandomOnes)
{
    struct Case {
        const char* name;
        double shutter, aperture;
    };
    for (const Case& c : {Case{"shutter", 180, 0}, Case{"lens", 0, 600}, Case{"both", 180, 600}}) {
        // Squares at many depths, some of which move.
        Random random_boards(7);
        std::vector<Board> made;
        for (int i = 0; i < 24; ++i) {
            const auto at = [&](float low, float high) {
                return static_cast<double>(random_boards.uniform(low, high));
            };
            const glm::vec3 color(at(0, 1), at(0, 1), at(0, 1));
            const double depth = at(3, 12);
            made.push_back({.color = color,
                            .side = static_cast<float>(at(0.1f, 0.3f) * depth),
                            .at = {at(-0.6f, 0.6f) * depth, at(-0.4f, 0.4f) * depth, -depth},
                            .speed = i % 2 ? glm::dvec3(at(-1, 1), at(-1, 1), 0) * depth * 8.0 : glm::dvec3(0)});
        }
        const Scene scene = boards(made, 0);
        const std::shared_ptr<const scene::Scene> inside = api::scene_of(scene);
        frame::FrameEngine engine({.threads = 2});
        struct Result {
            ImageF color;
            double samples;
        };
        const auto render = [&](int samples, bool random, bool blurs = true) {
            RenderOptions options = options_of(samples);
            options.shutter = blurs ? c.shutter : 0, options.aperture = blurs ? c.aperture : 0;
            const double time = scene.time_of(k_frame), half = c.shutter / 720 / scene.fps();
            engine.advance(inside, time, options);
            frame::RenderRequest request;
            request.shutter.emplace();
            request.shutter->open = time - half, request.shutter->close = time + half;
            request.shutter->view_at = [&](const scene::SceneState& state, double) {
                return engine.view_in(state, 0, {96, 64}, {});
            };
            request.random_blur = random;
            const FrameCounters counters = engine.render(engine.make_view(0, {96, 64}), request);
            return Result{engine.buffers().color, static_cast<double>(counters.samples.taken) / (96 * 64)};
        };
        const ImageF sharp = render(256, false, false).color;
        const Result truth = render(1024, false);
        const double random = error_of(render(64, true).color, truth.color, sharp);
        const Result adaptive = render(k_adaptive_samples, false);
        const double error = error_of(adaptive.color, truth.color, sharp);
        // Random samples err by the square root of their number.
        const double equal = 64 * (random / error) * (random / error);
        EXPECT_LT(adaptive.samples, 0.45 * equal) << c.name << ": " << error << ", random " << random;
        EXPECT_LT(error_of(render(32, false).color, truth.color, sharp), 1.05 * random) << c.name;
    }
}

// Squares that are less than half a pixel wide, of which a pixel's first samples meet few. Chrome mirrors as much
// detail.
TEST(Blur, SmallDetailsAreNotGrained)
{
    Random random(3);
    std::vector<Board> details;
    for (int i = 0; i < 700; ++i) {
        const auto at = [&](float low, float high) { return static_cast<double>(random.uniform(low, high)); };
        details.push_back({.color = glm::vec3(at(0, 0.1f), at(0, 0.1f), at(0, 0.1f)),
                           .side = 0.4f,
                           .at = {at(-16, 16), at(-16, 16), -5},
                           .speed = glm::dvec3(at(-3, 3), at(-3, 3), 0) * 48.0});
    }
    const Scene scene = boards(details, 64);
    const auto render = [&](int samples) {
        RenderOptions options = options_of(samples);
        options.shutter = 180, options.filter = PixelFilter::box;
        return frame_of(scene, options);
    };
    const Frame adaptive = render(k_adaptive_samples), truth = render(1024);
    int lit = 0, grained = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) {
                const double is = shown(adaptive.layer("")->value(x, y, c)),
                             should = shown(truth.layer("")->value(x, y, c));
                lit += should > 0.02, grained += std::abs(is - should) > 0.03;
            }
    EXPECT_GT(lit, 1000);
    EXPECT_LT(grained, lit / 30);
    EXPECT_NEAR(sum_of(adaptive), sum_of(truth), 0.02 * sum_of(truth));
}

// Each pose makes all caches follow the scene. The first round tells how many samples each pixel takes in the second.
TEST(Blur, PosesTheSceneInTwoRounds)
{
    std::vector<Board> many;
    for (int i = 0; i < 8; ++i)
        many.push_back({.color = glm::vec3(i % 2, 1, 0.2f),
                        .side = 6,
                        .at = {-24 + 6.5 * i, 3 * (i % 3), -5 - i},
                        .speed = {64 * 48 * (i % 2 ? 1 : -1), 0, 0}});
    const Scene scene = boards(many, 64);
    frame::FrameEngine engine({.threads = 1});
    RenderOptions options = options_of(k_adaptive_samples);
    options.shutter = 180;
    const double time = scene.time_of(k_frame), half = 0.25 / scene.fps();
    engine.advance(api::scene_of(scene), time, options);
    int views = 0;
    frame::RenderRequest request;
    request.shutter.emplace();
    request.shutter->open = time - half, request.shutter->close = time + half;
    request.shutter->view_at = [&](const scene::SceneState& state, double) {
        ++views;
        return engine.view_in(state, 0, {64, 64}, {});
    };
    const FrameCounters counters = engine.render(engine.make_view(0, {64, 64}), request);
    EXPECT_GT(counters.samples.taken,
              20 * counters.samples.pixels);   // so that many pixels go on to the largest number
    constexpr int k_probes = 9;                // times at which motion is looked for
    constexpr int k_phases = 2;                // because it moves by 32 to 64 pixels
    EXPECT_EQ(views, k_probes + k_phases * trace::k_first_blur_samples + trace::k_most_blur_times);
}

TEST(BlurSample, EachRoundFillsTheStrataOfTimeEvenly)
{
    for (const int phases : {1, 2, 4, 8})
        for (const glm::ivec2 pixel : {glm::ivec2(0, 0), glm::ivec2(17, 4), glm::ivec2(1023, 7)})
            for (const std::uint32_t samples : {8u, 32u, 64u, 128u}) {
                const trace::BlurMotion motion{.times = 64, .phases = phases};
                std::vector<std::uint32_t> in(samples < 64 ? samples : 64, 0);
                for (std::uint32_t s = 0; s < samples; ++s)
                    ++in[static_cast<std::size_t>(trace::blur_sample(pixel, s, motion, false).time) * in.size() / 64];
                for (const std::uint32_t count : in) EXPECT_EQ(count, samples / in.size());
            }
}

TEST(BlurSample, FirstTimesOfPixelsThatLieTogetherFillTheShutter)
{
    for (const int phases : {1, 2, 4, 8}) {
        const trace::BlurMotion motion{.times = 64, .phases = phases};
        std::set<int> times;
        for (int y = 6; y < 10; ++y)
            for (int x = 13; x < 17; ++x) {
                int sum = 0;
                for (std::uint32_t s = 0; s < trace::k_first_blur_samples; ++s) {
                    const int time = trace::blur_sample({x, y}, s, motion, false).time;
                    times.insert(time), sum += time;
                }
                // The mean is the middle, so that what changes evenly has no pattern.
                EXPECT_NEAR(sum / 8.0, 31.5, 0.51) << phases;
            }
        EXPECT_EQ(times.size(), 8u * static_cast<std::size_t>(phases));
    }
}

TEST(BlurSample, PathsOfARoundAreFollowedByTheirShare)
{
    for (const glm::ivec2 pixel : {glm::ivec2(0, 0), glm::ivec2(17, 3), glm::ivec2(200, 301)})
        for (int depth = 0; depth < 3; ++depth)
            for (const float share : {0.1f, 0.3f, 0.7f}) {
                int followed = 0;
                for (std::uint32_t number = 0; number < 64; ++number)
                    followed += trace::blur_path_place(pixel, number, depth) < share ? 1 : 0;
                EXPECT_NEAR(static_cast<float>(followed), 64 * share, 2.5f) << share;
            }
}

TEST(BlurSample, PlacesOfARoundFillThePixelAndTheLensEvenly)
{
    // One of 16 points in each of 16 columns and rows; of the lens, equal numbers in the four quadrants.
    const trace::BlurMotion motion{.times = 64};
    for (const glm::ivec2 pixel : {glm::ivec2(0, 0), glm::ivec2(17, 4), glm::ivec2(1023, 7)}) {
        int columns[16] = {}, rows[16] = {}, quadrants[4] = {};
        for (std::uint32_t s = 0; s < 16; ++s) {
            const trace::BlurSample sample = trace::blur_sample(pixel, s, motion, false);
            ++columns[static_cast<int>(sample.offset.x * 16)], ++rows[static_cast<int>(sample.offset.y * 16)];
            ++quadrants[(sample.lens.x > 0) + 2 * (sample.lens.y > 0)];
            EXPECT_LE(glm::length(sample.lens), 1.0001f);
        }
        for (int i = 0; i < 16; ++i) EXPECT_TRUE(columns[i] == 1 && rows[i] == 1);
        for (const int count : quadrants) EXPECT_EQ(count, 4);
    }
}

TEST(Lens, MisuseIsRefused)
{
    const auto refused = [](auto&& change) {
        RenderOptions options;
        change(options);
        EXPECT_THROW(check_options(options), UsageError);
    };
    refused([](RenderOptions& o) { o.shutter = -1; });
    refused([](RenderOptions& o) { o.shutter = 361; });
    refused([](RenderOptions& o) { o.f_number = -2; });
    refused([](RenderOptions& o) { o.f_number = 2, o.aperture = 3; });
    refused([](RenderOptions& o) { o.focus = 3; });
    refused([](RenderOptions& o) { o.f_number = 2, o.focus = 0; });
    refused([](RenderOptions& o) { o.shutter = 180, o.reference.emplace(); });
    refused([](RenderOptions& o) { o.f_number = 2, o.shadow_culling = ShadowCulling::paper; });
}

}   // namespace
}   // namespace gnomon
