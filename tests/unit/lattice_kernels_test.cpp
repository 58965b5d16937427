// SPDX-License-Identifier: Apache-2.0
// Interpolation between the cache points of a lattice cell, against light in closed form.
#include "irradiance_cache/points/lattice_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace gnomon::irradiance_cache {
namespace {

// The irradiance of a surface under an even sky of radiance 1/pi, by its normal; and its gradient.
float irradiance(const glm::vec3& n)
{
    return 0.5f * (1 + n.y);
}
glm::vec3 light_vector(const glm::vec3& n)
{
    const glm::vec3 up(0, 1, 0);
    return irradiance(n) * n + 0.5f * (up - n.y * n);
}

// The point of a unit ball around (0, 0, 0) at a place of the plane of x and y, seen along z.
glm::vec3 on_ball(float x, float y)
{
    return {x, y, std::sqrt(1 - x * x - y * y)};
}

// Four cache points of a ball around a cell of its side.
struct Cell {
    float x, y, spacing;
    CellAnchors anchors{};
    Cell(float left, float low, float wide) : x(left), y(low), spacing(wide)
    {
        constexpr float k_far = std::numeric_limits<float>::max();
        anchors.axis = 2;
        for (int i = 0; i < 4; ++i) {
            const glm::vec3 p = on_ball(x + (i % 2 == 1 ? spacing : 0), y + (i / 2 == 1 ? spacing : 0));
            put(i, p, p);
            anchors.low_b[i] = anchors.low_c[i] = -k_far, anchors.high_b[i] = anchors.high_c[i] = k_far;
        }
    }
    void put(int i, const glm::vec3& p, const glm::vec3& n)
    {
        anchors.x[i] = p.x, anchors.y[i] = p.y, anchors.z[i] = p.z;
        anchors.nx[i] = n.x, anchors.ny[i] = n.y, anchors.nz[i] = n.z;
        for (int colour = 0; colour < 3; ++colour)
            for (int axis = 0; axis < 3; ++axis) anchors.light[3 * colour + axis][i] = light_vector(n)[axis];
    }
    // What arrives at a place of the cell, 0 to 1 along each side, at a surface that faces `n`.
    float light_at(float fx, float fy, const glm::vec3& n) const
    {
        const glm::vec3 p = on_ball(x + fx * spacing, y + fy * spacing);
        LatticePoints points;
        points.resize(1);
        points.x[0] = p.x, points.y[0] = p.y, points.z[0] = p.z;
        points.gx[0] = p.x, points.gy[0] = p.y, points.gz[0] = p.z;
        points.nx[0] = n.x, points.ny[0] = n.y, points.nz[0] = n.z;
        points.fx[0] = fx, points.fy[0] = fy;
        LatticeLight light;
        light.resize(1);
        interpolate_cell(anchors, {0.35f * spacing, 0.7f, true}, points, 0, 1, light);
        return light.g[0];
    }
};

// A cache point's light towards a normal at an angle lacks what comes from below its horizon, and between two cache
// points a straight line lacks as much the other way. At the lower side of a ball little light is left to err by.
TEST(LatticeKernels, OnABallIsTheLightOfAnEvenSky)
{
    for (const float low : {-0.8f, -0.5f, 0.0f, 0.5f}) {
        const Cell cell(-0.1f, low, 0.2f);
        for (const float fx : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f})
            for (const float fy : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f}) {
                const glm::vec3 p = on_ball(cell.x + fx * cell.spacing, low + fy * cell.spacing);
                EXPECT_NEAR(cell.light_at(fx, fy, p), irradiance(p), 0.0015f * irradiance(p))
                    << low << ' ' << fx << ' ' << fy;
            }
    }
}

// On a plane, a normal map's normal takes each cache point's light as it is.
TEST(LatticeKernels, OnAPlaneTurnsWithANormalMap)
{
    Cell cell(-0.1f, -0.1f, 0.2f);
    const glm::vec3 n(0, 0, 1), turned = glm::normalize(glm::vec3(0, 0.3f, 1));
    for (int i = 0; i < 4; ++i) cell.put(i, on_ball(0, 0), n);
    cell.anchors.one_normal = true;
    EXPECT_FLOAT_EQ(cell.light_at(0.4f, 0.3f, turned), glm::dot(light_vector(n), turned));
    cell.anchors.one_normal = false;
    EXPECT_NEAR(cell.light_at(0.4f, 0.3f, turned), glm::dot(light_vector(n), turned), 1e-6f);
}

}   // namespace
}   // namespace gnomon::irradiance_cache
