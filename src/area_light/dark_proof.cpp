// SPDX-License-Identifier: Apache-2.0
#include "area_light/dark_proof.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace gnomon::area_light {

namespace {

using visibility::no_triangle;
using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

// Whether the neighbour across an edge has the same orientation: it goes along the edge in the other direction.
bool agrees(const StaticTriangle& a, int edge, const StaticTriangle& b)
{
    const glm::vec3 &from = a.p[edge], &to = a.p[(edge + 1) % 3];
    for (int e = 0; e < 3; ++e)
        if (b.p[e] == to && b.p[(e + 1) % 3] == from) return true;
    return false;
}

}   // namespace

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

bool proves_dark(const StaticTriangles& triangles, const AreaShaft& shaft, TriangleId occluder, const glm::dvec3& from,
                 const glm::dvec3& to, const DarkOptions& options)
{
    const auto leaves_out = [&](DarkCheck check) { return options.left_out == check; };
    if (triangles.role(occluder) != StaticTriangles::Role::opaque) return false;
    std::unordered_map<TriangleId, int> sign{{occluder, 1}};
    std::vector<TriangleId> patch{occluder};
    int net = 0;
    for (std::size_t next = 0; next < patch.size(); ++next) {
        const TriangleId id = patch[next];
        const StaticTriangle& t = triangles[id];
        const int own = sign.at(id);
        const double coordinate = static_cast<double>(visibility::largest_coordinate(t));

        // Keep clear of the ends of all segments.
        ClippedTriangle inside;
        if (shaft.clip(t, inside)) {
            const double clear = options.clearance * shaft.lift_for(coordinate);
            for (int c = 0; c < inside.count; ++c) {
                const glm::dvec3& p = inside.corner[static_cast<std::size_t>(c)];
                if (shaft.height(p) < clear && !leaves_out(DarkCheck::clear_of_part)) return false;
                if (shaft.light_height(p) < shaft.most_end_gap() + clear && !leaves_out(DarkCheck::clear_of_light))
                    return false;
            }
        }
        net += leaves_out(DarkCheck::signs) ? std::abs(crossing(t, from, to)) : own * crossing(t, from, to);

        // Go on over the edges in the shaft.
        for (int e = 0; e < 3; ++e) {
            const glm::dvec3 a(t.p[e]), b(t.p[(e + 1) % 3]);
            if (!shaft.meets_segment(a, b, coordinate)) continue;
            const TriangleId other = triangles.across(id, e);
            if (other == no_triangle) {
                if (leaves_out(DarkCheck::no_open_edge)) continue;
                return false;
            }
            const int its = agrees(t, e, triangles[other]) ? own : -own;
            const auto [at, is_new] = sign.try_emplace(other, its);
            if (!is_new) {
                if (at->second != its) return false;   // the patch has no two sides
                continue;
            }
            if (patch.size() >= static_cast<std::size_t>(options.most_triangles)) return false;
            patch.push_back(other);
        }
    }
    return net != 0 || leaves_out(DarkCheck::crosses);
}

}   // namespace gnomon::area_light
