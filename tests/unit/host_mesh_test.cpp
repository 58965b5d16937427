// SPDX-License-Identifier: Apache-2.0
// Meshes from a host get the repairs that files get: directions of unit length, weights that sum to one.
#include <gtest/gtest.h>

#include <limits>

#include "api/convert.h"
#include "gnomon/error.h"

namespace gnomon {
namespace {

const Vec3 k_corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

scene::Mesh converted(const Mesh& mesh)
{
    return api::to_scene(mesh, api::SceneStamps(), scene::none);
}

TEST(HostMesh, NormalsWithoutADirectionAreTheTriangles)
{
    const Vec3 normals[] = {{0, 0, 0}, {0, 3, 0}, {0, .99999f, 0}};
    const scene::Mesh mesh = converted({.positions = k_corners, .normals = normals});
    EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
    EXPECT_EQ(mesh.normals[1], glm::vec3(0, 1, 0));
    EXPECT_EQ(mesh.normals[2].y, .99999f);   // within rounding: the bits are kept
}

TEST(HostMesh, TangentsAreOfUnitLengthAndHaveASign)
{
    const Vec3 normals[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const Vec4 tangents[] = {{0, 0, 0, 1}, {2, 0, 0, -.5f}, {0, 1, 0, -1}};
    const scene::Mesh mesh = converted({.positions = k_corners, .normals = normals, .tangents = tangents});
    EXPECT_NEAR(glm::length(glm::vec3(mesh.tangents[0])), 1, 1e-6);
    EXPECT_EQ(mesh.tangents[0].z, 0);
    EXPECT_EQ(mesh.tangents[1], glm::vec4(1, 0, 0, -1));
    EXPECT_EQ(mesh.tangents[2], glm::vec4(0, 1, 0, -1));
}

TEST(HostMesh, WeightsAreScaledToASumOfOneUnlessOneIsNegative)
{
    const Joints joints[3] = {};
    const Vec4 weights[] = {{.25f, .25f, 0, 0}, {0, 0, 0, 0}, {.3f, .7f, 0, 0}};
    const scene::Mesh mesh = converted({.positions = k_corners, .joints = {joints, {}}, .weights = {weights, {}}});
    EXPECT_EQ(mesh.skin->weights[0][0], glm::vec4(.5f, .5f, 0, 0));
    EXPECT_EQ(mesh.skin->weights[0][1], glm::vec4(1, 0, 0, 0));
    EXPECT_EQ(mesh.skin->weights[0][2], glm::vec4(.3f, .7f, 0, 0));
    const Vec4 negative[] = {{-1, 3, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
    EXPECT_EQ(
        converted({.positions = k_corners, .joints = {joints, {}}, .weights = {negative, {}}}).skin->weights[0][0],
        glm::vec4(-1, 3, 0, 0));
}

TEST(HostMesh, NumbersThatAreNotFiniteAreRefused)
{
    const float inf = std::numeric_limits<float>::infinity();
    const Vec3 normals[] = {{0, 0, 1}, {0, inf, 1}, {0, 0, 1}};
    EXPECT_THROW(converted({.positions = k_corners, .normals = normals}), UsageError);
}

}   // namespace
}   // namespace gnomon
