// SPDX-License-Identifier: Apache-2.0
// Scenes of very many triangles: patches of groups of triangles, and no proofs.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "patches/surface_patches.h"
#include "patches/triangle_groups.h"
#include "visibility/static_triangles.h"
#include "world.h"

namespace gnomon {
namespace {

using patches::group_triangles;
using patches::Patch;
using patches::SurfacePatches;
using patches::TriangleGroups;
using test::World;
using visibility::no_triangle;
using visibility::StaticTriangles;

World spheres()
{
    return World("spheres?objects=12&dynamic=0");
}

TEST(ManyTriangles, GroupsAreOfNeighboursThatFaceOneWay)
{
    World world = spheres();
    const ray::ObjectGeometry& geometry = world.rays.geometry(0);
    const scene::Mesh& mesh = *geometry.mesh;
    const TriangleGroups groups = group_triangles(*world.scene, geometry, {.triangles = 8, .area = 1e9f});
    ASSERT_EQ(groups.group_of.size(), mesh.triangles.size());
    EXPECT_LT(groups.groups.size(), mesh.triangles.size() / 4);
    EXPECT_GE(groups.groups.size(), mesh.triangles.size() / 8);
    std::map<std::uint32_t, int> members;
    double area = 0, grouped = 0;
    const auto normal_of = [&](std::uint32_t t) {
        const glm::uvec3 i = mesh.triangles[t];
        const glm::vec3 a = geometry.positions[i.x];
        return 0.5f * glm::cross(geometry.positions[i.y] - a, geometry.positions[i.z] - a);
    };
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const float own = glm::length(normal_of(t));
        area += static_cast<double>(own);
        if (groups.group_of[t] == scene::none) {
            EXPECT_EQ(own, 0);
            continue;
        }
        ++members[groups.group_of[t]];
        const TriangleGroups::Group& group = groups.groups[groups.group_of[t]];
        EXPECT_GT(glm::dot(normal_of(t), normal_of(group.triangle)), 0) << t;
        // The sphere around the representative's centre contains every member.
        const glm::uvec3 i = mesh.triangles[t], r = mesh.triangles[group.triangle];
        const auto corner = [&](std::uint32_t index) { return geometry.positions[index]; };
        const glm::vec3 centre = (corner(r.x) + corner(r.y) + corner(r.z)) / 3.0f;
        const float edge = std::max({glm::distance(corner(r.x), corner(r.y)), glm::distance(corner(r.y), corner(r.z)),
                                     glm::distance(corner(r.z), corner(r.x))});
        for (const std::uint32_t index : {i.x, i.y, i.z})
            EXPECT_LE(glm::distance(corner(index), centre), group.radius * edge * 1.0001f);
    }
    for (const TriangleGroups::Group& group : groups.groups)
        grouped += static_cast<double>(group.area * glm::length(normal_of(group.triangle)));
    EXPECT_NEAR(grouped, area, 1e-4 * area);
    for (const auto& [group, count] : members) EXPECT_LE(count, 8) << group;
    // An area of nothing leaves each triangle by itself.
    const TriangleGroups single = group_triangles(*world.scene, geometry, {.triangles = 8, .area = 0});
    for (const TriangleGroups::Group& group : single.groups) EXPECT_EQ(group.area, 1);
}

// Patches of groups cover what patches of triangles cover, and every triangle finds its patch nearby, on its own side.
TEST(ManyTriangles, PatchesOfGroupsCoverTheSurfaces)
{
    World world = spheres();
    patches::PatchOptions plain, grouped;
    plain.patches = grouped.patches = 1024;
    grouped.units.ungrouped = 0, grouped.units.grouped = 6000;   // of some 49,000 triangles
    const SurfacePatches a(world.state, world.rays, plain, world.tasks),
        b(world.state, world.rays, grouped, world.tasks);
    const auto area_of = [](const SurfacePatches& all) {
        double area = 0;
        for (const Patch& patch : all.patches()) area += static_cast<double>(patch.area);
        return area;
    };
    EXPECT_NEAR(area_of(b), area_of(a), 1e-3 * area_of(a));
    EXPECT_GT(b.patches().size(), a.patches().size() / 2);
    std::size_t asked = 0, found = 0;
    for (scene::ObjectId o = 0; o < world.scene->objects.size(); ++o) {
        const ray::ObjectGeometry& geometry = world.rays.geometry(o);
        for (std::uint32_t t = 0; t < geometry.mesh->triangles.size(); t += 7) {
            glm::vec3 p[3];
            geometry.corners(t, p);
            const glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]), middle = (p[0] + p[1] + p[2]) / 3.0f;
            if (!(glm::length(normal) > 0)) continue;
            const patches::PatchId patch =
                b.patch_at(world.rays, o, t, 1.0f / 3, 1.0f / 3, true, middle + 1e-3f * glm::normalize(normal));
            ++asked;
            if (patch == patches::k_no_patch) continue;
            ++found;
            const Patch& of = b.patches()[patch];
            EXPECT_LE(glm::distance(middle, of.position), 1.01f * of.radius);
            EXPECT_GT(glm::dot(normal, of.normal), 0);
        }
    }
    EXPECT_GT(found, asked * 95 / 100);
}

TEST(ManyTriangles, NothingIsProvenWhereNoTriangleIsListed)
{
    World world = spheres();
    const StaticTriangles all(world.state, world.rays), none(world.state, world.rays, {}, 1000);
    ASSERT_TRUE(all.listed());
    ASSERT_GT(all.size(), 1000u);
    EXPECT_FALSE(none.listed());
    EXPECT_EQ(none.size(), 0u);
    EXPECT_EQ(none.bytes(), 0u);
    EXPECT_EQ(none.first_of(0), no_triangle);
    EXPECT_EQ(none.bounds().low, all.bounds().low);
    EXPECT_EQ(none.bounds().high, all.bounds().high);
    EXPECT_EQ(none.largest_coordinate(), all.largest_coordinate());
    // A beam beside everything is free only if that is known.
    const std::array<visibility::Plane, 4> sides{};
    const visibility::Plane up{{0, 1, 0}, 0};
    EXPECT_EQ(none.least_height(sides, up), -std::numeric_limits<double>::infinity());
    std::vector<visibility::TriangleId> found{1};
    none.along({0, 0, 10}, {0, 0, -20}, 8, found);
    EXPECT_TRUE(found.empty());
}

}   // namespace
}   // namespace gnomon
