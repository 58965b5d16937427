// SPDX-License-Identifier: Apache-2.0
// Places that points of lobes' rays share: near, on the same side of the same triangle, and functions of the point.
#include <gtest/gtest.h>

#include <numeric>

#include "base/random.h"
#include "scene/builtin/builtin.h"
#include "trace/shared_places.h"

namespace gnomon::trace {
namespace {

struct Points {
    scene::SceneState state;
    ray::RayScene rays;
    std::vector<TilePoint> points;
    std::vector<visibility::ShadowPoint> shadow_points;
    std::vector<glm::vec3> normals;

    explicit Points(std::shared_ptr<const scene::Scene> scene) : state(std::move(scene), 0), rays(state) {}
    void add(scene::ObjectId object, std::uint32_t triangle, float u, float v, float width, float lobe_rays)
    {
        glm::vec3 p[3];
        rays.geometry(object).corners(triangle, p);
        const glm::vec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
        TilePoint& point = points.emplace_back();
        point.surface.position = (1 - u - v) * p[0] + u * p[1] + v * p[2];
        point.surface.cone.width = width;
        point.lobe.rays = lobe_rays;
        shadow_points.push_back({point.surface.position, normal, object, triangle, u, v, true});
        normals.push_back(normal);
    }
    PointBatch batch() const { return {points, shadow_points, normals, {}, false, true}; }
};

TEST(SharedPlaces, LieWithinHalfOfTheConeAndAreFewer)
{
    Points all(std::make_shared<const scene::Scene>(scene::make_cornell()));
    Random random(3);
    constexpr float k_width = 0.4f;
    for (int i = 0; i < 4000; ++i) {
        float u = random.uniform(0, 1), v = random.uniform(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        all.add(0, 0, u, v, k_width, 16);
    }
    std::vector<std::uint32_t> asked(all.points.size());
    std::iota(asked.begin(), asked.end(), 0u);
    SharedPlaces places(all.rays);
    places.find(all.batch(), asked);
    EXPECT_EQ(places.own(), 0u);
    EXPECT_LT(places.places().size(), all.points.size() / 4);
    EXPECT_GT(places.places().size(), 1u);
    for (std::size_t k = 0; k < asked.size(); ++k) {
        const visibility::ShadowPoint& place = places.places()[places.place_of(k)];
        EXPECT_LE(glm::distance(place.origin, all.points[k].surface.position), 0.5f * k_width);
        EXPECT_TRUE(place.u >= 0 && place.v >= 0 && place.u + place.v <= 1);
        EXPECT_EQ(place.normal, all.normals[k]);
    }

    // Ask for some of them in another order: their places are the same.
    std::vector<std::uint32_t> some;
    for (std::uint32_t k = 4000; k-- > 0;)
        if (k % 3 != 0) some.push_back(k);
    SharedPlaces again(all.rays);
    again.find(all.batch(), some);
    for (std::size_t k = 0; k < some.size(); ++k) {
        EXPECT_EQ(again.places()[again.place_of(k)].origin, places.places()[places.place_of(some[k])].origin);
        EXPECT_EQ(again.places()[again.place_of(k)].u, places.places()[places.place_of(some[k])].u);
    }
}

TEST(SharedPlaces, OnesOfTheirOwnForNarrowConesAndOtherPaths)
{
    Points all(std::make_shared<const scene::Scene>(scene::make_cornell()));
    all.add(0, 0, 0.3f, 0.3f, 0.5f, 16);
    all.add(0, 0, 0.3f, 0.3f, 0.5f, 0);     // not of a lobe
    all.add(0, 0, 0.3f, 0.3f, 1e-7f, 16);   // narrow
    all.add(0, 0, 0.3001f, 0.3f, 0.5f, 16);
    const std::vector<std::uint32_t> asked{0, 1, 2, 3};
    SharedPlaces places(all.rays);
    places.find(all.batch(), asked);
    EXPECT_EQ(places.own(), 2u);
    EXPECT_EQ(places.places().size(), 3u);
    EXPECT_EQ(places.place_of(0), places.place_of(3));
    for (const std::size_t k : {1u, 2u})
        EXPECT_EQ(places.places()[places.place_of(k)].origin, all.shadow_points[asked[k]].origin);
    EXPECT_EQ(places.own_points()[0], 1u);
    EXPECT_EQ(places.own_points()[1], 2u);
}

// Of triangles that are smaller than the cone, one stands in for those around it that face its way; the choice depends
// on neither the order of questions nor what else is asked.
TEST(SharedPlaces, SmallTrianglesShareThemToo)
{
    Points all(std::make_shared<const scene::Scene>(scene::make_spheres({.objects = 1, .dynamic = 0})));
    scene::ObjectId ball = 0;
    while (all.rays.geometry(ball).mesh->triangles.size() < 1000) ++ball;
    const auto triangles = static_cast<std::uint32_t>(all.rays.geometry(ball).mesh->triangles.size());
    Box3 box;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        glm::vec3 p[3];
        all.rays.geometry(ball).corners(t, p);
        for (const glm::vec3& corner : p) box.add(corner);
    }
    const float width = box.diagonal() / 4;
    for (std::uint32_t t = 0; t < triangles; ++t) all.add(ball, t, 0.3f, 0.3f, width, 16);
    std::vector<std::uint32_t> asked(all.points.size()), backwards;
    std::iota(asked.begin(), asked.end(), 0u);
    for (std::size_t k = asked.size(); k-- > 0;)
        if (k % 3 == 0) backwards.push_back(asked[k]);
    PlaceGroups groups, others;
    SharedPlaces places(all.rays, &groups), again(all.rays, &others), alone(all.rays);
    places.find(all.batch(), asked);
    again.find(all.batch(), backwards);
    alone.find(all.batch(), asked);
    EXPECT_EQ(alone.places().size(), asked.size());
    EXPECT_LT(places.places().size(), asked.size() / 5);
    EXPECT_GT(groups.bytes(), 0u);
    for (std::size_t k = 0; k < asked.size(); ++k) {
        const visibility::ShadowPoint& place = places.places()[places.place_of(k)];
        EXPECT_LE(glm::distance(place.origin, all.points[k].surface.position), width);
        EXPECT_GT(glm::dot(place.normal, all.normals[k]), 0);
        EXPECT_NEAR(glm::length(place.normal), 1, 1e-5f);
    }
    for (std::size_t k = 0; k < backwards.size(); ++k)
        EXPECT_EQ(again.places()[again.place_of(k)].origin, places.places()[places.place_of(backwards[k])].origin);
    // Narrow cones keep to their triangles.
    Points narrow(std::make_shared<const scene::Scene>(scene::make_spheres({.objects = 1, .dynamic = 0})));
    for (std::uint32_t t = 0; t < triangles; ++t) narrow.add(ball, t, 0.3f, 0.3f, 0.01f * width, 16);
    SharedPlaces own(narrow.rays, &others);
    own.find(narrow.batch(), asked);
    EXPECT_GE(own.places().size(), asked.size());
}

}   // namespace
}   // namespace gnomon::trace
