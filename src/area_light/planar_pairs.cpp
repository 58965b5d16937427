// SPDX-License-Identifier: Apache-2.0
#include "area_light/planar_pairs.h"

#include <algorithm>

namespace gnomon::area_light {

namespace {

using visibility::no_triangle;
using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

constexpr double k_flat = 2.5e-7;       // largest distance from the plane, per largest coordinate: rounding alone
constexpr double k_least_turn = 1e-3;   // least sine at a corner

// The corner of a triangle that is not on an edge of its neighbour; -1 if it is not one.
int apex_over(const StaticTriangle& a, int edge, const StaticTriangle& b)
{
    int apex = -1;
    for (int k = 0; k < 3; ++k)
        if (b.p[k] != a.p[edge] && b.p[k] != a.p[(edge + 1) % 3]) {
            if (apex >= 0) return -1;
            apex = k;
        }
    return apex;
}

struct Quad {
    glm::vec3 p[4];
};
Quad quad_of(const StaticTriangle& a, int edge, const StaticTriangle& b, int apex)
{
    return {{a.p[(edge + 2) % 3], a.p[edge], b.p[apex], a.p[(edge + 1) % 3]}};
}

bool is_planar_and_convex(const Quad& of)
{
    const auto& quad = of.p;
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(quad[1]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[0]));
    const double length = glm::length(normal);
    if (!(length > 0)) return false;
    float largest = 0;
    for (const glm::vec3& p : quad)
        for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(p[axis]));
    const double room = k_flat * static_cast<double>(largest);
    if (!(std::abs(glm::dot(normal / length, glm::dvec3(quad[2]) - glm::dvec3(quad[0]))) <= room)) return false;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 in = glm::dvec3(quad[(k + 1) % 4]) - glm::dvec3(quad[k]),
                         out = glm::dvec3(quad[(k + 2) % 4]) - glm::dvec3(quad[(k + 1) % 4]);
        if (!(glm::dot(normal / length, glm::cross(in, out)) > k_least_turn * glm::length(in) * glm::length(out)))
            return false;
    }
    return true;
}

}   // namespace

PlanarPairs::PlanarPairs(const StaticTriangles& triangles) : pairs_(triangles.size())
{
    for (TriangleId id = 0; id < triangles.size(); ++id)
        for (int edge = 0; edge < 3 && pairs_[id].partner == no_triangle; ++edge) {
            const TriangleId next = triangles.across(id, edge);
            if (next == no_triangle || next <= id || pairs_[next].partner != no_triangle) continue;
            const int apex = apex_over(triangles[id], edge, triangles[next]);
            if (apex < 0 || !is_planar_and_convex(quad_of(triangles[id], edge, triangles[next], apex))) continue;
            pairs_[id] = {next, static_cast<std::uint8_t>(edge), static_cast<std::uint8_t>(apex)};
            pairs_[next].partner = id;
        }
}

void PlanarPairs::gather(const StaticTriangles& triangles, std::span<const TriangleId> ids, TriangleList& list) const
{
    list.clear();
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const TriangleId id = ids[i];
        const Pair& pair = pairs_[id];
        // A partner is most often next to it.
        const bool both = pair.partner != no_triangle && ((i + 1 < ids.size() && ids[i + 1] == pair.partner) ||
                                                          (i > 0 && ids[i - 1] == pair.partner) ||
                                                          std::binary_search(ids.begin(), ids.end(), pair.partner));
        if (!both)
            list.push(triangles[id].p);
        else if (id < pair.partner)
            list.push(quad_of(triangles[id], pair.edge, triangles[pair.partner], pair.apex).p);
    }
    list.pad();
}

}   // namespace gnomon::area_light
