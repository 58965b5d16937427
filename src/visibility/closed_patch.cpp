// SPDX-License-Identifier: Apache-2.0
#include "visibility/closed_patch.h"

namespace gnomon::visibility {

bool agrees(const StaticTriangle& a, int edge, const StaticTriangle& b)
{
    const glm::vec3 &from = a.p[edge], &to = a.p[(edge + 1) % 3];
    for (int e = 0; e < 3; ++e)
        if (b.p[e] == to && b.p[(e + 1) % 3] == from) return true;
    return false;
}

int crossing(const StaticTriangle& triangle, const glm::dvec3& from, const glm::dvec3& to)
{
    // [Moeller and Trumbore 1997]
    const glm::dvec3 a(triangle.p[0]), e1 = glm::dvec3(triangle.p[1]) - a, e2 = glm::dvec3(triangle.p[2]) - a;
    const glm::dvec3 way = to - from, h = glm::cross(way, e2);
    const double determinant = glm::dot(e1, h);
    if (determinant == 0) return 0;
    const glm::dvec3 s = from - a;
    const double u = glm::dot(s, h) / determinant;
    if (!(u >= 0 && u <= 1)) return 0;
    const glm::dvec3 q = glm::cross(s, e1);
    const double v = glm::dot(way, q) / determinant;
    if (!(v >= 0 && u + v <= 1)) return 0;
    const double at = glm::dot(e2, q) / determinant;
    if (!(at > 0 && at < 1)) return 0;
    return determinant > 0 ? 1 : -1;
}

}   // namespace gnomon::visibility
