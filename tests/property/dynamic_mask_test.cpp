// SPDX-License-Identifier: Apache-2.0
// The dynamic mask's results for dynamic objects, and for static objects in front of them, against rays.
#include <gtest/gtest.h>

#include "scene/builtin/builtin.h"
#include "shadow_culling/dynamic_mask/dynamic_mask.h"
#include "soup.h"

namespace gnomon::shadow_culling {
namespace {

struct Tally {
    std::uint64_t free = 0, occluded = 0, unknown = 0, clear = 0;              // results
    std::uint64_t wrongly_free = 0, wrongly_occluded = 0, wrongly_clear = 0;   // wrong results
    std::uint64_t free_on_dynamic = 0;
};

// Queries all points, one light after the other, and compares with rays.
void query_all(DynamicMask& mask, const scene::Scene& scene, const scene::SceneState& state, const ray::RayScene& rays,
               const std::vector<ShadowPoint>& points, const std::vector<char>& moves, Tally& tally)
{
    DynamicMask::Asked asked;
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        asked.clear_questions(points.size());
        const bool directional = scene.lights[l].type == scene::LightType::directional;
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            const glm::vec3 d = directional ? -state.light(l).direction : state.light(l).position - points[i].origin;
            if (!(glm::dot(d, points[i].normal) > 0)) continue;
            asked.point[asked.count] = i;
            asked.moving[asked.count++] = static_cast<std::uint8_t>(moves[points[i].object]);
        }
        mask.answer(l, points, asked);
        for (std::size_t q = 0; q < asked.count; ++q) {
            const ShadowPoint& point = points[asked.point[q]];
            const glm::vec3 d = directional ? -state.light(l).direction : state.light(l).position - point.origin;
            const float end = directional ? k_infinity : 0.9999f;
            const auto meets = [&](ray::Against against) {
                return rays.occluded_single(point.origin, 0, d, end, against);
            };
            const MaskAnswer answer = asked.answer[q];
            if (answer == MaskAnswer::free) {
                ++tally.free;
                tally.free_on_dynamic += asked.moving[q];
                tally.wrongly_free += meets(ray::Against::dynamic_only);
            } else if (answer == MaskAnswer::occluded) {
                ++tally.occluded;
                tally.wrongly_occluded += !meets(ray::Against::dynamic_only);
            } else {
                ++tally.unknown;
            }
            if (asked.clear[q]) {
                ++tally.clear;
                tally.wrongly_clear += meets(ray::Against::static_only);
            }
        }
    }
}

// Moves the dynamic objects in every round; the mask is told that they move from the second round on.
Tally query_soup(std::uint64_t seed, int rounds, const MaskOptions& options)
{
    const std::size_t dynamic_objects = 2 + seed % 5;
    const auto scene = Soup(seed, static_cast<int>(dynamic_objects)).take();
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    std::vector<char> moves(scene->objects.size(), 0);
    for (std::size_t o = moves.size() - dynamic_objects; o < moves.size(); ++o) moves[o] = 1;
    Random random(seed, 5);
    // Override all of their transforms, so that the ray scene treats them as dynamic objects.
    glm::dmat4 aside(1);
    aside[3].x = 0.1;
    for (std::size_t o = moves.size() - dynamic_objects; o < moves.size(); ++o)
        state.override_transform(scene->objects[o].node, &aside);
    Tally tally;
    std::unique_ptr<StaticTriangles> triangles;
    std::unique_ptr<DynamicMask> mask;
    for (int round = 0; round < rounds; ++round) {
        if (round > 0 && round % 3 != 0) move_last(*scene, state, random, dynamic_objects);
        if (round % 4 == 3)   // move a light
            for (const scene::Light& light : scene->lights) {
                if (random.below(2)) continue;
                glm::dmat4 place = scene->nodes[light.node].local;
                for (int row = 0; row < 3; ++row) place[3][row] += static_cast<double>(random.uniform(-1, 1));
                state.override_transform(light.node, &place);
            }
        state.advance(0);
        rays.update(state);
        if (!mask) {
            triangles = std::make_unique<StaticTriangles>(state, rays);
            mask = std::make_unique<DynamicMask>(state, rays, *triangles, options);
        }
        const CullingView view{glm::vec3(random.uniform(-4, 4), 1, 4), 0.004f * random.uniform(0.2f, 3.0f), 0};
        mask->begin_frame(state, rays, view);
        query_all(*mask, *scene, state, rays, random_points(*scene, rays, random, 600), moves, tally);
    }
    return tally;
}

void expect_true(const Tally& tally)
{
    EXPECT_EQ(tally.wrongly_free, 0u);
    EXPECT_EQ(tally.wrongly_occluded, 0u);
    EXPECT_EQ(tally.wrongly_clear, 0u);
}

Tally query_soups(std::uint64_t seeds, const MaskOptions& options)
{
    Tally sum;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        const Tally t = query_soup(seed, 8, options);
        sum.free += t.free, sum.occluded += t.occluded, sum.unknown += t.unknown, sum.clear += t.clear;
        sum.wrongly_free += t.wrongly_free, sum.wrongly_occluded += t.wrongly_occluded;
        sum.wrongly_clear += t.wrongly_clear, sum.free_on_dynamic += t.free_on_dynamic;
    }
    return sum;
}

TEST(DynamicMaskCulling, AgreesWithRaysOnRandomSoups)
{
    MaskOptions options;
    options.asked = 1;
    const Tally tally = query_soups(60, options);
    expect_true(tally);
    // Otherwise nothing was tested.
    EXPECT_GT(tally.free, 50'000u);
    EXPECT_GT(tally.free_on_dynamic, 5'000u);
    EXPECT_GT(tally.occluded, 5'000u);
    EXPECT_GT(tally.clear, 5'000u);
}

TEST(DynamicMaskCulling, AgreesWithRaysWithCoarseTexels)
{
    MaskOptions options;
    options.asked = 1;
    options.texel_pixels = 40;
    expect_true(query_soups(40, options));
}

// Edge-on triangles cover no texels, but still occlude.
TEST(DynamicMaskCulling, AgreesWithRaysWithFineTexelsInEdgeOnTriangles)
{
    MaskOptions options;
    options.asked = 1;
    options.texel_pixels = 0.5f;
    options.min_facing = 0.5;
    const Tally tally = query_soups(40, options);
    expect_true(tally);
    EXPECT_GT(tally.free, 20'000u);
}

// Rays along an outline that coincides with the border of texels, within rounding on either side. Far from the origin,
// where rounding is coarse.
void query_along_outline(double turn, Tally& tally)
{
    const glm::vec3 light_place(1000.3f, 1003.7f, 998.1f);
    scene::Scene built;
    built.materials.emplace_back();
    built.materials.back().double_sided = true;
    const auto add = [&](const std::vector<glm::vec3>& corners) {
        scene::Mesh mesh;
        mesh.positions = corners;
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{0, 0, 2}};
        const scene::NodeId node = built.add_node("", scene::none);
        built.nodes[node].mesh = static_cast<scene::MeshId>(built.meshes.size());
        built.meshes.push_back(std::move(mesh));
    };
    const auto at = [&](float x, float y, float z) { return light_place + glm::vec3(x, y, z); };
    add({at(-3, -4, -3), at(3, -4, -3), at(3, -4, 3), at(-3, -4, 3)});   // the floor
    // A plate that starts at x = 0, up to rounding, after it is rotated about the light.
    const glm::dvec3 middle(light_place);
    const auto turned = [&](const glm::dvec3& p, double angle) {
        const glm::dvec3 q = p - middle;
        return middle + glm::dvec3(std::cos(angle) * q.x + std::sin(angle) * q.z, q.y,
                                   -std::sin(angle) * q.x + std::cos(angle) * q.z);
    };
    std::vector<glm::vec3> plate;
    for (const glm::dvec3& p :
         {glm::dvec3(0, -2, -1), glm::dvec3(1.3, -2.2, -1), glm::dvec3(1.1, -1.9, 1.2), glm::dvec3(0, -2.1, 1.1)})
        plate.emplace_back(turned(middle + p, -turn));
    add(plate);
    scene::Light light;
    glm::dmat4 place(1);
    place[3] = glm::dvec4(glm::dvec3(light_place), 1);
    light.node = built.add_node("", scene::none, place);
    built.lights.push_back(light);
    built.finish();
    const auto scene = std::make_shared<scene::Scene>(std::move(built));
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    glm::dmat4 moved(1);
    for (int column = 0; column < 3; ++column) {
        glm::dvec3 axis(0);
        axis[column] = 1;
        moved[column] = glm::dvec4(turned(middle + axis, turn) - middle, 0);
    }
    moved[3] = glm::dvec4(turned(glm::dvec3(0), turn), 1);
    state.override_transform(scene->objects[1].node, &moved);
    state.advance(0);
    rays.update(state);
    const std::vector<char> moves = {0, 1};
    const StaticTriangles triangles(state, rays);
    MaskOptions options;
    options.asked = 1;
    options.texel_pixels = 0.02f;   // finer than the rounding of a ray
    DynamicMask mask(state, rays, triangles, options);
    mask.begin_frame(state, rays, {at(0, 0, 9), 0.002f, 0});
    Random random(3);
    std::vector<ShadowPoint> points;
    for (int i = 0; i < 4'000; ++i) {
        ShadowPoint point;
        point.object = 0;
        point.normal = {0, 1, 0};
        point.origin = at(1e-4f * random.uniform(-1, 1), -4 + 0.01f, random.uniform(-2, 2));
        points.push_back(point);
    }
    query_all(mask, *scene, state, rays, points, moves, tally);
}

TEST(DynamicMaskCulling, AgreesWithRaysAlongOutlinesOnTexelBorders)
{
    Tally tally;
    for (int k = 1; k <= 30; ++k) query_along_outline(0.0137 * k, tally);
    expect_true(tally);
    EXPECT_GT(tally.unknown, 10'000u);
}

// A dynamic object that is so much larger than the static scene that its outline leaves the range of int, in texels.
TEST(DynamicMaskCulling, AgreesWithRaysBelowAnObjectMuchLargerThanTheStaticScene)
{
    scene::Scene built;
    built.materials.emplace_back();
    built.materials.back().double_sided = true;
    const auto add = [&](const std::vector<glm::vec3>& corners) {
        scene::Mesh mesh;
        mesh.positions = corners;
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{0, 0, 2}};
        const scene::NodeId node = built.add_node("", scene::none);
        built.nodes[node].mesh = static_cast<scene::MeshId>(built.meshes.size());
        built.meshes.push_back(std::move(mesh));
    };
    add({{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}});
    constexpr float k_far = 2e4f;
    add({{0, 50, -k_far}, {0, 50, k_far}, {k_far, 50, k_far}, {k_far, 50, -k_far}});   // its edge is above the floor
    scene::Light light;
    light.type = scene::LightType::directional;
    const glm::dmat4 down(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 1, 0, 0),
                          glm::dvec4(0, 0, 0, 1));
    light.node = built.add_node("", scene::none, down);
    built.lights.push_back(light);
    built.finish();
    const auto scene = std::make_shared<scene::Scene>(std::move(built));
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    glm::dmat4 moved(1);
    moved[3].x = 0.01;
    state.override_transform(scene->objects[1].node, &moved);
    state.advance(0);
    rays.update(state);
    ASSERT_LT(state.light(0).direction.y, -0.99f);
    const StaticTriangles triangles(state, rays);
    MaskOptions options;
    options.asked = 1;
    options.edges_per_ray = 1e6;
    DynamicMask mask(state, rays, triangles, options);
    mask.begin_frame(state, rays, {{0, 1, 0}, 0, 1e-6f});   // the finest texels: 2^20 over the floor
    Random random(7);
    std::vector<ShadowPoint> points;
    for (int i = 0; i < 2'000; ++i) {
        ShadowPoint point;
        point.object = 0;
        point.normal = {0, 1, 0};
        point.origin = {random.uniform(-0.99f, 0.99f), 1e-4f, random.uniform(-0.99f, 0.99f)};
        points.push_back(point);
    }
    Tally tally;
    query_all(mask, *scene, state, rays, points, {0, 1}, tally);
    expect_true(tally);
    EXPECT_GT(tally.free, 500u);
    EXPECT_GT(tally.occluded, 500u);
}

TEST(DynamicMaskCullingFull, AgreesWithRaysOnAThousandSoups)
{
    MaskOptions options;
    options.asked = 1;
    expect_true(query_soups(1000, options));
}

// The least height within four planes, by the tree and by a linear search.
TEST(DynamicMaskCulling, LeastHeightEqualsALinearSearchOfAllTriangles)
{
    std::size_t some = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const auto scene = Soup(seed).take();
        const scene::SceneState state(scene, 0);
        const ray::RayScene rays(state);
        const StaticTriangles triangles(state, rays);
        Random random(seed, 9);
        for (int k = 0; k < 100; ++k) {
            visibility::LightPoint light;
            light.directional = k % 3 == 0;
            light.place = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
            if (light.directional) light.place = glm::normalize(light.place);
            const LightSpace space(light, triangles.bounds());
            const std::uint32_t face = random.below(space.faces());
            const double x = static_cast<double>(random.uniform()), y = static_cast<double>(random.uniform());
            const double wide = std::ldexp(1.0, -static_cast<int>(random.below(6)));
            const std::array<visibility::Plane, 4> sides = {
                space.in_world(face, space.side(0, x, 1, 0)), space.in_world(face, space.side(0, x + wide, -1, 0)),
                space.in_world(face, space.side(1, y, 1, 0)), space.in_world(face, space.side(1, y + wide, -1, 0))};
            visibility::Plane depth;
            depth.normal = {0, 0, 1};
            depth = space.in_world(face, depth);
            double least = std::numeric_limits<double>::infinity();
            for (visibility::TriangleId t = 0; t < triangles.size(); ++t) {
                const glm::dvec3 p[3] = {glm::dvec3(triangles[t].p[0]), glm::dvec3(triangles[t].p[1]),
                                         glm::dvec3(triangles[t].p[2])};
                visibility::ClippedPolygon inside;
                if (!visibility::clip_triangle(sides, p, inside)) continue;
                for (int c = 0; c < inside.count; ++c)
                    least = std::min(least, depth.at(inside.corner[static_cast<std::size_t>(c)]));
                // The side planes contain the light.
                for (int c = 0; c < inside.count; ++c) {
                    const glm::dvec3& corner = inside.corner[static_cast<std::size_t>(c)];
                    const glm::dvec3 q = space.in_face(face, corner);
                    EXPECT_NEAR(depth.at(corner), q.z, 1e-9);
                    if (q.z < 1e-3 && !light.directional) continue;
                    const OnFace on = space.on_face(q);
                    EXPECT_GT(on.x, x - 1e-6);
                    EXPECT_LT(on.x, x + wide + 1e-6);
                    EXPECT_GT(on.y, y - 1e-6);
                    EXPECT_LT(on.y, y + wide + 1e-6);
                }
            }
            EXPECT_EQ(triangles.least_height(sides, depth), least);
            some += least < 100;
        }
    }
    EXPECT_GT(some, 300u);
}

}   // namespace
}   // namespace gnomon::shadow_culling
