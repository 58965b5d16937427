// SPDX-License-Identifier: Apache-2.0
#pragma once
// Triangles on the sphere of directions, and how they are divided.

#include <array>
#include <cmath>

#include "base/math.h"

namespace gnomon::environment_light {

/// Three unit vectors.
using Corners = std::array<glm::dvec3, 3>;

inline std::array<Corners, 20> icosahedron()
{
    const double g = (1 + std::sqrt(5.0)) / 2;
    const glm::dvec3 p[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    constexpr int face[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    // Turn it, so that no edge is parallel to an axis: the edges of buildings are.
    const glm::dquat turn = glm::angleAxis(0.7, glm::normalize(glm::dvec3(0.36, 0.48, 0.8)));
    std::array<Corners, 20> result;
    for (std::size_t f = 0; f < 20; ++f)
        for (std::size_t c = 0; c < 3; ++c) result[f][c] = turn * glm::normalize(p[face[f][c]]);
    return result;
}

// The solid angle of a spherical triangle [Van Oosterom and Strackee 1983].
inline double solid_angle(const Corners& c)
{
    const double volume = std::abs(glm::dot(c[0], glm::cross(c[1], c[2])));
    const double around = 1 + glm::dot(c[0], c[1]) + glm::dot(c[1], c[2]) + glm::dot(c[2], c[0]);
    return 2 * std::atan2(volume, around);
}

// The four quarters: three at the corners, then the middle one.
inline std::array<Corners, 4> quarters(const Corners& c)
{
    const glm::dvec3 ab = glm::normalize(c[0] + c[1]), bc = glm::normalize(c[1] + c[2]),
                     ca = glm::normalize(c[2] + c[0]);
    return {Corners{c[0], ab, ca}, Corners{ab, c[1], bc}, Corners{ca, bc, c[2]}, Corners{ab, bc, ca}};
}

// The nine ninths, row by row from the first corner.
inline std::array<Corners, 9> ninths(const Corners& c)
{
    const auto at = [&](int row, int column) {
        const double v = column / 3.0, u = (row - column) / 3.0;
        return glm::normalize((1 - u - v) * c[0] + u * c[1] + v * c[2]);
    };
    std::array<Corners, 9> parts;
    std::size_t next = 0;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column <= row; ++column) {
            parts[next++] = {at(row, column), at(row + 1, column), at(row + 1, column + 1)};
            if (column < row) parts[next++] = {at(row, column), at(row + 1, column + 1), at(row, column + 1)};
        }
    return parts;
}

inline glm::dvec3 middle(const Corners& c)
{
    return glm::normalize(c[0] + c[1] + c[2]);
}

inline bool contains(const Corners& c, const glm::dvec3& d)
{
    return glm::dot(d, glm::cross(c[0], c[1])) >= 0 && glm::dot(d, glm::cross(c[1], c[2])) >= 0 &&
           glm::dot(d, glm::cross(c[2], c[0])) >= 0;
}

// A point of the cell by two numbers in [0, 1), uniform in the flat triangle.
inline glm::dvec3 point_in(const Corners& c, double u, double v)
{
    if (u + v > 1) u = 1 - u, v = 1 - v;
    return glm::normalize((1 - u - v) * c[0] + u * c[1] + v * c[2]);
}

// The point of a cell by the number of a member of the R2 sequence [Roberts 2018].
inline glm::dvec3 jittered_in(const Corners& c, double index)
{
    constexpr double k_root = 1.32471795724474602596;   // of x^3 = x + 1
    const auto fraction = [](double x) { return x - std::floor(x); };
    return point_in(c, fraction(0.5 + index / k_root), fraction(0.5 + index / (k_root * k_root)));
}

}   // namespace gnomon::environment_light
