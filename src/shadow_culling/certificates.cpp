// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certificates.h"

#include <algorithm>
#include <array>

namespace gnomon::shadow_culling {

bool certify_none(const StaticTriangles& triangles, const Shaft& shaft, TriangleId receiver)
{
    return shaft.valid() && !triangles.any_in(shaft, receiver);
}

bool certify_full(const StaticTriangles& triangles, const Shaft& shaft, TriangleId receiver, TriangleId occluder,
                  double clearance, const CertificateOptions& options)
{
    if (!shaft.valid()) return false;
    constexpr int k_capacity = 256;
    std::array<TriangleId, k_capacity> patch;
    const int most = std::min(options.max_patch, k_capacity);
    int count = 0;
    patch[static_cast<std::size_t>(count++)] = occluder;

    const LightPoint& light = shaft.light();
    const double highest =
        light.directional ? std::numeric_limits<double>::infinity() : shaft.light_height() * (1 - options.end_gap);
    int orientation = 0;
    for (int next = 0; next < count; ++next) {
        const TriangleId id = patch[static_cast<std::size_t>(next)];
        if (id == receiver || triangles.role(id) != StaticTriangles::Role::opaque) return false;
        const StaticTriangle& t = triangles[id];
        const glm::dvec3 p[3] = {glm::dvec3(t.p[0]), glm::dvec3(t.p[1]), glm::dvec3(t.p[2])};

        // Refuse triangles edge-on to the light, and a change of side: that edge is a silhouette.
        const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
        const glm::dvec3 to_light = light.directional ? light.place : light.place - p[0];
        const double facing = glm::dot(n, to_light);
        if (!(std::abs(facing) > options.min_facing * glm::length(n) * glm::length(to_light))) return false;
        const int side = facing > 0 ? 1 : -1;
        if (orientation == 0) orientation = side;
        if (side != orientation) return false;

        // What lies in the shaft must lie strictly between receiver and light.
        ClippedPolygon inside;
        if (!shaft.clip(p, inside)) {
            if (next == 0) return false;   // the occluder itself must be in the way
            continue;
        }
        for (int c = 0; c < inside.count; ++c) {
            const double height = shaft.height(inside.corner[static_cast<std::size_t>(c)]);
            if (!(height > clearance) || !(height < highest)) return false;
        }

        // Go on over every edge that meets the shaft.
        for (int e = 0; e < 3; ++e) {
            if (!shaft.meets_segment(p[e], p[(e + 1) % 3])) continue;
            const TriangleId neighbour = triangles.across(id, e);
            if (neighbour == no_triangle) return false;
            if (std::find(patch.begin(), patch.begin() + count, neighbour) != patch.begin() + count) continue;
            if (count >= most) return false;
            patch[static_cast<std::size_t>(count++)] = neighbour;
        }
    }
    return true;
}

}   // namespace gnomon::shadow_culling
