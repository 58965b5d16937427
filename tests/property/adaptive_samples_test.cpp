// SPDX-License-Identifier: Apache-2.0
// Adaptive samples: the same bytes however a frame is made, near the image of many samples, and more samples only where
// something ends.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "api/scene_access.h"
#include "base/hash.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"
#include "trace/frame_scratch.h"
#include "trace/indirect_light.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

std::uint64_t hash_of(const Frame& frame)
{
    std::uint64_t hash = 0;
    for (const Layer& layer : frame.layers) hash = hash * 31 + hash_span(layer.values());
    return hash;
}

double rmse(std::span<const float> a, std::span<const float> b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * static_cast<double>(a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

// A board of 2 x 2 that fills the view, below a light. With `shade`, a strip between them casts a shadow on it; the
// strip itself is not seen.
// @param second  intensity of a light whose shadow lies elsewhere
Scene board(bool shade, float intensity = 300, float second = 0)
{
    SceneBuilder builder;
    const auto square = [&](float side, float y, float depth) {
        const std::vector<Vec3> corners = {{-side, y, -depth}, {-side, y, depth}, {side, y, depth}, {side, y, -depth}};
        const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3};
        return builder.mesh({.positions = corners, .indices = indices});
    };
    const MaterialId white = builder.material({.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1});
    builder.instance(square(20, 0, 20), white);
    if (shade) builder.instance(square(1.03f, 5, 0.21f), white);
    builder.light({.color = {intensity, intensity, intensity}}, Transform::translation(0, 10, 0));
    if (second > 0) builder.light({.color = {second, second, second}}, Transform::translation(0, 10, 8));
    return builder.finish();
}

struct Traced {
    shading::FrameBuffers buffers;
    FrameCounters counters;
};

Traced traced(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
              const trace::TracedOptions& options, int threads = 1)
{
    Tasks tasks(threads);
    Traced result;
    result.counters = trace::trace_frame(state, rays, view, options, tasks, result.buffers);
    return result;
}

// The built-in room, without indirect light.
class Room : public ::testing::Test {
 protected:
    std::shared_ptr<const scene::Scene> scene_ = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state_{scene_, 0};
    ray::RayScene rays_{state_};
    scene::View view_ = scene::make_view(state_, 0, {96, 64});
    trace::TracedOptions adaptive_{.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = 0.0f};
    trace::TracedOptions many_{.samples = 64, .filter = PixelFilter::blackman_harris, .exposure = 0.0f};
};

TEST(AdaptiveSamples, SameBytesForAnyNumberOfThreadsAndAnyHistory)
{
    for (const char* name : {"builtin:cornell", "builtin:spheres?objects=20&dynamic=20&vertices=200"}) {
        const Scene scene = load(name);
        RenderOptions options{.size = {72, 50}, .samples = k_adaptive_samples, .threads = 1, .layers = true};
        Renderer whole(options);
        std::uint64_t last = 0;
        for (int frame = 1; frame <= 3; ++frame) last = hash_of(whole.render(scene, frame));
        options.threads = 3;
        Renderer cold(options);
        EXPECT_EQ(hash_of(cold.render(scene, 3)), last) << name;
        // Without culling, nothing is remembered.
        options.shadow_culling = ShadowCulling::off;
        Renderer off(options);
        EXPECT_EQ(hash_of(off.render(scene, 3)), last) << name;
    }
}

TEST(AdaptiveSamples, LayersDoNotChangeTheImage)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options{.size = {72, 50}, .samples = k_adaptive_samples};
    Renderer plain(options);
    options.layers = true;
    Renderer layered(options);
    EXPECT_EQ(hash_span(plain.render(scene, 1).layers[0].values()),
              hash_span(layered.render(scene, 1).layers[0].values()));
}

TEST_F(Room, IsNearTheImageOfManySamples)
{
    const Traced many = traced(state_, rays_, view_, many_);
    const Traced adaptive = traced(state_, rays_, view_, adaptive_);
    trace::TracedOptions one_options = many_;
    one_options.samples = 1;
    const Traced one = traced(state_, rays_, view_, one_options);
    const double error = rmse(adaptive.buffers.color.data, many.buffers.color.data);
    EXPECT_LT(error, 0.4 * rmse(one.buffers.color.data, many.buffers.color.data));
    EXPECT_LT(adaptive.counters.samples.pixels, 96u * 64u / 3);
    EXPECT_GT(adaptive.counters.samples.pixels, 0u);
    EXPECT_LT(adaptive.counters.samples.shaded, adaptive.counters.samples.taken);
}

// The reference computes the light of every further sample.
// Frames use memory one after the other: nothing of a frame shows in the next, where that sees less, or is smaller.
TEST_F(Room, NothingIsLeftOfTheFrameBefore)
{
    Tasks tasks(1);
    trace::FrameScratch scratch;
    shading::FrameBuffers out;
    scene::View away = view_;
    away.eye -= 3.0f * away.forward;
    for (const scene::View& view : {view_, away, scene::make_view(state_, 0, {40, 70}), view_})
        for (const bool backdrop_apart : {false, true}) {
            trace::TracedOptions options = adaptive_;
            options.backdrop_apart = backdrop_apart;
            const FrameCounters counters =
                trace::trace_frame(state_, rays_, view, options, tasks, out, {.scratch = &scratch});
            const Traced fresh = traced(state_, rays_, view, options);
            EXPECT_EQ(out.color.data, fresh.buffers.color.data);
            if (backdrop_apart) {
                EXPECT_EQ(out.alpha.data, fresh.buffers.alpha.data);
            }
            EXPECT_EQ(counters.samples.pixels, fresh.counters.samples.pixels);
        }
}

TEST_F(Room, LightThatIsTakenIsNearLightThatIsComputed)
{
    const Traced taken = traced(state_, rays_, view_, adaptive_);
    trace::TracedOptions options = adaptive_;
    options.refine.agree = -1;
    const Traced computed = traced(state_, rays_, view_, options);
    EXPECT_LT(taken.counters.samples.shaded, computed.counters.samples.shaded);
    EXPECT_EQ(taken.counters.samples.pixels, computed.counters.samples.pixels);
    EXPECT_LT(rmse(taken.buffers.color.data, computed.buffers.color.data), 0.004);
}

// Bounced light that is one value on either side of a plane, and how many further samples have it computed.
class StepIndirect final : public trace::IndirectLight {
 public:
    explicit StepIndirect(float step) : step_(step) {}
    void begin_frame(const trace::FrameContext&) override {}
    std::unique_ptr<Worker> make_worker() override { return std::make_unique<Work>(*this); }
    FrameCounters::Indirect end_frame(std::span<const std::unique_ptr<Worker>>) override { return {}; }
    int further = 0;

 private:
    class Work final : public Worker {
     public:
        explicit Work(StepIndirect& light) : light_(light) {}
        void gather(const trace::PointBatch& batch, trace::IndirectResult& result) override
        {
            result.point.clear(), result.irradiance.clear();
            for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
                if (batch.points[p].has_bounced) continue;
                light_.further += batch.scattered() && batch.primary ? 1 : 0;
                result.point.push_back(p);
                const bool beyond = batch.points[p].surface.position.x > 0.11f;
                result.irradiance.emplace_back(beyond ? 1 + light_.step_ : 1);
            }
        }

     private:
        StepIndirect& light_;
    };
    float step_;
};

// The reference computes the bounced light of every further sample whose other light is computed.
TEST_F(Room, BouncedLightIsTakenWhereItAgrees)
{
    Tasks tasks(1);
    for (const float step : {0.0f, 4.0f}) {
        StepIndirect some(step), all(step);
        shading::FrameBuffers taken, computed;
        trace::trace_frame(state_, rays_, view_, adaptive_, tasks, taken, {.indirect = &some});
        trace::TracedOptions options = adaptive_;
        options.refine.bounced_reach = 0;
        trace::trace_frame(state_, rays_, view_, options, tasks, computed, {.indirect = &all});
        EXPECT_EQ(some.further > 0, step > 0) << "at the step alone";
        EXPECT_LT(some.further, all.further / 2) << step;
        EXPECT_LT(rmse(taken.color.data, computed.color.data), 0.001) << step;
    }
}

TEST_F(Room, TilesLeaveNoSeams)
{
    const Traced large = traced(state_, rays_, view_, adaptive_);
    trace::TracedOptions options = adaptive_;
    options.tile = 8;
    const Traced small = traced(state_, rays_, view_, options);
    ASSERT_EQ(large.counters.samples.taken, small.counters.samples.taken);
    for (std::size_t i = 0; i < large.buffers.color.data.size(); ++i)
        ASSERT_NEAR(large.buffers.color.data[i], small.buffers.color.data[i], 1e-4f) << i;
}

TEST_F(Room, OneSampleWithTheBoxFilterIsUnchanged)
{
    const Traced plain = traced(state_, rays_, view_, {});
    trace::TracedOptions options = adaptive_;
    options.filter = PixelFilter::box;
    options.refine.edge = options.refine.light = 10;   // no difference is as large
    const Traced adaptive = traced(state_, rays_, view_, options);
    EXPECT_EQ(adaptive.counters.samples.pixels, 0u);
    for (std::size_t i = 0; i < plain.buffers.color.data.size(); ++i)
        ASSERT_NEAR(plain.buffers.color.data[i], adaptive.buffers.color.data[i],
                    1e-6f * (1 + plain.buffers.color.data[i]));
}

// Whether the object is lit or as black as what is behind it.
TEST(AdaptiveSamples, EdgesBeforeATransparentBackgroundCoverPixelsInPart)
{
    for (const float light : {30.0f, 0.0f}) {
        SceneBuilder builder;
        const std::vector<Vec3> corners = {{-1, -1, 0}, {1.2f, -0.8f, 0}, {0.1f, 1, 0}};
        const std::vector<std::uint32_t> indices = {0, 1, 2};
        builder.instance(builder.mesh({.positions = corners, .indices = indices}), builder.material({}));
        builder.light({.color = {light, light, light}}, Transform::translation(0, 0, 3));
        builder.camera({.transform = Transform::translation(0, 0, 4)});
        Renderer renderer({.size = {60, 60}, .samples = k_adaptive_samples, .background = BackgroundKind::transparent});
        const Frame frame = renderer.render(builder.finish(), 1);
        const Layer* alpha = frame.layer("alpha");
        ASSERT_TRUE(alpha);
        std::set<float> partly;
        for (const float a : alpha->values()) {
            EXPECT_GE(a, 0);
            EXPECT_LE(a, 1);
            if (a > 0 && a < 1) partly.insert(a);
        }
        EXPECT_GT(partly.size(), 12u) << light;
    }
}

// An emitter 30 times as bright as white: its edge is a ramp for many samples as for adaptive ones. If all light
// counted alike, pixels would be white from a thirtieth of them on.
TEST(AdaptiveSamples, EdgesOfBrightLightAreThoseOfManySamples)
{
    SceneBuilder builder;
    builder.instance(builder.mesh(test::square(1).mesh()),
                     builder.material({.base_color = {0, 0, 0}, .double_sided = true, .emissive = {30, 30, 30}}),
                     Transform::rotation({0, 0, 1}, 0.2));
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 4}, {0, 0, 0});
    builder.camera(camera);
    const Scene scene = builder.finish();
    for (const bool automatic : {false, true}) {
        RenderOptions options{.size = {48, 48}, .samples = k_adaptive_samples, .indirect = Indirect::off};
        if (!automatic) options.exposure = 0;
        const Frame adaptive = Renderer(options).render(scene, 1);
        options.samples = 64, options.filter = PixelFilter::blackman_harris;
        const Frame many = Renderer(options).render(scene, 1);
        double error = 0;
        int ramp = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const float a = adaptive.layers[0].value(x, y), b = many.layers[0].value(x, y);
                const auto shown = [](float v) { return std::min(v, 30.0f) / 30; };
                error = std::max(error, static_cast<double>(std::abs(shown(a) - shown(b))));
                ramp += b > 0.2f && b < 0.8f;
            }
        EXPECT_LT(error, 0.15) << automatic;
        if (!automatic) {
            EXPECT_GT(ramp, 40);
        }
    }
}

TEST(AdaptiveSamples, RefinesNothingOnAnEvenBoardAndTheEdgeOfAShadowOnIt)
{
    for (const bool shade : {false, true}) {
        const Scene scene = board(shade);
        const scene::SceneState state(api::scene_of(scene), 0);
        const ray::RayScene rays(state);
        scene::View view;
        view.eye = {0, 3, 0}, view.forward = {0, -1, 0};
        view.right = {0.9f, 0, 0}, view.up = {0, 0, -0.9f};
        view.size = {64, 64};
        view.pixel_spread = 2 * 0.9f / 64;
        const Traced result =
            traced(state, rays, view, {.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = 0.0f});
        if (!shade) {
            EXPECT_EQ(result.counters.samples.pixels, 0u);
            continue;
        }
        // Nothing but light differs there, so that of the first 4 is computed. Later ones may lie on one side.
        EXPECT_GT(result.counters.samples.pixels, 64u);
        EXPECT_LT(result.counters.samples.pixels, 64u * 64u / 4);
        EXPECT_GE(result.counters.samples.shaded, 4 * result.counters.samples.pixels);
        EXPECT_LT(result.counters.samples.shaded, result.counters.samples.taken);
    }
}

// Two sides of a shadow's edge that differ by a few steps of a display, as 80 and 65 of 255: no stairs are left.
TEST(AdaptiveSamples, EdgesOfWeakShadowsAreClean)
{
    const Scene scene = board(true, 12, 45);
    const scene::SceneState state(api::scene_of(scene), 0);
    const ray::RayScene rays(state);
    scene::View view;
    view.eye = {0, 3, 0}, view.forward = {0, -1, 0};
    view.right = {0.88f, 0, 0.19f}, view.up = {0.19f, 0, -0.88f};   // edges cross rows of pixels
    view.size = {64, 64};
    view.pixel_spread = 2 * 0.9f / 64;
    const ImageF adaptive =
        traced(state, rays, view, {.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = 0.0f})
            .buffers.color;
    const ImageF many =
        traced(state, rays, view, {.samples = 64, .filter = PixelFilter::blackman_harris, .exposure = 0.0f})
            .buffers.color;
    float errors = 0, step = 0;
    int edge = 0;
    for (std::size_t i = 0; i < many.data.size(); ++i) {
        const auto shown = [](float x) { return std::sqrt(x / (1 + x)); };
        const float error = shown(adaptive.data[i]) - shown(many.data[i]);
        errors += error * error;
        if (i < 3 * 64) continue;
        const float beside = std::abs(shown(many.data[i]) - shown(many.data[i - 3 * 64]));
        step = std::max(step, beside), edge += beside > 0.01f;
    }
    EXPECT_GT(step, 0.015f);
    EXPECT_LT(step, 0.05f);
    EXPECT_GT(edge, 3 * 64);
    EXPECT_LT(std::sqrt(errors / static_cast<float>(edge)), 0.006f);
}

// A floor with stripes a little wider than pixels, seen at a slant, so that single samples of it are not its means.
scene::Scene striped_floor(scene::ShadingModel model)
{
    SceneBuilder builder;
    std::vector<std::uint8_t> texels(64 * 64);
    for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = i / 4 % 2 == 0 ? 230 : 60;
    const TextureId stripes = builder.texture({.width = 64, .height = 64, .channels = 1, .pixels = texels});
    const std::vector<Vec3> corners = {{-4, 0, -8}, {-4, 0, 2}, {4, 0, 2}, {4, 0, -8}};
    const std::vector<Vec2> places = {{0, 0}, {0, 5}, {4, 5}, {4, 0}};
    const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3};
    Material material{.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1};
    material.base_color_texture.texture = stripes;
    builder.instance(builder.mesh({.positions = corners, .indices = indices, .texcoords = {places}}),
                     builder.material(material));
    builder.light({.color = {40, 40, 40}}, Transform::translation(1, 4, -2));
    scene::Scene scene = *api::scene_of(builder.finish());
    for (scene::Material& m : scene.materials) {
        m.model = model;
        if (model == scene::ShadingModel::whitted) m.specular = glm::vec3(0.3f), m.shine = 0;
    }
    return scene;
}

scene::View over_the_floor()
{
    scene::View view;
    view.eye = {0.3f, 1, 3}, view.forward = glm::normalize(glm::vec3(0, -0.35f, -1));
    view.right = {0.5f, 0, 0}, view.up = 0.4f * glm::normalize(glm::vec3(0, 1, -0.35f));
    view.size = {80, 64};
    view.pixel_spread = 2 * 0.4f / 64;
    return view;
}

// No pixel of the floor is refined: neighbours differ by their reflectance alone. The texture is sampled without rays.
TEST(AdaptiveSamples, TexturesOfPixelsThatAreNotRefinedAreTheMeansOfMany)
{
    for (const auto model : {scene::ShadingModel::metallic_roughness, scene::ShadingModel::whitted}) {
        const scene::SceneState state(std::make_shared<const scene::Scene>(striped_floor(model)), 0);
        const ray::RayScene rays(state);
        const scene::View view = over_the_floor();
        // No light is above the display's white, which would count less.
        trace::TracedOptions options{.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = -3.0f};
        options.refine.edge = options.refine.light = 10;   // no difference is as large
        options.refine.texture = 10;
        const Traced one = traced(state, rays, view, options);
        options.refine.texture = trace::TracedOptions().refine.texture;
        const Traced several = traced(state, rays, view, options);
        const Traced many = traced(state, rays, view, {.samples = 64, .filter = PixelFilter::blackman_harris});
        EXPECT_EQ(several.counters.samples.taken, 0u);
        EXPECT_EQ(several.counters.primary_rays, one.counters.primary_rays);
        const double before = rmse(one.buffers.color.data, many.buffers.color.data);
        const double after = rmse(several.buffers.color.data, many.buffers.color.data);
        EXPECT_LT(after, 0.5 * before) << static_cast<int>(model) << ": " << before;
    }
}

// A floor of stripes that mirrors an even background is as near to many samples as one that mirrors nothing.
TEST(AdaptiveSamples, WhatASurfaceMirrorsDoesNotFollowItsTexture)
{
    double errors[2];
    for (const bool bright : {false, true}) {
        scene::Scene scene = striped_floor(scene::ShadingModel::whitted);
        scene.background.color = glm::vec3(bright ? 4.0f : 0.0f);
        const scene::SceneState state(std::make_shared<const scene::Scene>(std::move(scene)), 0);
        const ray::RayScene rays(state);
        trace::TracedOptions options{.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = -3.0f};
        options.refine.edge = 10;
        const Traced adaptive = traced(state, rays, over_the_floor(), options);
        const Traced many =
            traced(state, rays, over_the_floor(), {.samples = 64, .filter = PixelFilter::blackman_harris});
        // The lower rows show the floor alone.
        const std::size_t from = std::size_t{48} * 80 * 3;
        errors[bright ? 1 : 0] = rmse(std::span(adaptive.buffers.color.data).subspan(from),
                                      std::span(many.buffers.color.data).subspan(from));
    }
    EXPECT_LT(errors[1], 1.2 * errors[0]) << errors[0];
}

// The light of a board below a near light is curved. Light that is taken at other places in the pixels must be so, too.
TEST(AdaptiveSamples, LightThatIsTakenIsNotBlurred)
{
    const Scene scene = board(false);
    const scene::SceneState state(api::scene_of(scene), 0);
    const ray::RayScene rays(state);
    scene::View view;
    view.eye = {0, 15, 0}, view.forward = {0, -1, 0};
    view.right = {0.9f, 0, 0}, view.up = {0, 0, -0.9f};
    view.size = {20, 20};
    view.pixel_spread = 2 * 0.9f / 20;
    trace::TracedOptions options{.filter = PixelFilter::blackman_harris, .adaptive = true, .exposure = 0.0f};
    options.refine.light = -1;          // all pixels are refined
    options.refine.agree = 1;           // and take light
    options.refine.light_spread = -1;   // with all samples
    const Traced taken = traced(state, rays, view, options);
    EXPECT_EQ(taken.counters.samples.taken, 20u * 20u * 16u);
    EXPECT_EQ(taken.counters.samples.shaded, 0u);
    options.refine.agree = -1;
    const Traced computed = traced(state, rays, view, options);
    EXPECT_LT(rmse(taken.buffers.color.data, computed.buffers.color.data), 0.003);   // means of neighbours: 0.0039
}

}   // namespace
}   // namespace gnomon
