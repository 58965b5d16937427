// SPDX-License-Identifier: Apache-2.0
#include "area_light/dark_proof.h"

#include <algorithm>

namespace gnomon::area_light {

bool proves_dark(const visibility::StaticTriangles& triangles, const AreaShaft& shaft, visibility::TriangleId occluder,
                 const glm::dvec3& from, const glm::dvec3& to, const DarkOptions& options)
{
    const auto makes = [&](DarkCheck check) { return options.left_out != check; };
    const auto is_clear = [&](const visibility::StaticTriangle& t, double coordinate) {
        const double clear = options.clearance * shaft.lift_for(coordinate);
        // What a triangle keeps clear of, its part inside does.
        const auto keeps_clear = [&](const glm::vec3& corner) {
            const glm::dvec3 p(corner);
            return shaft.height(p) >= clear && shaft.light_height(p) >= shaft.most_end_gap() + clear;
        };
        if (std::ranges::all_of(t.p, keeps_clear)) return true;
        ClippedTriangle inside;
        if (!shaft.clip(t, inside)) return true;
        for (int c = 0; c < inside.count; ++c) {
            const glm::dvec3& p = inside.corner[static_cast<std::size_t>(c)];
            if (shaft.height(p) < clear && makes(DarkCheck::clear_of_part)) return false;
            if (shaft.light_height(p) < shaft.most_end_gap() + clear && makes(DarkCheck::clear_of_light)) return false;
        }
        return true;
    };
    return visibility::closes(
        triangles, shaft, is_clear, occluder, from, to,
        {options.most_triangles, makes(DarkCheck::no_open_edge), makes(DarkCheck::signs), makes(DarkCheck::crosses)});
}

}   // namespace gnomon::area_light
