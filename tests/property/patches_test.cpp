// SPDX-License-Identifier: Apache-2.0
// Patches of the static scene: what they cover, what separates them, their links, and light that bounces between them.
#include <gtest/gtest.h>

#include <cmath>

#include "base/bits.h"
#include "irradiance_cache/near_field/near_light.h"
#include "patches/patch_bounces.h"
#include "patches/patch_emission.h"
#include "patches/patch_rays.h"
#include "scene/environment.h"
#include "scene_helpers.h"
#include "world.h"

namespace gnomon {
namespace {

using patches::k_no_patch;
using patches::Patch;
using patches::PatchId;
using patches::PatchLinks;
using patches::PatchPlace;
using patches::SurfacePatches;
using test::World;

// A rectangle in y = 0 around the origin, facing up.
scene::Mesh rectangle(const glm::vec2& half)
{
    scene::Mesh mesh;
    mesh.positions = {{-half.x, 0, -half.y}, {-half.x, 0, half.y}, {half.x, 0, half.y}, {half.x, 0, -half.y}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    return mesh;
}

// The inside of a box around the origin, with these half sides; every wall has material 0.
scene::Scene room(const glm::dvec3& half)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].base_color = glm::vec3(0.5f);
    scene.materials[0].double_sided = true;
    const auto wall = [&](double angle, const glm::dvec3& axis, double away, const glm::dvec2& size) {
        scene.meshes.push_back(rectangle(glm::vec2(size)));
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                         glm::translate(glm::rotate(glm::dmat4(1), angle, axis), glm::dvec3(0, -away, 0)));
    };
    wall(0, {1, 0, 0}, half.y, {half.x, half.z}), wall(k_pi, {1, 0, 0}, half.y, {half.x, half.z});
    wall(k_pi / 2, {1, 0, 0}, half.z, {half.x, half.y}), wall(-k_pi / 2, {1, 0, 0}, half.z, {half.x, half.y});
    wall(k_pi / 2, {0, 0, 1}, half.x, {half.y, half.z}), wall(-k_pi / 2, {0, 0, 1}, half.x, {half.y, half.z});
    return scene;
}

// The same with a sheet across, at x = 0.017.
scene::Scene two_rooms()
{
    scene::Scene scene = room({2, 1, 1});
    scene.meshes.push_back(rectangle({1, 1}));
    test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                     glm::translate(glm::dmat4(1), glm::dvec3(0.017, 0, 0)) *
                         glm::rotate(glm::dmat4(1), k_pi / 2, glm::dvec3(0, 0, 1)));
    return scene;
}

scene::Scene done(scene::Scene scene)
{
    scene.finish();
    return scene;
}

std::vector<float> areas_of(const SurfacePatches& patches)
{
    std::vector<float> areas;
    for (const Patch& patch : patches.patches()) areas.push_back(patch.area);
    return areas;
}

TEST(Patches, CoverBothSidesOfAllStaticSurfacesOnce)
{
    World world("cornell");
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    double surface = 0;
    for (scene::ObjectId o = 0; o < world.scene->objects.size(); ++o) {
        if (world.state.is_dynamic(o)) continue;
        const ray::ObjectGeometry& geometry = world.rays.geometry(o);
        for (std::uint32_t t = 0; t < geometry.mesh->triangles.size(); ++t) {
            glm::vec3 p[3];
            geometry.corners(t, p);
            surface += static_cast<double>(glm::length(glm::cross(p[1] - p[0], p[2] - p[0])));   // both sides
        }
    }
    double area = 0;
    for (const Patch& patch : patches.patches()) {
        area += static_cast<double>(patch.area);
        double places = 0;
        for (const PatchPlace& place : patches.places(patch)) {
            places += static_cast<double>(place.area);
            EXPECT_LE(glm::length(place.position - patch.position), patch.radius * 1.01f);
        }
        EXPECT_NEAR(places, static_cast<double>(patch.area), 1e-4 * places);
        EXPECT_LE(glm::length(patch.normal), 1.001f);
        EXPECT_LT(patch.radius, 1);
    }
    EXPECT_NEAR(area, surface, 1e-3 * surface);
    EXPECT_GT(patches.patches().size(), 4096u);
    EXPECT_LE(patches.patches().size(), 16384u);
}

TEST(Patches, AreTheSameForAnyThreadCount)
{
    World one("kinetic", 1, 1), three("kinetic", 40, 3);
    const SurfacePatches a(one.state, one.rays, {}, one.tasks), b(three.state, three.rays, {}, three.tasks);
    ASSERT_EQ(a.patches().size(), b.patches().size());
    for (std::size_t p = 0; p < a.patches().size(); ++p) {
        EXPECT_EQ(a.patches()[p].position, b.patches()[p].position);
        EXPECT_EQ(a.patches()[p].sample, b.patches()[p].sample);
        EXPECT_EQ(a.patches()[p].area, b.patches()[p].area);
    }
    const patches::Surroundings sky(one.scene->background);
    const PatchLinks x = patches::link_patches(a, one.state, one.rays, sky, one.tasks),
                     y = patches::link_patches(b, three.state, three.rays, sky, three.tasks);
    EXPECT_EQ(x.target, y.target);
    EXPECT_EQ(x.surroundings, y.surroundings);
}

// A wall that crosses a floor separates the floor's patches.
TEST(Patches, LieOnOneSideOfASheet)
{
    World world(done(two_rooms()));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    std::size_t beside = 0;
    for (const Patch& patch : patches.patches()) {
        if (std::abs(patch.position.x) > 1.9f || glm::length(patch.normal) < 0.5f) continue;
        if (std::abs(patch.normal.x) > 0.5f) continue;
        // The inner sides of floor, ceiling and walls.
        if (glm::dot(patch.normal, patch.position) > 0) continue;
        bool left = false, right = false;
        for (const PatchPlace& place : patches.places(patch)) (place.position.x < 0.017f ? left : right) = true;
        EXPECT_FALSE(left && right) << patch.position.x << ' ' << patch.position.y << ' ' << patch.position.z;
        beside += std::abs(patch.position.x - 0.017f) < 0.15f;
    }
    EXPECT_GT(beside, 20u);

    // A point of a part that the sheet crosses belongs to a patch of its own side; but for a few at the tips of parts
    // that end just behind the sheet.
    int wrong = 0, known = 0;
    for (int i = 0; i < 400; ++i) {
        const float z = -0.99f + 1.98f * (static_cast<float>(i) + 0.5f) / 400;
        for (const float x : {0.012f, 0.022f}) {
            const ray::Hit hit = world.rays.closest_single({x, 0, z}, 0, {0, -1, 0}, 10, ray::Sides::both);
            ASSERT_NE(hit.object, scene::none);
            const PatchId patch =
                patches.patch_at(world.rays, hit.object, hit.triangle, hit.u, hit.v, true, {x, -1 + 1e-5f, z});
            if (patch == k_no_patch) continue;
            ++known;
            wrong += (patches.patches()[patch].sample.x < 0.017f) != (x < 0.017f);
        }
    }
    EXPECT_GT(known, 400);
    EXPECT_LE(wrong, known / 25);
}

// A plate just above a floor: what it keeps in the dark is no part of the floor around it, although both see each other
// along the floor.
TEST(Patches, SeparateWhatIsCoveredFromWhatIsOpen)
{
    constexpr float k_half = 0.61f, k_height = 0.02f;
    scene::Scene scene = room({1, 1, 1});
    scene.meshes.push_back(rectangle({k_half, k_half}));
    test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                     glm::translate(glm::dmat4(1), glm::dvec3(0, static_cast<double>(k_height) - 1, 0)));
    World world(done(std::move(scene)));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    std::size_t open = 0, covered = 0, mixed = 0;
    for (const Patch& patch : patches.patches()) {
        if (!(patch.normal.y > 0.9f) || patch.position.y > -0.999f) continue;
        bool out = false, in = false;
        for (const PatchPlace& place : patches.places(patch)) {
            const float beyond = std::max(std::abs(place.position.x), std::abs(place.position.z)) - k_half;
            out = out || beyond > 0, in = in || beyond < -k_height;
        }
        open += out && !in, covered += in && !out, mixed += in && out;
    }
    EXPECT_GT(open, 100u);
    EXPECT_GT(covered, 50u);
    EXPECT_LE(mixed, 4u) << open << ' ' << covered;
}

// A grid of low walls on a floor, narrower than the parts of the floor: most of its pockets hold no place of a patch. A
// ray that ends there counts as the others.
TEST(Patches, RaysToSurfacesWithoutAPatchCountAsTheOthers)
{
    constexpr int k_walls = 61;
    scene::Scene scene = room({1, 1, 1});
    scene.meshes.push_back(rectangle({0.03f, 1}));
    for (int i = 0; i < 2 * k_walls; ++i) {
        const double at = -0.997 + 2.0 * (i / 2) / k_walls;
        glm::dmat4 to = glm::translate(glm::dmat4(1), glm::dvec3(0, -0.97, 0));
        if (i % 2 == 1) to = glm::rotate(to, k_pi / 2, glm::dvec3(0, 1, 0));
        to = glm::translate(to, glm::dvec3(at, 0, 0));
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                         glm::rotate(to, k_pi / 2, glm::dvec3(0, 0, 1)));
    }
    World world(done(std::move(scene)));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    std::vector<glm::vec3> exitance(patches.patches().size(), glm::vec3(2)), irradiance(exitance.size());
    patches::gather_links(links, exitance, irradiance, world.tasks);
    std::size_t ceiling = 0, unknown = 0;
    for (std::size_t p = 0; p < exitance.size(); ++p) {
        const Patch& patch = patches.patches()[p];
        if (!(patch.normal.y < -0.9f) || patch.position.y < 0.9f) continue;
        ++ceiling;
        for (std::size_t k = 0; k < PatchLinks::k_rays; ++k)
            unknown += links.target[PatchLinks::k_rays * p + k] == PatchLinks::k_none;
        EXPECT_NEAR(irradiance[p].x, 2, 1e-4f);
    }
    EXPECT_GT(ceiling, 30u);
    EXPECT_GT(unknown, ceiling);
}

// In a closed room every ray meets a patch, and what all give is what each gets.
TEST(Patches, LinksOfAClosedRoomLoseNothing)
{
    World world(done(room({1, 1, 1})));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    const std::size_t count = patches.patches().size();
    std::vector<glm::vec3> exitance(count, glm::vec3(2)), irradiance(count);
    patches::gather_links(links, exitance, irradiance, world.tasks);
    std::size_t inside = 0, full = 0;
    for (std::size_t p = 0; p < count; ++p) {
        if (glm::dot(patches.patches()[p].normal, patches.patches()[p].position) > 0) continue;
        ++inside, full += irradiance[p] == glm::vec3(2);
    }
    EXPECT_GT(inside, 1000u);
    EXPECT_GE(static_cast<double>(full), 0.99 * static_cast<double>(inside));

    // Light e that all walls give off becomes e / (1 - albedo), and e (1 + albedo) after one sweep.
    const std::vector<glm::vec3> albedo(count, glm::vec3(0.8f));
    const std::vector<float> area = areas_of(patches);
    for (const bool endless : {true, false}) {
        const std::vector<glm::vec3> added = patches::bounce(
            links, {albedo, area}, exitance, 0, {.sweeps = endless ? 64 : 1, .endless = endless}, world.tasks);
        const double truth = endless ? 2 * 0.8 / (1 - 0.8) : 2 * 0.8;
        double sum = 0;
        for (std::size_t p = 0; p < count; ++p)
            if (glm::dot(patches.patches()[p].normal, patches.patches()[p].position) < 0)
                sum += static_cast<double>(added[p].x);
        EXPECT_NEAR(sum / static_cast<double>(inside), truth, 0.01 * truth) << endless;
    }
}

// What a ball keeps from patches is the same if all rays of all patches are looked at, not only those that may cross
// the ball's sphere as seen from the middle of a patch.
TEST(Patches, RaysAcrossASphereAreFoundFromThePatchsMiddle)
{
    World world("cornell");
    patches::PatchOptions wide;
    wide.patches = 500;
    const SurfacePatches patches(world.state, world.rays, wide, world.tasks);
    const patches::Surroundings surroundings(world.scene->background);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays, surroundings, world.tasks);
    PatchLinks slow = links;
    slow.reach.assign(links.reach.size(), k_infinity);
    EXPECT_GT(std::ranges::count_if(links.reach, [](float reach) { return std::isfinite(reach); }), 200);
    std::vector<glm::vec3> exitance(links.weight.size());
    for (std::size_t p = 0; p < exitance.size(); ++p) exitance[p] = glm::vec3(1 + static_cast<float>(p % 7));
    ASSERT_FALSE(world.state.dynamic_objects().empty());
    std::size_t blocked = 0;
    for (const int frame : {1, 8, 20, 30}) {
        world.go(frame);
        std::vector<patches::BoundingSphere> spheres;
        for (const scene::ObjectId o : world.state.dynamic_objects()) {
            const Box3 box = world.scene->meshes[world.scene->objects[o].mesh].bounds();
            const glm::mat4 matrix = world.state.object_matrix(o);
            const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(matrix))));
            spheres.push_back({transform_point(matrix, box.centre()), 0.5f * scale * box.size().x});
        }
        const auto found = [&](const PatchLinks& with) {
            return patches::blocked_links(patches, with, world.state, world.rays, surroundings, spheres, exitance,
                                          world.tasks)
                .irradiance;
        };
        const std::vector<glm::vec3> expected = found(slow);
        EXPECT_TRUE(same_bits(found(links), expected)) << frame;
        blocked +=
            static_cast<std::size_t>(std::ranges::count_if(expected, [](const glm::vec3& b) { return b.x > 0; }));
    }
    EXPECT_GT(blocked, 50u);
}

// Nothing of a lit room reaches the other side of a sheet.
TEST(Patches, NoLightBouncesThroughASheet)
{
    World world(done(two_rooms()));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    const std::size_t count = patches.patches().size();
    const std::vector<glm::vec3> albedo(count, glm::vec3(0.8f));
    const std::vector<float> area = areas_of(patches);
    std::vector<glm::vec3> direct(count, glm::vec3(0));
    const auto inside = [&](std::size_t p) {
        const Patch& patch = patches.patches()[p];
        const glm::vec3 middle(patch.sample.x < 0.017f ? -1 : 1, 0, 0);
        return glm::dot(patch.normal, patch.position - middle) < 0;
    };
    for (std::size_t p = 0; p < count; ++p)
        if (inside(p) && patches.patches()[p].sample.x < 0.017f) direct[p] = glm::vec3(1);
    const std::vector<glm::vec3> added = patches::bounce(links, {albedo, area}, direct, 0, {.sweeps = 64}, world.tasks);
    double lit = 0, dark = 0;
    for (std::size_t p = 0; p < count; ++p)
        if (inside(p))
            (patches.patches()[p].sample.x < 0.017f ? lit : dark) += static_cast<double>(area[p] * added[p].x);
    EXPECT_GT(lit, 10);
    EXPECT_LE(dark, 1e-3 * lit);
}

// Under an even sky an open floor gets pi times its radiance.
TEST(Patches, AnOpenFloorGetsAllOfTheSky)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.meshes.push_back(rectangle({1, 1}));
    test::add_object(scene, 0);
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(0.5f, 1, 2);
    World world(done(std::move(scene)));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    for (const glm::vec3& irradiance : links.surroundings)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(irradiance[c], static_cast<float>(k_pi) * world.scene->background.zenith[c], 1e-4f);
}

// Its rays meet a bright square too often, or too rarely; its light is known without them.
TEST(Patches, AnOpenFloorGetsAllOfAnImage)
{
    constexpr int k_width = 128, k_height = 64;
    ImageF image(k_width, k_height, 3);
    glm::dvec3 truth(0);
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) {
            const bool bright = y / 6 == 2 && x / 6 == 3;
            const glm::dvec3 d = scene::Environment::direction_at((x + 0.5) / k_width, (y + 0.5) / k_height);
            const double solid = 2 * k_pi * k_pi / (k_width * k_height) * std::sin(k_pi * (y + 0.5) / k_height);
            for (int c = 0; c < 3; ++c) {
                image.pixel(x, y)[c] = bright ? 10.0f : 0.1f;
                truth[c] += solid * std::max(d.y, 0.0) * static_cast<double>(image.pixel(x, y)[c]);
            }
        }
    scene::Scene scene;
    scene.materials.resize(1);
    scene.meshes.push_back(rectangle({1, 1}));
    test::add_object(scene, 0);
    scene.background.kind = scene::Background::Kind::image;
    scene.background.environment = std::make_shared<const scene::Environment>(image);
    World world(done(std::move(scene)));
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    int above = 0;
    for (std::size_t p = 0; p < links.surroundings.size(); ++p) {
        if (patches.patches()[p].normal.y < 0.5f) continue;
        ++above;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(links.surroundings[p][c] / truth[c], 1, 0.01);
    }
    EXPECT_GT(above, 100);
}

// A cube of leaves, two wide, under an even sky of radiance 1.
scene::Scene leaves()
{
    constexpr std::uint32_t k_leaves = 12000;
    constexpr float k_size = 0.12f;
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].double_sided = true;
    std::uint32_t state = 1;
    const auto number = [&] {   // -1 to 1
        state = state * 1664525u + 1013904223u;
        return static_cast<float>(state >> 8) * 0x1p-23f - 1;
    };
    scene::Mesh mesh;
    for (std::uint32_t i = 0; i < k_leaves; ++i) {
        const glm::vec3 at(number(), number(), number());
        for (int corner = 0; corner < 3; ++corner)
            mesh.positions.push_back(at + k_size * glm::vec3(number(), number(), number()));
        mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    mesh.parts = {{0, 0, k_leaves}};
    scene.meshes.push_back(std::move(mesh));
    test::add_object(scene, 0);
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(1);
    return scene;
}

// What patches of leaves get of the sky is what the leaves get that are seen from outside, by rays from there: dark
// ones between them do not dilute it.
TEST(Patches, HaveTheLightOfWhatIsSeenOfThem)
{
    constexpr int k_side = 24;
    constexpr std::size_t k_rays = 64;
    World world(done(leaves()));
    patches::PatchOptions options;
    options.patches = 64;
    const SurfacePatches patches(world.state, world.rays, options, world.tasks);
    const PatchLinks links = patches::link_patches(patches, world.state, world.rays,
                                                   patches::Surroundings(world.scene->background), world.tasks);
    // Look from all six sides.
    patches::PatchRays seen;
    for (int facing = 0; facing < 6; ++facing)
        for (int i = 0; i < k_side * k_side; ++i) {
            const float a = 1.8f * (static_cast<float>(i % k_side) + 0.5f) / k_side - 0.9f,
                        b = 1.8f * (static_cast<float>(i / k_side) + 0.5f) / k_side - 0.9f;
            const float sign = facing % 2 == 0 ? 1.0f : -1.0f;
            glm::vec3 from(0), to(0);
            from[facing / 2] = 3 * sign, from[(facing / 2 + 1) % 3] = a, from[(facing / 2 + 2) % 3] = b;
            to[facing / 2] = -sign;
            seen.push(from, to);
        }
    seen.trace(*world.scene, world.rays);
    // Hold what each ray meets against rays of its own to the sky.
    const std::vector<glm::vec3> directions = irradiance_cache::cosine_directions(k_rays);
    double got = 0, truth = 0;
    std::size_t met = 0;
    for (std::size_t r = 0; r < seen.size(); ++r) {
        if (seen.leaves(r)) continue;
        const PatchId patch = seen.patch(patches, world.rays, r);
        if (patch == k_no_patch) continue;
        const patches::PatchRays::End end = seen.end(world.rays, r);
        glm::vec3 t, b;
        make_basis(end.normal, t, b);
        patches::PatchRays own;
        for (const glm::vec3& d : directions)
            own.push(end.position + 1e-5f * end.normal, d.x * t + d.y * b + d.z * end.normal);
        own.trace(*world.scene, world.rays);
        for (std::size_t k = 0; k < k_rays; ++k) truth += own.leaves(k) ? k_pi / static_cast<double>(k_rays) : 0;
        got += static_cast<double>(links.surroundings[patch].x);
        ++met;
    }
    RecordProperty("ratio", std::to_string(got / truth));
    EXPECT_GT(met, 2000u);
    EXPECT_NEAR(got / truth, 1, 0.05);   // .88 if places count by their area alone
}

// A room whose ceiling emits, with a ball that sways below it.
scene::Scene lit_room()
{
    scene::Scene scene = room({1, 1, 1});
    scene.materials.resize(2);
    scene.materials[1].emissive = glm::vec3(3, 2, 1);
    scene.meshes.push_back(rectangle({0.3f, 0.3f}));
    const auto panel = static_cast<scene::MeshId>(scene.meshes.size() - 1);
    scene.meshes.edit(panel).parts[0].material = 1;
    test::add_object(
        scene, panel, scene::none,
        glm::translate(glm::dmat4(1), glm::dvec3(0, 0.95, 0)) * glm::rotate(glm::dmat4(1), k_pi, glm::dvec3(1, 0, 0)));
    scene.meshes.push_back(test::ball(0, 12, 18));
    const auto ball = static_cast<scene::MeshId>(scene.meshes.size() - 1);
    const scene::NodeId node = scene.add_node("ball", scene::none, glm::dmat4(1));
    scene.nodes[node].transform = std::make_shared<test::SwayTrack>(glm::dvec3(0), 3, 0.2);
    test::add_object(scene, ball, node, glm::scale(glm::dmat4(1), glm::dvec3(0.2)));
    scene.timeline.frames = 10, scene.timeline.fps = 2, scene.timeline.end = 4.5;
    return done(std::move(scene));
}

// What patches get of a light is what each of their points gets, and follows a ball that moves in between as if it had
// been found anew.
TEST(PatchEmission, FollowsDynamicObjectsAsIfNew)
{
    World world(lit_room(), 1, 2);
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    scene::SizedLights lights(patches::EmissionOptions().lights);
    lights.update(world.state);
    patches::PatchEmission kept(patches);
    EXPECT_TRUE(kept.update(world.state, world.rays, lights, world.tasks));
    std::size_t changed = 0, shadowed = 0;
    for (const int frame : {5, 9, 9, 2}) {
        const std::vector<glm::vec3> before(kept.irradiance().begin(), kept.irradiance().end());
        world.go(frame);
        lights.update(world.state);
        EXPECT_FALSE(kept.update(world.state, world.rays, lights, world.tasks));
        World other(lit_room(), frame);
        const SurfacePatches own(other.state, other.rays, {}, other.tasks);
        scene::SizedLights own_lights(patches::EmissionOptions().lights);
        own_lights.update(other.state);
        patches::PatchEmission fresh(own);
        fresh.update(other.state, other.rays, own_lights, other.tasks);
        EXPECT_TRUE(std::ranges::equal(kept.static_irradiance(), fresh.static_irradiance()));
        EXPECT_TRUE(std::ranges::equal(kept.irradiance(), fresh.irradiance()));
        for (std::size_t p = 0; p < before.size(); ++p) {
            changed += before[p] != kept.irradiance()[p];
            shadowed += kept.irradiance()[p] != kept.static_irradiance()[p];
        }
    }
    EXPECT_GT(changed, 10u);
    EXPECT_GT(shadowed, 10u);
}

// The floor below a light: all of its flux.
TEST(PatchEmission, EqualsTheClosedForm)
{
    World world(lit_room());
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    scene::SizedLights lights(patches::EmissionOptions().lights);
    lights.update(world.state);
    patches::PatchEmission emission(patches);
    emission.update(world.state, world.rays, lights, world.tasks);
    double flux = 0;
    for (std::size_t p = 0; p < patches.patches().size(); ++p) {
        const Patch& patch = patches.patches()[p];
        if (glm::dot(patch.normal, patch.position) < 0)
            flux += static_cast<double>(patch.area * emission.static_irradiance()[p].x);
    }
    // All that the light gives off arrives somewhere; its own back and the ceiling get none.
    EXPECT_NEAR(flux, k_pi * 3 * 0.36, 0.01 * k_pi * 3 * 0.36);
}

}   // namespace
}   // namespace gnomon
