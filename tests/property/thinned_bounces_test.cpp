// SPDX-License-Identifier: Apache-2.0
// Light of the sky and light that bounces passes surfaces that are partly transparent as far as their alpha or their
// colour leaves it, on its way to a surface that reflects it and on its way from there.
#include <gtest/gtest.h>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "scene_helpers.h"

namespace gnomon {
namespace {

using test::plain;

enum class Lit { spot, surface, image };
enum class Place { nowhere, before_the_wall, before_the_floor };

struct Setting {
    Lit lit = Lit::spot;
    Place place = Place::nowhere;   // of the sheet
    Material sheet{};
    Material wall{.base_color = {.8f, .8f, .8f}, .roughness = 1};
};

Material black(float alpha)
{
    return {.base_color = {0, 0, 0}, .alpha = alpha, .alpha_mode = AlphaMode::blend, .roughness = 1};
}

// A rectangle across z, that faces +Z.
test::Shape upright(float z, float half)
{
    test::Shape shape = test::square(half);
    for (Vec3& p : shape.positions) p.z = z;
    return shape;
}

// A wall at z = -6, lit from z = -3, and a floor below the camera that faces neither the light nor the lit side of a
// screen behind the light: only light that the wall reflects reaches it. The sheet stands between the light and the
// wall, or between the light and the floor.
Scene wall_and_floor(const Setting& setting, InstanceId* sheet = nullptr, InstanceId* wall = nullptr)
{
    SceneBuilder b;
    const MaterialId white = b.material({.base_color = {.8f, .8f, .8f}, .roughness = 1});
    const MaterialId dark = b.material({.base_color = {0, 0, 0}, .roughness = 1});
    const InstanceId made_wall = b.instance(b.mesh(upright(-6, 2).mesh()), b.material(setting.wall));
    if (wall) *wall = made_wall;
    const test::Shape floor{{{-1, -3, 1}, {1, -3, 1}, {1, -3, -1}, {-1, -3, -1}}, {0, 1, 2, 0, 2, 3}};
    b.instance(b.mesh(floor.mesh()), white);
    switch (setting.lit) {
        case Lit::spot:
            b.light({.type = LightType::spot, .color = {90, 90, 90}, .outer_angle = .55f},
                    Transform::translation(0, 0, -3));
            break;
        case Lit::surface:
            b.area_light({.width = .4f, .height = .4f, .radiance = {90, 90, 90}}, Transform::translation(0, 0, -3));
            break;
        case Lit::image: {
            // Light from behind the wall's front alone: the screen keeps it off the floor.
            const std::vector<float> even(64 * 32 * 3, 1.0f);
            b.environment({.width = 64, .height = 32, .pixels = even});
            break;
        }
    }
    if (setting.lit == Lit::image) {
        // A dark room without a ceiling over the wall's part of it, and with one over the floor's.
        const test::Shape roof{{{-9, 3, 9}, {9, 3, 9}, {9, 3, -3}, {-9, 3, -3}}, {0, 2, 1, 0, 3, 2}};
        b.instance(b.mesh(roof.mesh()), dark);
        const test::Shape ground{{{-9, -3.1f, 9}, {9, -3.1f, 9}, {9, -3.1f, -9}, {-9, -3.1f, -9}}, {0, 1, 2, 0, 2, 3}};
        b.instance(b.mesh(ground.mesh()), dark);
        b.instance(b.mesh(upright(9, 20).mesh()), dark);
        for (const float x : {-9.0f, 9.0f}) {
            const test::Shape side{{{x, -4, 9}, {x, -4, -9}, {x, 40, -9}, {x, 40, 9}}, {0, 1, 2, 0, 2, 3}};
            b.instance(b.mesh(side.mesh()), dark);
        }
    }
    if (setting.place != Place::nowhere) {
        const bool before_wall = setting.place == Place::before_the_wall;
        const test::Shape shape = upright(before_wall ? -4.5f : -2.0f, 30);
        const InstanceId made = b.instance(b.mesh(shape.mesh()), b.material(setting.sheet));
        if (sheet) *sheet = made;
    }
    Camera camera = test::camera_along_z();
    camera.transform = Transform{.m = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}};   // looks down
    b.camera(camera);
    return b.finish();
}

Vec3 colour(const Scene& scene, const RenderOptions& options)
{
    Renderer renderer(options);
    const Frame frame = renderer.render(scene, 1);
    const Layer& image = frame.layers.front();
    return {image.value(24, 25, 0), image.value(24, 25, 1), image.value(24, 25, 2)};
}

// Of the floor, in the image's middle.
double brightness(const Scene& scene, const RenderOptions& options)
{
    Renderer renderer(options);
    const Frame frame = renderer.render(scene, 1);
    const Layer& image = frame.layers.front();
    const int from = image.size.width * 3 / 8, to = image.size.width * 5 / 8;
    double sum = 0;
    for (int y = from; y < to; ++y)
        for (int x = from; x < to; ++x) sum += static_cast<double>(image.value(x, y, 1));
    return sum / ((to - from) * (to - from));
}

RenderOptions bounced(int bounces)
{
    RenderOptions options = plain({48, 48});
    options.indirect = Indirect::visible;
    options.indirect_on = IndirectOn::cpu;
    options.bounces = bounces;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

TEST(ThinnedBounces, ABounceLosesWhatTheSheetBeforeTheFloorTakes)
{
    for (const Lit lit : {Lit::spot, Lit::surface}) {
        const float whole = colour(wall_and_floor({lit}), bounced(1)).y;
        ASSERT_GT(whole, .005f) << static_cast<int>(lit);
        for (const float alpha : {.25f, .5f, 1.0f})
            EXPECT_NEAR(colour(wall_and_floor({lit, Place::before_the_floor, black(alpha)}), bounced(1)).y / whole,
                        1 - alpha, .02f)
                << static_cast<int>(lit) << ' ' << alpha;
    }
}

TEST(ThinnedBounces, ABounceLosesWhatTheSheetBeforeTheWallTakes)
{
    // The wall's light passes the sheet twice: to the wall, and from there to the floor.
    for (const Lit lit : {Lit::spot, Lit::surface}) {
        const float whole = colour(wall_and_floor({lit}), bounced(1)).y;
        for (const float alpha : {.25f, .5f})
            EXPECT_NEAR(colour(wall_and_floor({lit, Place::before_the_wall, black(alpha)}), bounced(1)).y / whole,
                        (1 - alpha) * (1 - alpha), .02f)
                << static_cast<int>(lit) << ' ' << alpha;
    }
}

TEST(ThinnedBounces, ThinGlassTintsThem)
{
    Material glass{.base_color = {1, .5f, .25f}, .roughness = 0, .transmission = 1};
    glass.layers.emplace().thin_walled = true;
    const Vec3 whole = colour(wall_and_floor({Lit::spot}), bounced(1));
    const Vec3 tinted = colour(wall_and_floor({Lit::spot, Place::before_the_floor, glass}), bounced(1));
    EXPECT_NEAR(tinted.x / whole.x, 1, .03f);
    EXPECT_NEAR(tinted.y / whole.y, .5f, .02f);
    EXPECT_NEAR(tinted.z / whole.z, .25f, .02f);
}

TEST(ThinnedBounces, AgreeWithTheReference)
{
    // A sheet that reflects as well, so that the light behind it is its own and the wall's.
    Material sheet = black(.5f);
    sheet.base_color = {.6f, .6f, .6f};
    for (const Lit lit : {Lit::spot, Lit::surface, Lit::image})
        for (const Place place : {Place::before_the_floor, Place::before_the_wall}) {
            if (lit == Lit::image && place == Place::before_the_wall) continue;
            const bool reflects = lit == Lit::spot && place == Place::before_the_wall;
            const Scene scene = wall_and_floor({lit, place, reflects ? sheet : black(.5f)});
            RenderOptions reference = bounced(1);
            // Large enough for cache points to follow the gradient over the floor within 8 %.
            reference.size = {160, 160};
            reference.reference = ReferenceLightOptions{.spp = 128, .bounces = 1};
            RenderOptions options = bounced(1);
            options.size = reference.size;
            const double expected = brightness(scene, reference), found = brightness(scene, options);
            ASSERT_GT(expected, 1e-3f);
            EXPECT_NEAR(found / expected, 1, .1) << static_cast<int>(lit) << ' ' << static_cast<int>(place);
        }
}

// A floor under an even sky, and a box of `alpha` around it and the camera.
Scene under_the_sky(float alpha)
{
    scene::Scene scene;
    scene.materials.resize(2);
    scene.materials[0].base_color = glm::vec3(.8f);
    scene.materials[0].ior = 1;   // mirrors nothing
    scene.materials[1].base_color = glm::vec3(0);
    scene.materials[1].alpha = alpha;
    scene.materials[1].alpha_mode = scene::AlphaMode::blend;
    const auto add = [&](const test::Shape& shape, scene::MaterialId material) {
        scene::Mesh mesh;
        for (const Vec3& p : shape.positions) mesh.positions.push_back({p.x, p.y, p.z});
        for (std::size_t i = 0; i < shape.indices.size(); i += 3)
            mesh.triangles.push_back({shape.indices[i], shape.indices[i + 1], shape.indices[i + 2]});
        mesh.parts = {{material, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
        scene.meshes.push_back(mesh);
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1));
    };
    add(upright(-4, 2), 0);
    if (alpha > 0) add(test::cube(6), 1);
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(.5f, 1, .25f);
    scene::Camera camera;
    camera.node = scene.add_node("camera", scene::none, glm::dmat4(1));
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

TEST(ThinnedBounces, AnEvenSkyIsThinnedByAlpha)
{
    for (const int bounces : {1, k_all_bounces}) {
        const Vec3 whole = colour(under_the_sky(0), bounced(bounces));
        EXPECT_NEAR(whole.y, .8f, .01f);   // albedo times radiance
        for (const float alpha : {.25f, .5f, .75f}) {
            const Vec3 thinned = colour(under_the_sky(alpha), bounced(bounces));
            EXPECT_NEAR(thinned.x / whole.x, 1 - alpha, .01f);
            EXPECT_NEAR(thinned.y / whole.y, 1 - alpha, .01f);
            EXPECT_NEAR(thinned.z / whole.z, 1 - alpha, .01f);
        }
    }
}

// A sheet that a host moves: the light follows, as if the renderer were new.
TEST(ThinnedBounces, AMovingSheetIsFollowedAsIfNew)
{
    InstanceId sheet;
    const Scene scene = wall_and_floor({Lit::spot, Place::before_the_floor, black(.5f)}, &sheet);
    const RenderOptions options = bounced(k_all_bounces);
    Renderer kept(options);
    const auto at = [&](double z) {
        FrameInput input;
        input.transforms.push_back({sheet, Transform::translation(0, 0, z)});
        return input;
    };
    kept.render(scene, at(0));
    float value[2];
    int i = 0;
    for (const double z : {.5, 40.0}) {   // before the floor, and away
        const Frame frame = kept.render(scene, at(z));
        value[i++] = frame.layers.front().value(24, 25, 1);
        Renderer fresh(options);
        fresh.render(scene, at(0));
        EXPECT_EQ(fresh.render(scene, at(z)).layers.front().value(24, 25, 1), value[i - 1]) << z;
    }
    EXPECT_NEAR(value[0] / value[1], .5f, .05f);
}

// A sheet that a host moves between a light and the wall that reflects it: as one that stands there, and as if new.
TEST(ThinnedBounces, AMovingSheetThinsWhatReachesTheWall)
{
    for (const Lit lit : {Lit::spot, Lit::surface})
        for (const int bounces : {1, k_all_bounces}) {
            InstanceId sheet;
            const Scene scene = wall_and_floor({lit, Place::before_the_wall, black(.5f)}, &sheet);
            const RenderOptions options = bounced(bounces);
            const auto at = [&](double z) {
                FrameInput input;
                input.transforms.push_back({sheet, Transform::translation(0, 0, z)});
                return input;
            };
            const auto green = [](const Frame& frame) { return frame.layers.front().value(24, 25, 1); };
            const float still = green(Renderer(options).render(scene, 1));
            Renderer kept(options);
            const float away = green(kept.render(scene, at(60)));
            const float before_wall = green(kept.render(scene, at(.25)));
            const float again = green(kept.render(scene, at(61)));
            Renderer fresh(options);
            EXPECT_EQ(green(fresh.render(scene, at(.25))), before_wall);
            EXPECT_NEAR(before_wall / away, .25f, .03f) << static_cast<int>(lit) << ' ' << bounces;
            EXPECT_NEAR(before_wall / still, 1, .06f) << static_cast<int>(lit) << ' ' << bounces;
            EXPECT_EQ(again, away);
        }
}

// The wall is a sheet that moves: it reflects the light of a surface by its alpha.
TEST(ThinnedBounces, AMovingSheetReflectsByItsAlpha)
{
    for (const int bounces : {1, k_all_bounces}) {
        const auto reflects = [&](float alpha) {
            Setting setting{Lit::surface};
            setting.wall.double_sided = true;
            if (alpha < 1) setting.wall.alpha = alpha, setting.wall.alpha_mode = AlphaMode::blend;
            InstanceId wall;
            const Scene scene = wall_and_floor(setting, nullptr, &wall);
            Renderer renderer(bounced(bounces));
            renderer.render(scene, 1);
            FrameInput input;
            input.transforms.push_back({wall, Transform::translation(0, 0, 1e-3)});
            return renderer.render(scene, input).layers.front().value(24, 25, 1);
        };
        const float whole = reflects(1);
        ASSERT_GT(whole, .005f);
        for (const float alpha : {.25f, .5f}) EXPECT_NEAR(reflects(alpha) / whole, alpha, .03f) << bounces;
    }
}

TEST(ThinnedBounces, AnotherAlphaFromAHostShowsInTheNextFrame)
{
    SceneBuilder b(wall_and_floor({Lit::surface}));
    const MaterialId material = b.material(black(.25f));
    const test::Shape shape = upright(-2, 30);
    b.instance(b.mesh(shape.mesh()), material);
    const Scene scene = b.finish();
    Renderer renderer(bounced(k_all_bounces));
    const float before = renderer.render(scene, 1).layers.front().value(24, 25, 1);
    FrameInput input;
    input.materials.push_back({material, black(.625f)});
    const float after = renderer.render(scene, input).layers.front().value(24, 25, 1);
    EXPECT_NEAR(after / before, .5f, .03f);
}

}   // namespace
}   // namespace gnomon
