// SPDX-License-Identifier: Apache-2.0
#include "scene/deform.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace gnomon::scene {
namespace {

// A joint that stretches one axis: normals turn away from it, so that they stay perpendicular to the surface.
TEST(DeformMesh, SkinnedNormalsStayPerpendicular)
{
    Mesh mesh;
    mesh.positions = {{1, 0, 0}, {0, 1, 0}, {1, 0, 1}};
    mesh.normals.assign(3, glm::normalize(glm::vec3(1, 1, 0)));
    mesh.tangents.assign(3, glm::vec4(glm::normalize(glm::vec3(1, -1, 0)), 1));
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    mesh.skin.emplace();
    mesh.skin->joints[0].assign(3, {0, 0, 0, 0});
    mesh.skin->weights[0].assign(3, {1, 0, 0, 0});
    const std::vector<glm::mat4> joints{glm::scale(glm::mat4(1), glm::vec3(2, 1, 1))};
    DeformedMesh out;
    deform_mesh(mesh, 0, {}, joints, out);
    EXPECT_EQ(out.positions[0], glm::vec3(2, 0, 0));
    for (const glm::vec3& normal : out.normals) {
        EXPECT_NEAR(glm::length(normal - glm::normalize(glm::vec3(1, 2, 0))), 0, 1e-6f);
        EXPECT_NEAR(glm::dot(normal, out.positions[0] - out.positions[1]), 0, 1e-6f);
    }
    EXPECT_NEAR(glm::dot(glm::vec3(out.tangents[0]), out.normals[0]), 0, 1e-6f);
}

}   // namespace
}   // namespace gnomon::scene
