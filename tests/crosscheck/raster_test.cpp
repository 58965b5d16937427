// SPDX-License-Identifier: Apache-2.0
// LONG: all compare two frames of one scene, by the same few helpers.
// The rasterised frame against the traced one, of the same scenes: surfaces, colours where no shadow is in doubt, and
// hard shadows. Pixels that show mirrors or glass are left out: there the rasterised frame shows something else.
#include "api/scene_access.h"
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "bright_lights.h"
#include "floor_scene.h"
#include "gnomon/gnomon.h"
#include "scene/defaults/surroundings.h"
#include "scene_helpers.h"
#include "support.h"

namespace gnomon {
namespace {

class RasterCrosscheck : public test::VulkanTest {};

constexpr float k_color_tolerance = 0.004f;   // of one colour channel, and of its relative part above 1
constexpr float k_depth_tolerance = 1e-3f;    // relative: the same surface
constexpr int k_edge_reach = 3;               // pixels between a differing pixel and an edge of a traced shadow

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
    options.shadow_culling = ShadowCulling::off;
    options.shadow_filter = 0;
    return options;
}

// One frame by both renderers.
struct Pair {
    Frame traced, raster;
    std::vector<char> plain;   // pixels that show no mirror and no glass, and the same surface in both
    std::size_t pixels = 0, plain_count = 0, lights = 0;

    float traced_lit(std::size_t pixel, std::size_t light) const
    {
        return layer(traced, "shadow").values()[pixel * lights + light];
    }
    float raster_lit(std::size_t pixel, std::size_t light) const
    {
        return layer(raster, "shadow").values()[pixel * lights + light];
    }
};

Pair render_both(const Scene& scene, int frame, Size size, ShadowTextures shadows)
{
    RenderOptions flat = options_of(RenderMethod::trace, size), deep = flat;
    flat.max_depth = 0;
    RenderOptions raster = options_of(RenderMethod::raster, size);
    raster.shadow_textures = shadows;
    Pair pair;
    pair.traced = Renderer(flat).render(scene, frame);
    pair.raster = Renderer(raster).render(scene, frame);
    const Frame mirrors = Renderer(deep).render(scene, frame);
    pair.pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    pair.lights = scene.info().lights.size();
    const auto &a = pair.traced.layers[0].copy(), &m = mirrors.layers[0].copy();
    const auto &za = layer(pair.traced, "depth").copy(), &zb = layer(pair.raster, "depth").copy();
    pair.plain.assign(pair.pixels, 0);
    for (std::size_t i = 0; i < pair.pixels; ++i) {
        bool same = std::abs(za[i] - zb[i]) <= k_depth_tolerance * za[i];
        for (std::size_t c = 0; c < 3; ++c) same = same && a[3 * i + c] == m[3 * i + c];
        pair.plain[i] = same;
        pair.plain_count += same;
    }
    return pair;
}

// Where GNOMON_IMAGES names a folder: the traced image, grey, and in red what differs.
void write_differences(const Pair& pair, Size size, const std::vector<char>& differs, const std::string& name)
{
    const char* folder = std::getenv("GNOMON_IMAGES");
    if (!folder) return;
    Frame image;
    image.size = size;
    image.tonemap = ToneMap::none;
    image.exposure = pair.traced.exposure;
    image.layers.push_back(pair.traced.layers[0]);
    std::vector<float> rgb = image.layers[0].copy();
    image.layers[0].data = rgb.data();
    for (std::size_t i = 0; i < pair.pixels; ++i) {
        const float grey = pair.plain[i] ? 0.2f + 0.2f * (rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2]) : 0.0f;
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] = differs[i] ? (c == 0 ? 4.0f : 0.0f) : grey;
    }
    image.write(std::filesystem::path(folder) / (name + ".png"));
    Frame raster = pair.raster;
    raster.write(std::filesystem::path(folder) / (name + "-raster.png"));
}

std::string test_name()
{
    static int number = 0;
    return fmt::format("{}-{}", testing::UnitTest::GetInstance()->current_test_info()->name(), ++number);
}

// Colours agree wherever both see the same surface and the same lights of it.
void expect_same_light(const Scene& scene, int frame, double least_plain, ShadowTextures shadows = ShadowTextures::off)
{
    const Pair pair = render_both(scene, frame, {160, 120}, shadows);
    EXPECT_GE(static_cast<double>(pair.plain_count), least_plain * static_cast<double>(pair.pixels));
    const auto &a = pair.traced.layers[0].copy(), &b = pair.raster.layers[0].copy();
    std::size_t compared = 0, different = 0;
    float worst = 0;
    std::vector<char> differs(pair.pixels, 0);
    for (std::size_t i = 0; i < pair.pixels; ++i) {
        bool comparable = pair.plain[i];
        for (std::size_t l = 0; l < pair.lights; ++l)
            comparable = comparable && pair.traced_lit(i, l) == pair.raster_lit(i, l);
        if (!comparable) continue;
        ++compared;
        float most = 0;
        for (std::size_t c = 0; c < 3; ++c)
            most = std::max(most, std::abs(a[3 * i + c] - b[3 * i + c]) / std::max(1.0f, a[3 * i + c]));
        worst = std::max(worst, most);
        different += differs[i] = most > k_color_tolerance;
    }
    write_differences(pair, {160, 120}, differs, test_name());
    EXPECT_GT(compared, pair.pixels / 10);
    // A silhouette in a texture, or an edge between two triangles, may fall on the other side.
    EXPECT_LE(static_cast<double>(different), 0.002 * static_cast<double>(compared))
        << different << " of " << compared << ", worst " << worst;
}

constexpr double k_most_different = 0.005;   // of pixels, in any light
constexpr double k_most_far_off = 5e-4;      // of pixels: differ and lie away from edges of shadows

// Shadows agree on nearly all pixels; those that differ lie on edges of shadows.
void expect_same_shadows(const Scene& scene, int frame, Size size, ShadowTextures method)
{
    const Pair pair = render_both(scene, frame, size, method);
    std::size_t different = 0, far_from_edges = 0, lit = 0, dark = 0, results = 0;
    std::vector<char> marks(pair.pixels, 0);
    const auto near_edge = [&](std::size_t i, std::size_t l) {
        const int x = static_cast<int>(i) % size.width, y = static_cast<int>(i) / size.width;
        for (int dy = -k_edge_reach; dy <= k_edge_reach; ++dy)
            for (int dx = -k_edge_reach; dx <= k_edge_reach; ++dx) {
                if (x + dx < 0 || y + dy < 0 || x + dx >= size.width || y + dy >= size.height) continue;
                const auto other = static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(size.width) +
                                   static_cast<std::size_t>(x + dx);
                if (pair.traced_lit(other, l) == pair.raster_lit(i, l)) return true;
            }
        return false;
    };
    for (std::size_t i = 0; i < pair.pixels; ++i) {
        if (!pair.plain[i]) continue;
        bool differs = false, far = false;
        for (std::size_t l = 0; l < pair.lights; ++l) {
            (pair.traced_lit(i, l) > 0 ? lit : dark) += 1;
            if (pair.traced_lit(i, l) == pair.raster_lit(i, l)) continue;
            differs = true;
            ++results;
            far = far || !near_edge(i, l);
        }
        different += marks[i] = differs;
        far_from_edges += far;
    }
    write_differences(pair, size, marks, test_name());
    EXPECT_GT(lit, pair.pixels / 50);
    EXPECT_GT(dark, pair.pixels / 50);
    const double share = static_cast<double>(different) / static_cast<double>(pair.plain_count);
    const double result_share = static_cast<double>(results) / static_cast<double>(lit + dark);
    const double far_share = static_cast<double>(far_from_edges) / static_cast<double>(pair.plain_count);
    EXPECT_LE(share, k_most_different);
    EXPECT_LE(far_share, k_most_far_off);
    testing::Test::RecordProperty("shadow_results_equal_percent", std::to_string(100 * (1 - result_share)));
    if (std::getenv("GNOMON_IMAGES"))
        fmt::print("equal: {:.3f} % of results, {:.3f} % of pixels; far from edges {:.3f} %\n",
                   100 - 100 * result_share, 100 - 100 * share, 100 * far_share);
    testing::Test::RecordProperty("shadow_pixels_equal_percent", std::to_string(100 * (1 - share)));
}

TEST_F(RasterCrosscheck, ColoursOfCornellEqualTheTracedFrame)
{
    expect_same_light(load("builtin:cornell"), 12, 0.98);
}

TEST_F(RasterCrosscheck, BrightestLightsGiveFiniteColours)
{
    for (const Indirect indirect : {Indirect::visible, Indirect::quadtree})
        for (const test::BrightScene& bright : test::bright_scenes({"3.4e38"})) {
            RenderOptions options = options_of(RenderMethod::raster, {32, 24});
            options.indirect = indirect;
            const Frame image = Renderer(options).render(bright.scene, 1);
            EXPECT_EQ(test::count_of_no_numbers(image), 0u)
                << bright.name << ", indirect " << static_cast<int>(indirect);
            EXPECT_GT(test::brightest_of(image), std::min(bright.at_least, 1e4f)) << bright.name;
        }
}

TEST_F(RasterCrosscheck, ColoursOfKineticEqualTheTracedFrame)
{
    expect_same_light(load("builtin:kinetic"), 40, 0.7);
}

// Instances, mirrored ones, one-sided and masked surfaces, deforming meshes; glass.
TEST_F(RasterCrosscheck, ColoursOfRandomScenesEqualTheTracedFrame)
{
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        SCOPED_TRACE(seed);
        scene::Scene scene = *test::make_random_scene(seed);
        scene::add_default_camera(scene);
        // So that glass with nothing behind it shows as glass, too, and is left out.
        scene.background = {};
        scene.background.color = glm::vec3(0.1f);
        const Scene lit = api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)))
                              .with_light_specs({"point 0 9 4 300 280 260", "spot 8 8 8 -1 -1 -1 40 200 300 200"});
        expect_same_light(lit, 1, 0.5);
    }
}

// Footprints a hundred times as long as wide, of a texture that is turned.
TEST_F(RasterCrosscheck, ColoursOfAFloorToTheHorizonEqualTheTracedFrame)
{
    expect_same_light(test::floor_to_the_horizon(), 1, 0.98);
}

// Bumps, from the front and from behind; turned with their image, or by the file's tangents.
TEST_F(RasterCrosscheck, ColoursOfNormalMapsEqualTheTracedFrame)
{
    scene::Scene scene;
    Image8 bumps(16, 16, 3);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const std::uint8_t texel[] = {static_cast<std::uint8_t>(64 + 8 * x), static_cast<std::uint8_t>(192 - 8 * y),
                                          220};
            std::copy_n(texel, 3, bumps.pixel(x, y));
        }
    scene.textures.emplace_back("bumps", bumps, false, scene::Sampler());
    scene::Material material;
    material.double_sided = true;
    material.normal_texture.texture = 0;
    for (const float rotation : {0.0f, 2.0f}) {
        material.normal_texture.rotation = rotation;
        scene.materials.push_back(material);
    }
    for (int i = 0; i < 6; ++i) {
        scene::Mesh mesh;
        mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        mesh.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        if (i % 3 == 2) mesh.tangents.assign(4, {std::cos(0.7f), std::sin(0.7f), 0, i < 3 ? 1 : -1});
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{i % 3 == 0 ? 0u : 1u, 0, 2}};
        scene.meshes.push_back(mesh);
        const glm::dmat4 place = test::translation(2.2 * (i % 3 - 1), i < 3 ? 1.1 : -1.1, 0);
        const glm::dmat4 turned = glm::rotate(glm::dmat4(1), i < 3 ? 0.0 : k_pi, glm::dvec3(0, 1, 0));
        test::add_object(scene, static_cast<scene::MeshId>(i), scene::none, place * turned);
    }
    scene::Camera camera;
    camera.node = scene.add_node("camera", scene::none, test::translation(0, 0, 7));
    scene.cameras.push_back(camera);
    scene::Scene whole = *test::finished(scene);
    const Scene lit = api::public_scene(std::make_shared<const scene::Scene>(std::move(whole)))
                          .with_light_specs({"point -6 6 4 300 280 260"});
    expect_same_light(lit, 1, 0.95);
}

TEST_F(RasterCrosscheck, ColoursOfSceneFilesEqualTheTracedFrame)
{
    for (const char* name : {"gltf/CesiumMilkTruck.glb", "gltf/BoxAnimated.glb", "gltf/cannon.glb"}) {
        SCOPED_TRACE(name);
        GNOMON_NEED_SCENE(file, name);
        const Scene scene = load(file.string());
        expect_same_light(scene, scene.frame_count() / 2, 0.9);
    }
}

// Beside bounced light, too: an image behind the windows is seen by its ambient colour, and a court is filled dimly.
TEST_F(RasterCrosscheck, BackdropsAndCourtyardFillLightEqualTheTracedFrame)
{
    scene::Scene scene;
    scene::Material court, backdrop;
    court.double_sided = true;
    backdrop.model = scene::ShadingModel::whitted;
    backdrop.double_sided = true;
    backdrop.base_color = glm::vec3(0);
    backdrop.ambient = {1, 0.5f, 0.25f};
    scene.materials = {court, backdrop};
    for (const scene::MaterialId material : {0u, 1u}) {
        scene.meshes.push_back(test::ball(material, 12, 18));
        test::add_object(scene, material, scene::none, test::translation(material == 0 ? -1.5 : 1.5, 0, 0));
    }
    scene::Scene whole = *test::finished(scene);
    whole.ambient = glm::vec3(0.5f);
    whole.background.kind = scene::Background::Kind::sky;
    whole.background.color = glm::vec3(0.1f);
    scene::add_default_camera(whole);
    const Scene lit = api::public_scene(std::make_shared<const scene::Scene>(std::move(whole)))
                          .with_light_specs({"point 0 9 4 300 280 260"});
    std::vector<float> seen[2];
    for (const RenderMethod renderer : {RenderMethod::trace, RenderMethod::raster}) {
        RenderOptions options = options_of(renderer, {96, 64});
        options.indirect = Indirect::visible;
        options.max_depth = 0;
        seen[renderer == RenderMethod::raster] = Renderer(options).render(lit, 1).layers[0].copy();
    }
    std::size_t different = 0;
    for (std::size_t i = 0; i < seen[0].size(); ++i) different += std::abs(seen[0][i] - seen[1][i]) > 0.02f;
    EXPECT_LE(different, seen[0].size() / 100);   // at edges, of objects and shadows
}

// A cube and a pane that covers half of what is behind it, on a ground that catches shadows, under the sun.
Scene cube_on_a_ground()
{
    scene::Scene scene;
    scene.materials.resize(2);
    scene.materials[0].base_color = {0.7f, 0.4f, 0.2f};
    scene.materials[0].ior = 1;
    scene.materials[1] = scene.materials[0];
    scene.materials[1].alpha = 0.5f;
    scene.materials[1].alpha_mode = scene::AlphaMode::blend;
    scene.materials[1].double_sided = true;
    scene::Mesh cube, pane;
    for (int i = 0; i < 8; ++i) cube.positions.push_back(glm::vec3(i & 1, i >> 1 & 1, i >> 2 & 1) - 0.5f);
    cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    cube.parts = {{0, 0, 12}};
    pane.positions = {{-1.5f, -0.5f, 0.8f}, {-0.2f, -0.5f, 0.8f}, {-0.2f, 1, 0.8f}, {-1.5f, 1, 0.8f}};
    pane.triangles = {{0, 1, 2}, {0, 2, 3}};
    pane.parts = {{1, 0, 2}};
    scene.meshes.push_back(cube);
    scene.meshes.push_back(pane);
    for (const scene::MeshId mesh : {0u, 1u}) test::add_object(scene, mesh);
    scene::Light sun;
    sun.type = scene::LightType::directional;
    sun.color = glm::vec3(2);
    sun.node = scene.add_node("sun", scene::none, glm::rotate(glm::dmat4(1), -0.9, glm::dvec3(1, 0.4, 0)));
    scene.lights.push_back(sun);
    scene.finish();
    scene::add_default_camera(scene);
    scene::add_ground(scene, scene::k_wanted_ground);
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

TEST_F(RasterCrosscheck, WhatLiesBehindTheSceneIsKeptApartAsInTheTracedFrame)
{
    const Scene scene = cube_on_a_ground();
    std::vector<float> color[2], alpha[2];
    std::vector<std::uint8_t> shown[2];
    for (const RenderMethod renderer : {RenderMethod::trace, RenderMethod::raster}) {
        RenderOptions options = options_of(renderer, {96, 64});
        options.background = BackgroundKind::color;
        options.background_color[0] = 1, options.background_color[2] = 0.5f;
        options.exposure = 0;
        options.max_depth = 4;
        const Frame frame = Renderer(options).render(scene, 1);
        const int i = renderer == RenderMethod::raster;
        color[i] = frame.layers[0].copy(), alpha[i] = layer(frame, "alpha").copy();
        shown[i] = frame.to_srgb8();
    }
    // Each kind of pixel is there: the scene, nothing, the pane before nothing, shadows on the ground.
    std::size_t kinds[4] = {};
    for (const float a : alpha[0]) ++kinds[a > 0.99f ? 0 : a < 0.01f ? 1 : std::abs(a - 0.5f) < 0.02f ? 2 : 3];
    EXPECT_GT(kinds[0], 200u);
    EXPECT_GT(kinds[1], 1000u);
    EXPECT_GT(kinds[2], 50u);
    std::size_t different = 0, different_shown = 0;
    for (std::size_t i = 0; i < alpha[0].size(); ++i) different += std::abs(alpha[0][i] - alpha[1][i]) > 0.02f;
    for (std::size_t i = 0; i < color[0].size(); ++i) different += std::abs(color[0][i] - color[1][i]) > 0.02f;
    for (std::size_t i = 0; i < shown[0].size(); ++i) different_shown += std::abs(shown[0][i] - shown[1][i]) > 6;
    EXPECT_LE(different, alpha[0].size() / 50);   // at edges, of objects and shadows
    EXPECT_LE(different_shown, shown[0].size() / 50);
}

TEST_F(RasterCrosscheck, ColoursOfKitchenEqualTheTracedFrame)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    expect_same_light(load(file.string()), 200, 0.3, ShadowTextures::coherent);
}

TEST_F(RasterCrosscheck, HardShadowsOfCornellEqualTheTracedFrame)
{
    for (const ShadowTextures method : {ShadowTextures::coherent, ShadowTextures::depth, ShadowTextures::per_caster})
        expect_same_shadows(load("builtin:cornell"), 12, {320, 320}, method);
}

TEST_F(RasterCrosscheck, HardShadowsOfKineticEqualTheTracedFrame)
{
    expect_same_shadows(load("builtin:kinetic"), 40, {320, 180}, ShadowTextures::coherent);
}

TEST_F(RasterCrosscheck, HardShadowsOfKitchenEqualTheTracedFrame)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    const Scene scene = load(file.string());
    for (const int frame : {1, 60, 200}) expect_same_shadows(scene, frame, {320, 240}, ShadowTextures::coherent);
}

// Balls of a chessboard of holes over a floor, or the same without holes.
Scene balls_over_floor(bool holes)
{
    scene::Scene scene;
    test::add_materials(scene);
    for (const scene::MaterialId material : {test::two_sided, holes ? test::cut_out : test::two_sided})
        scene.meshes.push_back(test::ball(material, 12, 18));
    test::add_object(scene, 0, scene::none,
                     test::translation(0, -1, 0) * glm::scale(glm::dmat4(1), glm::dvec3(8, 0.1, 8)));
    for (const glm::dvec3& at : {glm::dvec3(-2, 1, -1), glm::dvec3(2, 1.5, 0), glm::dvec3(0, 2, 2)})
        test::add_object(scene, 1, scene::none, test::translation(at.x, at.y, at.z));
    scene::Scene whole = *test::finished(scene);
    scene::add_default_camera(whole);
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(whole)))
        .with_light_specs({"point 0 9 4 300 280 260", "spot 8 8 8 -1 -1 -1 40 200 300 200"});
}

// Alpha-tested casters, apart: light falls through their holes, and there alone.
TEST_F(RasterCrosscheck, HardShadowsOfAlphaTestedObjectsEqualTheTracedFrame)
{
    const Size size{240, 180};
    expect_same_shadows(balls_over_floor(true), 1, size, ShadowTextures::coherent);
    const RenderOptions options = options_of(RenderMethod::raster, size);
    const Frame holes = Renderer(options).render(balls_over_floor(true), 1),
                whole = Renderer(options).render(balls_over_floor(false), 1);
    const auto &a = layer(holes, "shadow").copy(), &b = layer(whole, "shadow").copy();
    const std::size_t lights = a.size() / layer(holes, "depth").values().size();
    std::size_t through = 0;   // lit behind the holes alone, of the same surface
    for (std::size_t i = 0; i < a.size(); ++i)
        through +=
            layer(holes, "depth").values()[i / lights] == layer(whole, "depth").values()[i / lights] && a[i] > b[i];
    EXPECT_GT(through, 200u);
}

// A dynamic object with a singular transform is invisible and casts no shadow in either frame. A static one is visible
// and casts a shadow.
TEST_F(RasterCrosscheck, SingularTransformsAreHandledAsInTheTracedFrame)
{
    const glm::dmat4 flat = test::translation(0, 2, 0) * glm::scale(glm::dmat4(1), glm::dvec3(1.5, 0, 1.5));
    std::size_t seen[2] = {0, 0};
    for (const bool moves : {false, true}) {
        scene::Scene made;
        test::add_materials(made);
        made.meshes.push_back(test::ball(test::two_sided, 12, 18));
        test::add_object(made, 0, scene::none,
                         test::translation(0, -1, 0) * glm::scale(glm::dmat4(1), glm::dvec3(8, 0.1, 8)));
        const scene::NodeId node = test::add_object(made, 0, scene::none, flat);
        if (moves)
            made.nodes[node].transform =
                std::make_shared<test::JumpTrack>(1, flat, flat * test::translation(0.1, 0, 0));
        scene::Scene whole = *test::finished(made);
        scene::add_default_camera(whole);
        const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(std::move(whole)))
                                .with_light_specs({"point 2 9 1 300 280 260"});
        const Size size{120, 90};
        for (const ShadowTextures method :
             {ShadowTextures::coherent, ShadowTextures::depth, ShadowTextures::per_caster}) {
            RenderOptions raster = options_of(RenderMethod::raster, size);
            raster.shadow_textures = method;
            const Frame a = Renderer(options_of(RenderMethod::trace, size)).render(scene, 1),
                        b = Renderer(raster).render(scene, 1);
            const auto &za = layer(a, "depth").copy(), &zb = layer(b, "depth").copy();
            const auto &la = layer(a, "shadow").copy(), &lb = layer(b, "shadow").copy();
            std::size_t different = 0;
            for (std::size_t i = 0; i < za.size(); ++i) {
                different += !(std::abs(za[i] - zb[i]) <= k_depth_tolerance * za[i]) || la[i] != lb[i];
                seen[moves] += za[i] > 0 && la[i] == 0;
            }
            EXPECT_EQ(test::count_of_no_numbers(b), 0u);
            EXPECT_LT(different, za.size() / 250) << (moves ? "moves, " : "stands, ") << static_cast<int>(method);
        }
    }
    EXPECT_GT(seen[0], seen[1] + 300) << "its shadow";
}

// What is remembered changes nothing: a video's frames are those of fresh renderers, by all three methods.
double error_of(const Frame& image, const Frame& truth, const std::string& name)
{
    const std::span<const float> a = layer(image, name).values(), b = layer(truth, name).values();
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * static_cast<double>(a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

// Against 64 samples that are all shaded. What is not averaged stays that of the pixels' centres.
TEST_F(RasterCrosscheck, AdaptiveSamplesCleanEdges)
{
    for (const char* name : {"builtin:cornell", "builtin:spheres?objects=20&dynamic=20&vertices=200"}) {
        const Scene scene = load(name);
        RenderOptions options = options_of(RenderMethod::raster, {96, 64});
        options.filter = PixelFilter::box;
        options.background = BackgroundKind::transparent;
        options.samples = 1;
        const Frame one = Renderer(options).render(scene, 2);
        options.samples = 64;
        const Frame many = Renderer(options).render(scene, 2);
        options.samples = k_adaptive_samples;
        Renderer renderer(options);
        const Frame adaptive = renderer.render(scene, 2);
        EXPECT_LT(error_of(adaptive, many, ""), 0.6 * error_of(one, many, "")) << name;
        EXPECT_LT(error_of(adaptive, many, "alpha"), 0.6 * error_of(one, many, "alpha") + 1e-6) << name;
        EXPECT_LT(error_of(adaptive, many, "albedo"), error_of(one, many, "albedo")) << name;
        EXPECT_EQ(error_of(adaptive, one, "depth"), 0) << name;
        EXPECT_GT(adaptive.counters.samples.pixels, 0u) << name;
        EXPECT_LT(adaptive.counters.samples.pixels, 96u * 64u / 2) << name;
        // The same bytes once more, and without layers.
        EXPECT_EQ(error_of(renderer.render(scene, 2), adaptive, ""), 0) << name;
        options.layers = false;
        EXPECT_EQ(error_of(Renderer(options).render(scene, 2), adaptive, ""), 0) << name;
    }
}

// With a shutter, images at several places of the pixel filter are averaged. Frames before change nothing.
TEST_F(RasterCrosscheck, BlurredFramesWithAdaptiveSamplesFollowTheFilterAndNoHistory)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = options_of(RenderMethod::raster, {24, 18});
    options.layers = false, options.exposure = 0;
    options.shadow_textures = ShadowTextures::off;
    options.samples = k_adaptive_samples;
    options.shutter = 360;
    Renderer video(options);
    video.render(scene, 4);
    const Frame blurred = video.render(scene, 5);
    EXPECT_EQ(error_of(Renderer(options).render(scene, 5), blurred, ""), 0);
    options.filter = PixelFilter::box;
    EXPECT_GT(error_of(Renderer(options).render(scene, 5), blurred, ""), 0.005);
}

TEST_F(RasterCrosscheck, FramesOfAVideoEqualFreshRenderers)
{
    const Scene scene = load("builtin:cornell");
    for (const ShadowTextures method : {ShadowTextures::coherent, ShadowTextures::depth}) {
        RenderOptions options = options_of(RenderMethod::raster, {80, 80});
        options.shadow_textures = method;
        Renderer video(options);
        for (const int frame : {1, 2, 3, 12, 5}) {
            const Frame a = video.render(scene, frame), b = Renderer(options).render(scene, frame);
            EXPECT_EQ(a.layers[0].copy(), b.layers[0].copy()) << frame;
            EXPECT_GT(a.counters.draws, 0u);
        }
    }
}

// What moves is red, what it left and what it now covers is as the light views say; a frame like the last is grey.
TEST_F(RasterCrosscheck, OverlayShowsRedrawnTexels)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = options_of(RenderMethod::raster, {80, 80});
    options.layers = false;
    options.overlay = Overlay::redrawn;
    Renderer renderer(options);
    const auto count = [](const Frame& image, auto&& is) {
        const std::span<const float> rgb = image.layers[0].values();
        std::size_t found = 0;
        for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) found += is(rgb[i], rgb[i + 1], rgb[i + 2]);
        return found;
    };
    const auto red = [](float r, float g, float) { return r > 4 * g; };
    const auto colored = [](float r, float g, float b) { return std::abs(r - g) > 1e-3f || std::abs(g - b) > 1e-3f; };
    renderer.render(scene, 10);
    const Frame moved = renderer.render(scene, 11);
    EXPECT_EQ(moved.size, (Size{80, 80}));
    // The ball, and nothing that it does not meet.
    EXPECT_GT(count(moved, red), 20u);
    EXPECT_LT(count(moved, red), 400u);
    const Frame kept = renderer.render(scene, 11);
    EXPECT_EQ(count(kept, red), 0u);
    EXPECT_EQ(count(kept, colored), 0u);
}

// Limits of a device that a shader can be given little of at once.
void forget_large_buffers(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties)
{
    VkPhysicalDeviceProperties2 all{};
    all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    vkGetPhysicalDeviceProperties2(device, &all);
    *properties = all.properties;
    properties->limits.maxStorageBufferRange = 4 << 20;
}

// Of 9 lights, in batches of 8, the layers of 3 fit at once.
TEST_F(RasterCrosscheck, LayersBeyondTheStorageBufferLimit)
{
    std::vector<std::string> lights;
    for (int l = 0; l < 9; ++l) lights.push_back(fmt::format("point {} 0.5 1 {} 1 2", 0.4 * l - 2.2, 1 + l));
    const Scene scene = test::light_at_a_corner().with_light_specs(lights);
    RenderOptions options = options_of(RenderMethod::raster, {639, 481});
    options.shadow_textures = ShadowTextures::depth;
    options.shadow_filter = 1;
    const Frame whole = Renderer(options).render(scene, 1);
    const test::Replaced small(vkGetPhysicalDeviceProperties, forget_large_buffers);
    const Frame parts = Renderer(options).render(scene, 1);
    ASSERT_EQ(parts.layers.size(), whole.layers.size());
    for (std::size_t l = 0; l < whole.layers.size(); ++l)
        EXPECT_EQ(parts.layers[l].copy(), whole.layers[l].copy()) << whole.layers[l].name;
    options.size = {1200, 900};
    EXPECT_THROW(Renderer(options).render(scene, 1), MissingError);
}

TEST_F(RasterCrosscheck, FaultsAreMissingErrorsAndTheNextFrameIsComplete)
{
    const Scene scene = load("builtin:cornell");
    const RenderOptions options = options_of(RenderMethod::raster, {40, 40});
    {
        const test::Replaced full(
            vkAllocateMemory,
            +[](VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*, VkDeviceMemory*) -> VkResult {
                return VK_ERROR_OUT_OF_DEVICE_MEMORY;
            });
        EXPECT_THROW(Renderer(options).render(scene, 1), MissingError);
    }
    Renderer renderer(options);
    const Frame whole = renderer.render(scene, 2);
    {
        const test::Replaced lost(
            vkQueueSubmit2,
            +[](VkQueue, std::uint32_t, const VkSubmitInfo2*, VkFence) -> VkResult { return VK_ERROR_DEVICE_LOST; });
        EXPECT_THROW(renderer.render(scene, 1), MissingError);
    }
    EXPECT_EQ(renderer.render(scene, 2).layers[0].copy(), whole.layers[0].copy());
    EXPECT_THROW(renderer.render(scene, 1, [](const ProgressStep&) { return false; }), InterruptedError);
    EXPECT_EQ(renderer.render(scene, 2).layers[0].copy(), whole.layers[0].copy());
}

}   // namespace
}   // namespace gnomon
#else
TEST(RasterCrosscheck, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
