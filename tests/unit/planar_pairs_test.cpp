// SPDX-License-Identifier: Apache-2.0
#include "area_light/planar_pairs.h"

#include <gtest/gtest.h>

#include "ray/ray_scene.h"
#include "scene/state.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {
namespace {

// Whether two triangles that share the edge from corner 0 to corner 1 become a pair.
bool are_paired(const std::array<glm::vec3, 4>& corners)
{
    scene::Scene made;
    made.materials.emplace_back();
    scene::Mesh mesh;
    mesh.positions.assign(corners.begin(), corners.end());
    mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
    mesh.parts = {{0, 0, 2}};
    made.meshes.push_back(mesh);
    made.add_node("two", scene::none);
    made.nodes[0].mesh = 0;
    made.finish();
    const auto scene = std::make_shared<const scene::Scene>(std::move(made));
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    const visibility::StaticTriangles triangles(state, rays);
    const PlanarPairs pairs(triangles);
    EXPECT_EQ(pairs.partner(0) == 1, pairs.partner(1) == 0);
    return pairs.partner(0) == 1;
}

TEST(PlanarPairs, AreConvexQuadrilateralsOfOnePlane)
{
    const glm::vec3 a(0, 0, 0), b(1, 1, 0);
    EXPECT_TRUE(are_paired({a, b, {0, 1, 0}, {1, 0, 0}}));
    // Not in one plane.
    EXPECT_FALSE(are_paired({a, b, {0, 1, 0}, {1, 0, 0.2f}}));
    // Both apexes beyond one end of the shared edge: an arrow.
    EXPECT_FALSE(are_paired({a, b, {1, 3, 0}, {3, 1, 0}}));
    // A third corner in line with the edge: a triangle.
    EXPECT_FALSE(are_paired({a, b, {0, 2, 0}, {2, 0, 0}}));
    // Folded back on itself.
    EXPECT_FALSE(are_paired({a, b, {0, 1, 0}, {0.2f, 0.9f, 0}}));
}

}   // namespace
}   // namespace gnomon::area_light
