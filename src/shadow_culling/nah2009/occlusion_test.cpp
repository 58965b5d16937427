// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/occlusion_test.h"

#include "base/check.h"

namespace gnomon::shadow_culling {

bool intersects(const glm::vec3& origin, const glm::vec3& direction, const glm::vec3 (&triangle)[3])
{
    const glm::vec3 e1 = triangle[1] - triangle[0], e2 = triangle[2] - triangle[0];
    const glm::vec3 p = glm::cross(direction, e2);
    const float det = glm::dot(e1, p);
    if (!(det != 0)) return false;
    const glm::vec3 s = origin - triangle[0];
    const float u = glm::dot(s, p) / det;
    if (!(u >= 0 && u <= 1)) return false;
    const glm::vec3 q = glm::cross(s, e1);
    const float v = glm::dot(direction, q) / det;
    return v >= 0 && u + v <= 1 && glm::dot(e2, q) / det >= 0;
}

OcclusionTestCounts test_occlusion(std::span<const PrimaryHit> hits, std::span<const PrimaryHit> above, bool last_row,
                                   const SceneTriangles& triangles, Modes& modes, const OcclusionTestOptions& options)
{
    GNOMON_CHECK(above.empty() || above.size() == hits.size());
    OcclusionTestCounts counts;

    // The mode that the paper would find at this pixel: this frame's mark, else the mode of the frame's beginning.
    const auto is_init = [&](PrimitiveId primitive) {
        return modes.occlusion(primitive) == OcclusionMode::init &&
               (options.test_marked || modes.marked(primitive) == OcclusionMode::init);
    };

    for (std::size_t x = 0; x < hits.size(); ++x) {
        const PrimaryHit& current = hits[x];
        // DEVIATION(Nah 2009, Table 1): the listing has no case for a ray that hits nothing; no test then.
        if (current.primitive == no_primitive) continue;

        // Dynamic triangles are never remembered.
        if (triangles.is_dynamic(current.primitive)) {
            modes.mark(current.primitive, OcclusionMode::dynamic);
            continue;
        }
        // A triangle at the border of the screen was not seen whole in this frame, even if it was before.
        if (above.empty() || last_row || x == 0 || x + 1 == hits.size()) {
            modes.mark(current.primitive, OcclusionMode::partially_occluded);
            continue;
        }
        // Test whether the neighbour's triangle continues behind this pixel.
        const PrimitiveId left = hits[x - 1].primitive, upper = above[x].primitive;
        for (const PrimitiveId reference : {left, upper}) {
            if (reference == no_primitive || reference == current.primitive) continue;
            if (!is_init(reference)) continue;
            ++counts.extra_tests;
            glm::vec3 corners[3];
            triangles.corners(reference, corners);
            if (intersects(current.origin, current.direction, corners))
                modes.mark(reference, OcclusionMode::partially_occluded);
            // DEVIATION(Nah 2009, Table 1): one test where both neighbours show one triangle, as in Fig. 3; the printed
            // listing repeats it.
            if (left == upper) break;
        }
    }
    return counts;
}

std::uint64_t test_occlusion_now(const PrimaryHit& current, PrimitiveId left, PrimitiveId upper, bool edge,
                                 const SceneTriangles& triangles, Modes& modes)
{
    // DEVIATION(Nah 2009, Table 1): the listing has no case for a ray that hits nothing; no test then.
    if (current.primitive == no_primitive) return 0;
    // Lines 1 to 3.
    if (triangles.is_dynamic(current.primitive)) {
        modes.set_occlusion(current.primitive, OcclusionMode::dynamic);
        return 0;
    }
    // Lines 4 to 6.
    if (edge) {
        modes.set_occlusion(current.primitive, OcclusionMode::partially_occluded);
        return 0;
    }
    // Lines 8 to 15, and again for line 17. Where both neighbours show one triangle, a test that succeeds has set its
    // mode, so that line 9 prevents the second, as Fig. 3 has it; a test that fails is repeated.
    std::uint64_t extra_tests = 0;
    for (const PrimitiveId reference : {left, upper}) {
        if (reference == no_primitive || modes.occlusion(reference) != OcclusionMode::init) continue;
        if (reference == current.primitive) continue;
        ++extra_tests;
        glm::vec3 corners[3];
        triangles.corners(reference, corners);
        if (intersects(current.origin, current.direction, corners))
            modes.set_occlusion(reference, OcclusionMode::partially_occluded);
    }
    return extra_tests;
}

}   // namespace gnomon::shadow_culling
