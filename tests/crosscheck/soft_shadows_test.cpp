// SPDX-License-Identifier: Apache-2.0
// Lights with size in the rasterised frame against the traced one: unshadowed light, and the visible fraction of
// lights.
#include "api/scene_access.h"
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <filesystem>
#include <optional>

#include "bench/lights/raster.h"
#include "bench/lights/squares.h"
#include "gnomon/gnomon.h"
#include "raster/raster_frame.h"
#include "same_frames.h"
#include "scene/view.h"
#include "support.h"

namespace gnomon {
namespace {

class SoftShadows : public test::VulkanTest {};

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_down{0, 1, 2, 0, 2, 3}, k_up{0, 2, 1, 0, 3, 2}, k_half{0, 1, 2};

const Layer& layer(const Frame& image, const std::string& name)
{
    for (const Layer& l : image.layers)
        if (l.name == name) return l;
    throw std::runtime_error("no layer " + name);
}

RenderOptions options_of(RenderMethod renderer, Size size)
{
    RenderOptions options;
    options.renderer = renderer;
    options.size = size;
    options.indirect = Indirect::off;
    options.layers = true;
    options.max_depth = 0;
    options.exposure = 0;
    return options;
}

Frame rendered(RenderOptions options, const Scene& scene, int frame = 1)
{
    return Renderer(options).render(scene, frame);
}

// The rasterised frame against the traced one, with proven shares or by light views from several places.
bench::RasterLightsRow compare(const std::shared_ptr<const scene::Scene>& scene, Size size, std::size_t way = 0)
{
    const bench::RasterLightsResult result = bench::compare_raster_lights(scene, 1, size, 0, way > 0);
    EXPECT_GT(result.pixels, size.width * size.height / 4);
    return result.rows.at(way);
}

// One emitter over a floor of three materials, all in one plane, so that nothing occludes it.
enum class Emitter { near_square, tilted_triangle, small_and_far, spot };
Scene one_emitter(Emitter kind)
{
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .roughness = 1}),
                     metal = builder.material({.base_color = {0.9f, 0.8f, 0.6f}, .metallic = 1, .roughness = 0.35f}),
                     gloss = builder.material({.base_color = {0.2f, 0.3f, 0.6f}, .roughness = 0.2f});
    const MeshId down = builder.mesh({.positions = k_square, .indices = k_down}),
                 up = builder.mesh({.positions = k_square, .indices = k_up}),
                 triangle = builder.mesh({.positions = k_square, .indices = k_half});
    switch (kind) {
        case Emitter::near_square:
            builder.instance(down, builder.material({.base_color = {0, 0, 0}, .emissive = {4, 3, 2}}),
                             Transform::translation(0, 0.4, 0));
            break;
        case Emitter::tilted_triangle:   // it crosses the horizon of the floor
            builder.instance(triangle,
                             builder.material({.base_color = {0, 0, 0}, .double_sided = true, .emissive = {1, 2, 3}}),
                             Transform::translation(-0.8, 0.1, 0.3) * Transform::rotation({0, 0, 1}, 1.4));
            break;
        case Emitter::small_and_far:
            builder.instance(down, builder.material({.base_color = {0, 0, 0}, .emissive = {9e4f, 9e4f, 9e4f}}),
                             Transform::translation(3, 9, 2) * Transform::scaling(0.02, 1, 0.02));
            break;
        case Emitter::spot:   // a sphere that emits within a cone, in whose edge a part of the floor lies
            builder.area_light({.shape = AreaLightShape::sphere,
                                .width = 0.02f,
                                .radiance = {9e4f, 6e4f, 3e4f},
                                .inner_angle = 0.1f,
                                .outer_angle = 0.5f},
                               Transform::look_at({1, 4, 0}, {0, 0, 0.5f}));
    }
    builder.instance(up, white, Transform::translation(-2, 0, 0) * Transform::scaling(4, 1, 8));
    builder.instance(up, metal, Transform::translation(2, 0, -2) * Transform::scaling(4, 1, 4));
    builder.instance(up, gloss, Transform::translation(2, 0, 2) * Transform::scaling(4, 1, 4));
    Camera camera;
    camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0.2f, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    return builder.finish();
}

TEST_F(SoftShadows, UnshadowedLightIsThatOfTheTracedFrame)
{
    for (const Emitter kind : {Emitter::near_square, Emitter::tilted_triangle, Emitter::small_and_far, Emitter::spot}) {
        const Scene scene = one_emitter(kind);
        RenderOptions unshadowed = options_of(RenderMethod::raster, {80, 60});
        unshadowed.shadow_textures = ShadowTextures::off;
        const Frame traced = rendered(options_of(RenderMethod::trace, {80, 60}), scene),
                    raster = rendered(unshadowed, scene);
        const std::vector<float> a = layer(traced, "direct").copy(), b = layer(raster, "direct").copy(),
                                 za = layer(traced, "depth").copy(), zb = layer(raster, "depth").copy();
        std::size_t compared = 0, different = 0;
        float most = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            if (std::abs(za[i / 3] - zb[i / 3]) > 1e-4f * za[i / 3] || !(a[i] > 1e-4f)) continue;
            const float difference = std::abs(a[i] - b[i]) / a[i];
            ++compared, most = std::max(most, difference);
            different += difference > 5e-4f;
        }
        EXPECT_GT(compared, a.size() / 2);
        // At the border of two materials, a pixel may show either.
        EXPECT_LE(different, compared / 100) << static_cast<int>(kind) << ": at most " << most;
    }
}

// A floor, a square light of 1 m above it, and a box between them.
Scene box_under_a_square(double height, InstanceId* moving = nullptr)
{
    SceneBuilder builder;
    const MaterialId emitter = builder.material({.base_color = {0, 0, 0}, .emissive = {4, 4, 4}}),
                     white = builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .double_sided = true, .roughness = 1});
    const MeshId down = builder.mesh({.positions = k_square, .indices = k_down}),
                 up = builder.mesh({.positions = k_square, .indices = k_up});
    builder.instance(down, emitter, Transform::translation(0, 2, 0));
    builder.instance(up, white, Transform::scaling(8, 1, 8));
    const InstanceId board =
        builder.instance(up, white, Transform::translation(0.2, height, 0.1) * Transform::scaling(0.8, 1, 0.6),
                         {.mobility = moving ? Mobility::may_move : Mobility::fixed});
    if (moving) *moving = board;
    Camera camera;
    camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0.4f, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    return builder.finish();
}

TEST_F(SoftShadows, PenumbraOfASquareLightIsThatOfTheTracedFrame)
{
    for (const double height : {0.1, 0.5, 1.2}) {
        const bench::RasterLightsRow row = compare(api::scene_of(box_under_a_square(height)), {128, 96});
        EXPECT_LE(row.rmse, 0.003) << height;
        EXPECT_EQ(row.leaks, 0) << height;
    }
}

TEST_F(SoftShadows, LightViewsFromSeveralPlacesAreCloserThanPercentageCloserShadows)
{
    const auto scene = api::scene_of(box_under_a_square(1.2));
    const bench::RasterLightsResult result = bench::compare_raster_lights(scene, 1, {128, 96}, 0);
    EXPECT_LE(result.rows.at(1).rmse, 0.03);
    EXPECT_EQ(result.rows.at(1).leaks, 0);
    EXPECT_LT(result.rows.at(1).rmse, result.rows.at(2).rmse);
}

TEST_F(SoftShadows, FramesWithMovingObjectsAreThoseOfAFreshRenderer)
{
    InstanceId board;
    const Scene scene = box_under_a_square(0.5, &board);
    RenderOptions options = options_of(RenderMethod::raster, {96, 72});
    options.layers = false;
    Renderer kept(options);
    for (const double x : {0.2, 0.5, 0.5, -0.3}) {
        FrameInput input;
        input.time = 0.0;
        input.transforms.push_back({board, Transform::translation(x, 0.5, 0.1) * Transform::scaling(0.8, 1, 0.6)});
        test::expect_same(kept.render(scene, input), Renderer(options).render(scene, input));
        ASSERT_FALSE(HasFailure()) << x;
    }
}

TEST_F(SoftShadows, TheOverlayOfWhatWasRedrawnShowsTheViewsOfClusters)
{
    // A sphere of 16 clusters is the only light. The board's depths are drawn anew in frames in which it moved.
    SceneBuilder builder;
    const MaterialId white = builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .double_sided = true, .roughness = 1});
    const MeshId up = builder.mesh({.positions = k_square, .indices = k_up});
    builder.area_light({.shape = AreaLightShape::sphere, .width = 0.3f, .radiance = {9, 9, 9}},
                       Transform::translation(0, 1.6, 0));
    builder.instance(up, white, Transform::scaling(8, 1, 8));
    const auto at = [](double x) { return Transform::translation(x, 0.4, 0) * Transform::scaling(0.9, 1, 0.9); };
    const InstanceId board = builder.instance(up, white, at(0), {.mobility = Mobility::may_move});
    Camera camera;
    camera.transform = Transform::look_at({0, 4, 0.01}, {0, 0, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    const Scene scene = builder.finish();
    RenderOptions options = options_of(RenderMethod::raster, {64, 48});
    options.layers = false;
    options.overlay = Overlay::redrawn;
    Renderer renderer(options);
    const auto share_red = [&](double x) {
        FrameInput input;
        input.time = 0.0;
        input.transforms.push_back({board, at(x)});
        const std::vector<float> pixels = renderer.render(scene, input).layers.front().copy();
        std::size_t red = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 3) red += pixels[i] > 3 * pixels[i + 1];
        return static_cast<double>(red) / static_cast<double>(pixels.size() / 3);
    };
    share_red(0);
    EXPECT_GT(share_red(0.2), 0.03);
    share_red(0.2);
    EXPECT_EQ(share_red(0.2), 0.0);   // at rest, it is kept
}

TEST_F(SoftShadows, LightViewsThatAreKeptGiveTheImageOfNewOnes)
{
    InstanceId board;
    const Scene scene = box_under_a_square(0.5, &board);
    scene::SceneState state(api::scene_of(scene), 0);
    const scene::View view = scene::make_view(state, 0, {64, 48});
    const auto rendered_by = [&](raster::RasterFrame& frame) {
        shading::FrameBuffers out;
        frame.render(state, view, {}, out);
        return out.color.data;
    };
    raster::SizedDirectOptions options;
    options.atlas.view_size = 128;
    raster::RasterFrame kept(device_, state);
    auto sized = std::make_unique<raster::SizedDirect>(device_, state, options);
    const raster::SizedDirect& direct = *sized;
    kept.set_sized(std::move(sized));
    const std::vector<float> first = rendered_by(kept);
    EXPECT_EQ(direct.kept(), 0u);
    EXPECT_GT(direct.draws(), 0u);
    // Nothing is computed or drawn again while nothing changes.
    state.advance(0);
    kept.update(state);
    EXPECT_EQ(rendered_by(kept), first);
    EXPECT_EQ(direct.kept(), 1u);
    EXPECT_EQ(direct.draws(), 0u);
    // The board moves.
    const scene::NodeId node = state.scene().objects[2].node;
    for (const double x : {0.4, -0.2}) {
        const glm::dmat4 moved = glm::translate(glm::dmat4(1), glm::dvec3(x, 0.5, 0.1));
        state.override_transform(node, &moved);
        state.advance(0);
        kept.update(state);
        raster::RasterFrame fresh(device_, state);
        fresh.set_sized(std::make_unique<raster::SizedDirect>(device_, state, options));
        const std::vector<float> now = rendered_by(kept);
        EXPECT_NE(now, first);
        EXPECT_EQ(now, rendered_by(fresh)) << x;
    }
    EXPECT_EQ(direct.kept(), 1u);
}

TEST_F(SoftShadows, LightsThatApproximateSurfacesLightNothingDirectly)
{
    const Scene scene = box_under_a_square(0.5);
    ASSERT_FALSE(scene.info().lights.empty());
    const Frame frame = rendered(options_of(RenderMethod::raster, {48, 36}), scene);
    for (const float lit : layer(frame, "shadow").copy()) ASSERT_EQ(lit, 0);
}

// The scene of a file, if it is there.
std::optional<Scene> scene_of_file(const std::string& file)
{
    const std::filesystem::path path = test::scenes() / file;
    if (!std::filesystem::exists(path)) return {};
    return load(path);
}

TEST_F(SoftShadows, KitchenWithSquaresOf30CentimetresHasNoLeaks)
{
    const std::optional<Scene> kitchen = scene_of_file("bart/kitchen/aff/kitchen.aff");
    if (!kitchen) GTEST_SKIP() << "BART's Kitchen is missing";
    const scene::SceneState state(api::scene_of(*kitchen), 0);
    const bench::RasterLightsRow row = compare(bench::with_squares(state, 0.3f), {128, 128});
    EXPECT_LE(row.rmse, 0.03);
    EXPECT_EQ(row.leaks, 0);
}

TEST_F(SoftShadows, SponzaUnderASquareOfHalfAMetreHasNoLeaks)
{
    const std::optional<Scene> sponza = scene_of_file("sponza/sponza.obj");
    if (!sponza) GTEST_SKIP() << "Sponza is missing";
    const scene::SceneState state(api::scene_of(*sponza), 0);
    const Box3 box = state.scene().bounds(0);
    const glm::vec3 high(box.centre().x, box.low.y + 0.5f * box.size().y, box.centre().z);
    const float metre = box.size().x / 30;   // it is some 30 m long
    const bench::RasterLightsRow row =
        compare(bench::with_square(state, high, {0, -1, 0}, 0.5f * metre, 100), {128, 96});
    EXPECT_LE(row.rmse, 0.03);
    EXPECT_EQ(row.leaks, 0);
}

}   // namespace
}   // namespace gnomon
#else
TEST(SoftShadows, NeedVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
