// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified/certificates.h"

#include <algorithm>
#include <array>

namespace gnomon::shadow_culling {

namespace {

// Whether a neighbour lies, seen from the light, on the other side of the edge a-b than the triangle with corner c, so
// that the edge is no silhouette. Uses corners instead of windings, because not all meshes are wound consistently.
bool continues_behind(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const StaticTriangle& neighbour,
                      const visibility::LightPoint& light)
{
    const glm::dvec3 edge_plane = glm::cross(b - a, light.directional ? light.place : light.place - a);
    const double own = glm::dot(edge_plane, c - a);
    double other =
        0;   // of the neighbour's corner that is not on the edge, that is, of the one furthest from the plane
    for (const glm::vec3& corner : neighbour.p) {
        const glm::dvec3 q(corner);
        if (q == a || q == b) continue;
        const double at = glm::dot(edge_plane, q - a);
        if (std::abs(at) > std::abs(other)) other = at;
    }
    return (own > 0 && other < 0) || (own < 0 && other > 0);
}

// The ratio of the error of a triangle's traced plane to its lateral error: the longest side over the height. (The
// slope of the triangle relative to the rays is covered by the shaft's margin: a steep one spans much height within
// it.)
double thinness(const glm::dvec3 (&p)[3])
{
    double longest = 0;
    for (int c = 0; c < 3; ++c) longest = std::max(longest, glm::length(p[(c + 1) % 3] - p[c]));
    return longest * longest / glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

}   // namespace

bool certify_none(const StaticTriangles& triangles, const visibility::Shaft& shaft, const CertificateOptions& options)
{
    if (!shaft.valid()) return false;
    return options.left_out.has(Check::nothing_in_shaft) || !triangles.any_in(shaft);
}

bool certify_full(const StaticTriangles& triangles, const visibility::Shaft& shaft, TriangleId occluder,
                  const CertificateOptions& options)
{
    if (!shaft.valid()) return false;
    constexpr int k_capacity = 256;
    std::array<TriangleId, k_capacity> patch;
    const int most = std::min(options.max_patch, k_capacity);
    int count = 0;
    patch[static_cast<std::size_t>(count++)] = occluder;

    const double end = shaft.light_height() * (1 - options.end_gap);
    for (int next = 0; next < count; ++next) {
        const TriangleId id = patch[static_cast<std::size_t>(next)];
        const StaticTriangle& t = triangles[id];
        const glm::dvec3 p[3] = {glm::dvec3(t.p[0]), glm::dvec3(t.p[1]), glm::dvec3(t.p[2])};
        const double coordinate = largest_coordinate(t);
        const visibility::ShaftRoom room = shaft.room_for(coordinate);

        // The part in the shaft must lie strictly between receiver and light.
        visibility::ClippedPolygon inside;
        if (!shaft.clip(p, room, inside)) {
            if (next == 0 && !options.left_out.has(Check::occluder_in_way)) return false;
            continue;
        }
        const double gap = options.clearance * shaft.lift_for(coordinate) * thinness(p);
        for (int c = 0; c < inside.count; ++c) {
            const double height = shaft.height(inside.corner[static_cast<std::size_t>(c)]);
            if (!(height > shaft.lift() + gap) || !(height < end - gap)) return false;
        }

        // Continue over every edge that intersects the shaft.
        for (int e = 0; e < 3; ++e) {
            if (!shaft.meets_segment(p[e], p[(e + 1) % 3], room)) continue;
            const TriangleId neighbour = triangles.across(id, e);
            if (neighbour == no_triangle) {
                if (options.left_out.has(Check::no_open_edge)) continue;
                return false;
            }
            if (!options.left_out.has(Check::no_silhouette) &&
                !continues_behind(p[e], p[(e + 1) % 3], p[(e + 2) % 3], triangles[neighbour], shaft.light()))
                return false;
            if (std::find(patch.begin(), patch.begin() + count, neighbour) != patch.begin() + count) continue;
            if (count >= most) return false;
            patch[static_cast<std::size_t>(count++)] = neighbour;
        }
    }
    return true;
}

}   // namespace gnomon::shadow_culling
