// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/interior.h"

#include <gtest/gtest.h>

namespace gnomon::scene {
namespace {

// Sides of a box, as bits; each a rectangle that faces inward (or outward).
enum Side { low_x = 1, high_x = 2, low_y = 4, high_y = 8, low_z = 16, high_z = 32, all = 63 };

Scene box(int sides, const glm::vec3& size, bool inward = true)
{
    Scene scene;
    scene.materials.emplace_back();
    Mesh mesh;
    for (int i = 0; i < 6; ++i) {
        if (!(sides & (1 << i))) continue;
        const int axis = i / 2;
        const bool high = i % 2;
        glm::vec3 p(0), u(0), v(0);
        if (high) p[axis] = size[axis];
        u[(axis + 1) % 3] = size[(axis + 1) % 3];
        v[(axis + 2) % 3] = size[(axis + 2) % 3];
        if (high == inward) std::swap(u, v);
        const auto n = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec3& corner : {p, p + u, p + u + v, p + v}) mesh.positions.push_back(corner);
        mesh.triangles.emplace_back(n, n + 1, n + 2);
        mesh.triangles.emplace_back(n, n + 2, n + 3);
    }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    scene.meshes.push_back(mesh);
    scene.nodes.resize(1);
    scene.nodes[0].mesh = 0;
    scene.finish();
    return scene;
}

TEST(Interior, SolidObjectsAreSeenFromOutside)
{
    EXPECT_FALSE(find_interior(box(all, {4, 3, 5}, false)));
    EXPECT_FALSE(find_interior(box(low_y, {4, 3, 5})));
    EXPECT_FALSE(find_interior(box(low_y | low_x | low_z, {4, 3, 5})));
    EXPECT_FALSE(find_interior(Scene()));
}

TEST(Interior, RoomIsSeenFromInside)
{
    const glm::vec3 size(12, 3, 4);
    const auto room = find_interior(box(all, size));
    ASSERT_TRUE(room);
    EXPECT_TRUE(room->covered);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GT(room->eye[axis], 0);
        EXPECT_LT(room->eye[axis], size[axis]);
    }
    EXPECT_GT(std::abs(room->direction.x), 0.9f);   // along the longest side
    EXPECT_EQ(room->direction.y, 0);
}

// Beyond 1e9 the squares of areas exceed the range of float, beyond 1e19 those of lengths, too.
TEST(Interior, RoomsOfAnySizeAreSeenFromInside)
{
    for (const float unit : {1e-6f, 1e6f, 1e10f, 1e25f}) {
        const auto room = find_interior(box(all, unit * glm::vec3(12, 3, 4)));
        ASSERT_TRUE(room) << unit;
        EXPECT_TRUE(room->covered) << unit;
        EXPECT_GT(std::abs(room->direction.x), 0.9f) << unit;
    }
}

TEST(Interior, CourtyardHasNoRoof)
{
    const auto court = find_interior(box(all & ~high_y, {8, 6, 5}));
    ASSERT_TRUE(court);
    EXPECT_FALSE(court->covered);
}

TEST(Interior, OpenBoxIsSeenThroughItsOpening)
{
    for (const Side open : {low_x, high_x, low_z, high_z}) {
        const auto stage = find_interior(box(all & ~open, {5, 5, 5}));
        ASSERT_TRUE(stage) << open;
        EXPECT_TRUE(stage->covered);
        glm::vec3 in(0);
        in[open <= high_x ? 0 : 2] = open == low_x || open == low_z ? 1.0f : -1.0f;
        EXPECT_EQ(stage->direction, in) << open;
        EXPECT_LT(glm::dot(stage->eye - glm::vec3(2.5f), in), -2.5f) << open;   // the eye is in front of it
    }
}

TEST(Interior, RoomsGetInteriorDefaults)
{
    Scene room = box(all & ~high_z, {5, 5, 5});
    add_default_light(room);
    add_default_camera(room);
    EXPECT_EQ(room.lights.size(), 16u);
    EXPECT_GT(room.ambient.x, 0);
    EXPECT_EQ(room.cameras.size(), 1u);
    Scene thing = box(all, {5, 5, 5}, false);
    add_default_light(thing);
    ASSERT_EQ(thing.lights.size(), 1u);
    EXPECT_EQ(thing.lights[0].type, LightType::directional);
    EXPECT_EQ(thing.ambient, glm::vec3(0));
    EXPECT_EQ(thing.background.color, glm::vec3(0));
}

TEST(Interior, SunReachesTheGroundOfACourtyard)
{
    Scene court = box(all & ~high_y, {12, 6, 3});
    add_default_light(court);
    ASSERT_EQ(court.lights.size(), 1u);
    // The path to the sun is open from somewhere on the ground.
    const glm::vec3 to_sun = court.background.sun_direction;
    const glm::vec3 up = to_sun * (6 / to_sun.y);
    EXPECT_LT(std::abs(up.x), 12);
    EXPECT_LT(std::abs(up.z), 3);
    EXPECT_GT(court.background.color.x, 0);   // ambient light approximates higher bounces
}

TEST(SpaceGrid, CastsAgainstFrontAndBackFaces)
{
    const Scene scene = box(all, {4, 4, 4});
    const SpaceGrid grid(scene, 0);
    const SpaceGrid::Hit in = grid.cast({2, 2, 2}, {1, 0, 0});
    EXPECT_EQ(in.met, SpaceGrid::Met::front);
    EXPECT_NEAR(in.distance, 2, 2 * grid.cell());
    EXPECT_EQ(grid.cast({-3, 2, 2}, {1, 0, 0}).met, SpaceGrid::Met::back);
    EXPECT_EQ(grid.cast({-3, 2, 2}, {-1, 0, 0}).met, SpaceGrid::Met::nothing);
    EXPECT_GT(grid.enclosure({2, 2, 2}), 0.99f);
}

}   // namespace
}   // namespace gnomon::scene
