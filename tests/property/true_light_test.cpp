// SPDX-License-Identifier: Apache-2.0
// The default indirect light in absolute units, against the path tracer and closed forms. Tests that compare a cache
// with one made anew cannot see an error that both have.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aff_files.h"
#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/near_field/near_light.h"
#include "light_quadtree/clusters.h"
#include "world.h"

namespace gnomon {
namespace {

constexpr double k_closeness = 0.03;   // of the energy

// The mean of the layer of indirect light.
double energy_of(const Scene& scene, int frame, RenderOptions options)
{
    options.layers = true;
    const Frame image = Renderer(options).render(scene, frame);
    const auto layer = std::ranges::find(image.layers, "indirect", &Layer::name);
    double sum = 0;
    for (const float value : layer->values()) sum += static_cast<double>(value);
    return sum / static_cast<double>(layer->values().size());
}

void expect_true_energy(const Scene& scene, int frame, int bounces, int size, double closeness = k_closeness)
{
    RenderOptions options;
    options.size = {size, size};
    options.bounces = bounces;
    options.max_depth = 0;
    const double cached = energy_of(scene, frame, options);
    options.reference = ReferenceLightOptions{.spp = 64, .bounces = bounces};
    const double truth = energy_of(scene, frame, options);
    ASSERT_GT(truth, 0);
    EXPECT_NEAR(cached / truth, 1, closeness) << "frame " << frame << ", bounces " << bounces;
    std::printf("frame %d, bounces %d: %.4f of the reference's energy\n", frame, bounces, cached / truth);
}

Material matte(const Vec3& color)
{
    Material material{.base_color = color, .roughness = 1, .ior = 1};
    material.double_sided = true;
    return material;
}

MeshId add_square(SceneBuilder& builder)
{
    const std::vector<Vec3> corners{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    const std::vector<std::uint32_t> up{0, 2, 1, 0, 3, 2};
    return builder.mesh({.positions = corners, .indices = up});
}

void add_camera(SceneBuilder& builder, const Vec3& eye, const Vec3& target)
{
    Camera camera;
    camera.transform = Transform::look_at(eye, target);
    camera.vertical_fov = 1;
    builder.camera(camera);
}

void add_point_light(SceneBuilder& builder, const Vec3& place, float intensity)
{
    builder.light({.color = {intensity, intensity, intensity}},
                  Transform::translation(static_cast<double>(place.x), static_cast<double>(place.y),
                                         static_cast<double>(place.z)));
}

// The built-in box, whose ball is a dynamic object.
TEST(TrueLight, OfTheCornellBoxIsThatOfTheReference)
{
    const Scene scene = load("builtin:cornell");
    for (const int frame : {3, 20}) expect_true_energy(scene, frame, k_all_bounces, 128);
    expect_true_energy(scene, 3, 1, 128);
}

// The box of builtin:cornell without its light, under a sky that is seen through the open side.
TEST(TrueLight, OfTheSkyIsThatOfTheReference)
{
    scene::Scene made = scene::make_builtin("cornell");
    made.lights.clear();
    made.background.kind = scene::Background::Kind::sky;
    made.finish();
    const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(std::move(made)));
    expect_true_energy(scene, 3, 1, 128);
    expect_true_energy(scene, 3, k_all_bounces, 128);
}

// Surfaces of AFF: their light has no falloff, and their colours are radiance per irradiance.
TEST(TrueLight, OfAnAffSceneIsThatOfTheReference)
{
    const test::AffFolder folder;
    std::string text = "v from 0 1 4.5 at 0 1 0 up 0 1 0 angle 50 hither 0.01 resolution 64 64\nl 0.4 1.6 1 .8 .8 .8\n";
    const auto wall = [&](const char* color, const char* corners) {
        text += fmt::format("f {} 1 0 0 0 1\np 4 {}\n", color, corners);
    };
    wall(".2 .2 .2", "-1 0 -1  -1 0 1.5  1 0 1.5  1 0 -1");
    wall(".2 .2 .2", "-1 2 -1  1 2 -1  1 2 1.5  -1 2 1.5");
    wall(".25 .2 .15", "-1 0 -1  1 0 -1  1 2 -1  -1 2 -1");
    wall(".3 .05 .05", "-1 0 1.5  -1 0 -1  -1 2 -1  -1 2 1.5");
    wall(".05 .3 .05", "1 0 -1  1 0 1.5  1 2 1.5  1 2 -1");
    folder.write(folder.main(), text);
    const Scene scene = load(folder.main().string());
    expect_true_energy(scene, 1, 1, 128);
    expect_true_energy(scene, 1, k_all_bounces, 128);
}

// A panel that may move bounces the light of a spot light onto a ceiling, which sees no other light.
TEST(TrueLight, OfDynamicObjectsIsThatOfTheReference)
{
    for (const bool small : {false, true}) {
        SceneBuilder builder;
        const MeshId square = add_square(builder);
        const MaterialId white = builder.material(matte({0.8f, 0.7f, 0.6f}));
        const double side = small ? 0.3 : 0.6;
        builder.instance(square, white, Transform::scaling(side, 1, side), {.mobility = Mobility::may_move});
        builder.instance(square, white, Transform::translation(0, 2, 0) * Transform::scaling(3, 1, 3));
        // A light that shines down only: it lights the panel alone.
        Light spot{.color = {3, 3, 3}};
        spot.type = LightType::spot;
        spot.outer_angle = 1.2f, spot.inner_angle = 0;
        builder.light(spot, Transform::look_at({0.1f, 1, 0}, {0.1f, 0, 0}, {1, 0, 0}));
        add_camera(builder, {0, 0.6f, 0.2f}, {0, 2, 0});
        expect_true_energy(builder.finish(), 1, 1, 48, 0.05);
    }
}

// A small ball that may move, in front of everything and in nobody's way: its bounding sphere crosses many paths, which
// it leaves open.
TEST(TrueLight, IsNotLostAroundDynamicObjects)
{
    SceneBuilder builder;
    const MeshId square = add_square(builder);
    const MaterialId white = builder.material(matte({0.7f, 0.7f, 0.7f}));
    const Transform large = Transform::scaling(4, 1, 4);
    builder.instance(square, white, large);
    builder.instance(square, white, Transform::translation(0, 2, 0) * large);
    // A thin diagonal strip.
    const MaterialId black = builder.material(matte({0, 0, 0}));
    builder.instance(
        square, black,
        Transform::translation(0, 1, 0) * Transform::rotation({0, 0, 1}, 0.7) * Transform::scaling(2.4, 1, 0.01),
        {.mobility = Mobility::may_move});
    Light spot{.color = {3, 3, 3}};
    spot.type = LightType::spot;
    spot.outer_angle = 1.1f, spot.inner_angle = 0;
    builder.light(spot, Transform::look_at({0, 1.9f, 0}, {0, 0, 0}, {1, 0, 0}));
    add_camera(builder, {0, 0.3f, 0.2f}, {0, 2, 0});
    expect_true_energy(builder.finish(), 1, 1, 48);
}

// A metal floor bounces no diffuse light; a half metallic one half of it.
TEST(TrueLight, OfMetalsIsThatOfTheReference)
{
    SceneBuilder builder;
    const MeshId square = add_square(builder);
    Material half = matte({0.8f, 0.8f, 0.8f});
    half.metallic = 0.5f;
    builder.instance(square, builder.material(half), Transform::scaling(3, 1, 3));
    builder.instance(square, builder.material(matte({0.8f, 0.8f, 0.8f})),
                     Transform::translation(0, 2, 0) * Transform::scaling(3, 1, 3));
    add_point_light(builder, {0, 1.9f, 0}, 3);
    add_camera(builder, {0, 0.6f, 0.2f}, {0, 2, 0});
    expect_true_energy(builder.finish(), 1, 1, 48, 0.05);
}

// A floor under an open sky.
TEST(TrueLight, OfAnOpenSkyIsThatOfTheReference)
{
    SceneBuilder builder;
    const MeshId square = add_square(builder);
    builder.instance(square, builder.material(matte({0.5f, 0.5f, 0.5f})), Transform::scaling(4, 1, 4));
    add_camera(builder, {0, 2, 0.2f}, {0, 0, 0});
    scene::Scene scene = *api::scene_of(builder.finish());
    scene.background.kind = scene::Background::Kind::sky;
    scene.finish();
    const Scene under = api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
    expect_true_energy(under, 1, 1, 48);
}

// In a closed room, all light of a point light meets a wall: 4 pi times its intensity, of which the walls reflect a
// part.
TEST(TrueLight, OfALightMapIsAllThatItsLightSends)
{
    constexpr float k_albedo = 0.6f, k_intensity = 2;
    SceneBuilder builder;
    const MeshId square = add_square(builder);
    const MaterialId grey = builder.material(matte({k_albedo, k_albedo, k_albedo}));
    for (const Transform& turn : {Transform(), Transform::rotation({1, 0, 0}, k_pi),
                                  Transform::rotation({1, 0, 0}, k_pi / 2), Transform::rotation({1, 0, 0}, -k_pi / 2),
                                  Transform::rotation({0, 0, 1}, k_pi / 2), Transform::rotation({0, 0, 1}, -k_pi / 2)})
        builder.instance(square, grey, turn * Transform::translation(0, -1, 0) * Transform::scaling(2, 1, 2));
    add_point_light(builder, {0.2f, -0.3f, 0.1f}, k_intensity);
    add_camera(builder, {0, 0, 0.2f}, {0, 0, -1});
    const auto scene = api::scene_of(builder.finish());
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    Tasks tasks(2);
    const light_quadtree::LightMap map(state, rays, {}, tasks);
    light_quadtree::Clusters texels;
    light_quadtree::all_texels(map, texels);
    double radiance = 0;   // times area: flux over pi
    for (const float r : texels.r) radiance += static_cast<double>(r);
    const double truth = 4 * k_pi * static_cast<double>(k_intensity * k_albedo);
    EXPECT_NEAR(radiance * k_pi / truth, 1, 0.01);
    const irradiance_cache::LightTree tree(state, rays, {}, tasks);
    double flux = 0;
    for (const irradiance_cache::NodeId root : tree.roots())
        for (irradiance_cache::NodeId k = 0; k < 4; ++k)
            if (4 * root + k < tree.first_patch()) flux += static_cast<double>(tree.flux().at(4 * root + k).x);
    EXPECT_NEAR(flux / truth, 1, 0.01);
}

// The scene of a builder under a sun at 45 degrees, seen from above.
std::shared_ptr<const scene::Scene> under_a_sun(SceneBuilder& builder)
{
    Light sun{.color = {2, 2, 2}};
    sun.type = LightType::directional;
    builder.light(sun, Transform::look_at({0, 0, 0}, {1, -1, 0}));
    add_camera(builder, {0, 2, 0.2f}, {0, 0, 0});
    return api::scene_of(builder.finish());
}

// The near field of a point that hovers over a lit plane: the mean over a cosine distribution of what is not far.
TEST(NearLight, OfALitPlaneIsItsIntegral)
{
    constexpr float k_albedo = 0.6f, k_radius = 2;
    SceneBuilder builder;
    builder.instance(add_square(builder), builder.material(matte({k_albedo, k_albedo, k_albedo})),
                     Transform::scaling(40, 1, 40));
    const auto scene = under_a_sun(builder);
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    irradiance_cache::NearOptions options;
    options.radius = k_radius, options.rays = 1024;
    Tasks tasks(2);
    const irradiance_cache::LightTree tree(state, rays, {}, tasks);
    irradiance_cache::NearOptions by_leaves = options;
    by_leaves.radius = 10 * k_radius, by_leaves.tree = &tree;
    by_leaves.widths = k_radius / tree.leaf_width(0, {0, 0, 0}, std::sqrt(0.5f));
    irradiance_cache::NearLight::Scratch scratch;
    for (const bool radius_by_leaves : {false, true})
        for (const float height : {0.3f, 0.8f, 1.5f}) {
            const irradiance_cache::NearLight near(radius_by_leaves ? by_leaves : options);
            const glm::vec3 down(0, -1, 0);
            const irradiance_cache::NearReceiver receiver{{0, height, 0}, down, down};
            irradiance_cache::NearAnswer answer;
            near.gather(state, rays, &receiver, 1, ray::Against::static_only, scratch, &answer);
            double share = 0;
            constexpr int k_steps = 10000;
            for (int i = 0; i < k_steps; ++i) {
                const double cosine = std::sqrt(1 - (i + 0.5) / k_steps);
                share += (1 - static_cast<double>(irradiance_cache::far_fraction(
                                  static_cast<float>(static_cast<double>(height) / cosine), k_radius))) /
                         k_steps;
            }
            const double truth = share * static_cast<double>(k_albedo) * 2 * std::sqrt(0.5);
            EXPECT_NEAR(static_cast<double>(glm::dot(answer.light[0], down)) / truth, 1, 0.01) << height;
            EXPECT_NEAR(answer.nearest, height, 0.05f * height);
        }
}

// A plate that may move comes between points, a floor near them and the sun. What it changes is the difference of two
// near fields: with it and without it.
TEST(NearLight, ChangesByWhatADynamicObjectOccludes)
{
    SceneBuilder builder;
    const MaterialId white = builder.material(matte({0.7f, 0.7f, 0.7f}));
    const MeshId square = add_square(builder);
    builder.instance(square, white, Transform::scaling(4, 1, 4));
    builder.instance(square, white, Transform::translation(0.35f, 0.4f, 0) * Transform::scaling(0.3f, 1, 0.3f),
                     {.mobility = Mobility::may_move});
    const auto scene = under_a_sun(builder);
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    irradiance_cache::NearOptions options;
    options.radius = 2;
    const irradiance_cache::NearLight near(options);
    irradiance_cache::NearLight::Scratch scratch;
    irradiance_cache::MovingSpheres around, elsewhere;
    around.add({{{0.35f, 0.4f, 0}, 0.25f}});
    elsewhere.add({{{0, 40, 40}, 0.25f}});
    const glm::vec3 down(0, -1, 0);
    // The first point sees the plate's shadow, the second the plate before a lit floor.
    for (const glm::vec3 at : {glm::vec3(0.75f, 0.2f, 0), glm::vec3(0.35f, 0.6f, 0)}) {
        const irradiance_cache::NearReceiver receiver{at, down, down};
        irradiance_cache::NearAnswer without, with, change, none;
        near.gather(state, rays, &receiver, 1, ray::Against::static_only, scratch, &without);
        near.gather(state, rays, &receiver, 1, ray::Against::everything, scratch, &with);
        near.find_change(state, rays, around, &receiver, 1, scratch, &change);
        near.find_change(state, rays, elsewhere, &receiver, 1, scratch, &none);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(change.light[0][axis], with.light[0][axis] - without.light[0][axis], 1e-5f) << at.x;
        EXPECT_LT(glm::dot(change.light[0], down), -0.1f * glm::dot(without.light[0], down)) << at.x;
        EXPECT_EQ(none.light[0], glm::vec3(0));
    }
}

// What a light lights is near from as far as its leaf there is wide. For the near field that is found from the place,
// for the tree from the leaf: all light is counted once only if both are the same.
TEST(NearLight, KnowsHowWideALeafIsWhereItLies)
{
    SceneBuilder builder;
    const MaterialId grey = builder.material(matte({0.5f, 0.5f, 0.5f}));
    builder.instance(add_square(builder), grey, Transform::scaling(40, 1, 40));
    builder.instance(
        add_square(builder), grey,
        Transform::translation(-3, 0, 0) * Transform::rotation({0, 0, 1}, -1) * Transform::scaling(9, 1, 9));
    add_point_light(builder, {0.2f, 3, 0.1f}, 2);
    Light spot{.color = {2, 2, 2}};
    spot.type = LightType::spot;
    spot.outer_angle = 0.6f;
    builder.light(spot, Transform::look_at({2, 4, 0}, {-1, 0, 1}));
    Light sun{.color = {2, 2, 2}};
    sun.type = LightType::directional;
    builder.light(sun, Transform::look_at({0, 0, 0}, {1, -1, 0.2f}));
    add_camera(builder, {0, 2, 0.2f}, {0, 0, 0});
    const auto scene = api::scene_of(builder.finish());
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    Tasks tasks(2);
    const irradiance_cache::LightTree tree(state, rays, {}, tasks);
    // Each leaf is as wide as one of the three lights has it there.
    int leaves[3] = {}, strange = 0;
    for (irradiance_cache::NodeId id = 0; id < tree.first_patch(); ++id) {
        const irradiance_cache::VirtualLightQuad& quad = tree.quad(id / 4);
        const auto k = id % 4;
        if (tree.children(id) != scene::none || !(quad.flux[k] > 0)) continue;
        const glm::vec3 at(quad.x[k], quad.y[k], quad.z[k]), normal(quad.nx[k], quad.ny[k], quad.nz[k]);
        bool found = false;
        for (scene::LightId l = 0; l < 3; ++l) {
            const float cosine = glm::dot(normal, scene::illuminate(scene->lights[l], state.light(l), at).to_light);
            const float width = tree.leaf_width(l, at, cosine);
            if (std::abs(width - tree.leaf_width(id)) > 1e-3f * width) continue;
            ++leaves[l], found = true;
        }
        strange += !found;
    }
    EXPECT_EQ(strange, 0);
    for (const int count : leaves) EXPECT_GT(count, 1000);
}

// Light of small leaves before a wall, lit by a lantern that is close to them, in a sunlit land whose leaves of the
// light tree are wide. The near field of the land reaches farther than rays find the leaves: if all light within its
// radius were near, the wall would be grained.
TEST(NearLight, OfSmallLeavesHasNoGrain)
{
    SceneBuilder builder;
    const MeshId square = add_square(builder);
    const MaterialId grey = builder.material(matte({0.5f, 0.5f, 0.5f}));
    builder.instance(square, grey, Transform::translation(0, -1, 0) * Transform::scaling(300, 1, 300));
    builder.instance(square, grey, Transform::rotation({1, 0, 0}, k_pi / 2) * Transform::scaling(8, 1, 8));
    for (int i = 0; i < 60; ++i) {
        const auto turn = [i](double by) { return i * by - std::floor(i * by); };
        builder.instance(square, grey,
                         Transform::translation(4 * turn(0.618034) - 2, 1.6 + turn(0.7548777), 0.3 + turn(0.5698403)) *
                             Transform::rotation({1, 0, 0}, 1.2) * Transform::scaling(0.1, 1, 0.1));
    }
    add_point_light(builder, {0, 2, 0.2f}, 20);
    Light sun{.color = {0.1f, 0.1f, 0.1f}};
    sun.type = LightType::directional;
    builder.light(sun, Transform::look_at({0, 0, 0}, {0, -1, 0.5f}));
    add_camera(builder, {0, 0.7f, 2}, {0, 0.7f, 0});
    RenderOptions options;
    options.size = {64, 64}, options.layers = true, options.samples = 1;
    const Frame frame = Renderer(options).render(builder.finish(), 1);
    const auto layer = std::ranges::find(frame.layers, "indirect", &Layer::name);
    const std::vector<float> values = layer->copy();
    double grain = 0, all = 0;
    for (int y = 8; y < 56; ++y)
        for (int x = 8; x < 56; ++x) {
            const auto at = [&](int i, int j) {
                return static_cast<double>(values[static_cast<std::size_t>(3 * (64 * (y + j) + x + i))]);
            };
            grain += std::abs(at(0, 0) - (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1)) / 4);
            all += at(0, 0);
        }
    std::printf("grain %.5f of %.4f\n", grain / all, all / (48 * 48));
    EXPECT_LT(grain, 0.004 * all);
}

}   // namespace
}   // namespace gnomon
