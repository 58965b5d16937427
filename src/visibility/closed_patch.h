// SPDX-License-Identifier: Apache-2.0
#pragma once
// Proves that connected static triangles block every segment of a convex region (a shaft).
//
// The patch grows from one triangle over every edge that meets the shaft. If each of these edges leads on to another
// opaque triangle, the patch has no border inside the shaft. If it also keeps clear of the ends of all segments, no
// segment can be moved off the patch: the number of times that a segment crosses it, counted with the sides' signs, is
// the same for all. So if it is not 0 for one segment, the patch blocks them all. A patch may be folded; its triangles
// need not face the light.
//
// Cost: some tenths of a microsecond for each triangle of the patch.

#include <unordered_map>
#include <vector>

#include "visibility/static_triangles.h"

namespace gnomon::visibility {

/// Whether a segment crosses a triangle: 1 from its front to its back, -1 the other way, 0: it does not.
int crossing(const StaticTriangle& triangle, const glm::dvec3& from, const glm::dvec3& to);
/// Whether the neighbour across an edge has the same orientation: it goes along the edge in the other direction.
bool agrees(const StaticTriangle& a, int edge, const StaticTriangle& b);

struct PatchOptions {
    int most_triangles = 128;
    // Of the checks, for tests: false leaves one out.
    bool no_open_edge = true;
    bool signs = true;
    bool crosses = true;
};

/// @param shaft     has meets_segment(a, b, coordinate), as visibility/shaft.h explains
/// @param is_clear  of a triangle and its largest coordinate: whether what of it is in the shaft keeps clear of the
/// ends
/// @param occluder  an opaque static triangle that the segment crosses
/// @param from, to  any segment of the shaft
template <class Region, class Clear>
bool closes(const StaticTriangles& triangles, const Region& shaft, const Clear& is_clear, TriangleId occluder,
            const glm::dvec3& from, const glm::dvec3& to, const PatchOptions& options)
{
    if (triangles.role(occluder) != StaticTriangles::Role::opaque) return false;
    std::unordered_map<TriangleId, int> sign{{occluder, 1}};
    std::vector<TriangleId> patch{occluder};
    int net = 0;
    for (std::size_t next = 0; next < patch.size(); ++next) {
        const TriangleId id = patch[next];
        const StaticTriangle& t = triangles[id];
        const int own = sign.at(id);
        const double coordinate = static_cast<double>(largest_coordinate(t));

        // Keep clear of the ends of all segments.
        if (!is_clear(t, coordinate)) return false;
        net += options.signs ? own * crossing(t, from, to) : std::abs(crossing(t, from, to));

        // Go on over the edges in the shaft.
        for (int e = 0; e < 3; ++e) {
            const glm::dvec3 a(t.p[e]), b(t.p[(e + 1) % 3]);
            if (!shaft.meets_segment(a, b, coordinate)) continue;
            const TriangleId other = triangles.across(id, e);
            if (other == no_triangle) {
                if (!options.no_open_edge) continue;
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
    return net != 0 || !options.crosses;
}

}   // namespace gnomon::visibility
