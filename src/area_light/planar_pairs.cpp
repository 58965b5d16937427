// SPDX-License-Identifier: Apache-2.0
#include "area_light/planar_pairs.h"

#include <algorithm>

namespace gnomon::area_light {

namespace {

using visibility::no_triangle;
using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

constexpr double k_flat = 1e-6;         // largest distance from the plane, per largest coordinate or diameter
constexpr double k_least_turn = 1e-3;   // least sine at a corner

// The quadrilateral of a triangle and its neighbour at an edge, or false if it is not planar and convex.
bool join(const StaticTriangle& a, int edge, const StaticTriangle& b, glm::vec3 (&quad)[4])
{
    const glm::vec3 &from = a.p[edge], &to = a.p[(edge + 1) % 3];
    int apex = -1;
    for (int k = 0; k < 3; ++k)
        if (b.p[k] != from && b.p[k] != to) {
            if (apex >= 0) return false;
            apex = k;
        }
    if (apex < 0) return false;
    quad[0] = a.p[(edge + 2) % 3], quad[1] = from, quad[2] = b.p[apex], quad[3] = to;
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(quad[1]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[0]));
    const double length = glm::length(normal);
    if (!(length > 0)) return false;
    const double room =
        k_flat * static_cast<double>(std::max(visibility::largest_coordinate(a), visibility::largest_coordinate(b)));
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

PlanarPairs::PlanarPairs(const StaticTriangles& triangles) : partner_(triangles.size(), no_triangle)
{
    glm::vec3 quad[4];
    for (TriangleId id = 0; id < triangles.size(); ++id)
        for (int edge = 0; edge < 3 && partner_[id] == no_triangle; ++edge) {
            const TriangleId next = triangles.across(id, edge);
            if (next == no_triangle || next <= id || partner_[next] != no_triangle) continue;
            if (join(triangles[id], edge, triangles[next], quad)) partner_[id] = next, partner_[next] = id;
        }
}

void PlanarPairs::gather(const StaticTriangles& triangles, std::span<const TriangleId> ids, TriangleList& list) const
{
    list.clear();
    for (const TriangleId id : ids) {
        const TriangleId other = partner_[id];
        if (other == no_triangle || !std::binary_search(ids.begin(), ids.end(), other)) {
            list.push(triangles[id].p);
            continue;
        }
        if (other < id) continue;
        glm::vec3 quad[4];
        for (int edge = 0; edge < 3; ++edge)
            if (triangles.across(id, edge) == other && join(triangles[id], edge, triangles[other], quad)) {
                list.push(quad);
                break;
            }
    }
    list.pad();
}

}   // namespace gnomon::area_light
