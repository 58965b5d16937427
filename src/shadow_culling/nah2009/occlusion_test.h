// SPDX-License-Identifier: Apache-2.0
#pragma once
// The occlusion test of shadow culling [Nah 2009, 2.3, Table 1].
//
// A primitive's remembered shadow is reliable only if all of it was seen. This step finds, among the primary hits, the
// primitives that others partly hide: if a pixel's ray would also hit the triangle of its left or upper neighbour, the
// neighbour's triangle continues behind this pixel.
//
// Cost: 0 to 2 ray-triangle tests per pixel, only along primitive borders (counted: extra_tests).
// One-sided by design: an occluder of a triangle's left or upper part is not noticed.

#include <span>

#include "shadow_culling/nah2009/modes.h"
#include "shadow_culling/nah2009/scene_triangles.h"

namespace gnomon::shadow_culling {

/// The hit of one pixel's primary ray.
struct PrimaryHit {
    PrimitiveId primitive = no_primitive;   // no_primitive: nothing was hit
    glm::vec3 origin{0}, direction{0};      // of the ray
};

struct OcclusionTestOptions {
    // Also tests neighbours that are already marked in this frame, as if all modes were read as of the frame's
    // beginning. The marks are the same; extra_tests is larger.
    bool test_marked = false;
};

struct OcclusionTestCounts {
    std::uint64_t extra_tests = 0;   // ray-triangle tests beyond those of plain ray tracing
};

/// Runs the test for one pixel, and writes the modes themselves at once, as Table 1 is printed: what is set here is
/// read by the next pixel, and by the shadow test of this one. Pixels must come in scanline order.
/// @param left, upper  the primitives of the pixel's left and upper neighbours
/// @param edge         whether the pixel lies on the edge of the screen
/// @return the extra ray-triangle tests
std::uint64_t test_occlusion_now(const PrimaryHit& current, PrimitiveId left, PrimitiveId upper, bool edge,
                                 const SceneTriangles& triangles, Modes& modes);

/// Runs the test for one row of primary hits. Rows must come from top to bottom, because triangles marked above are not
/// tested again below.
/// @param hits      this row, left to right
/// @param above     the row above, same length; empty for the first row
/// @param last_row  whether this row is the screen's lower edge
/// @param modes     receives marks, which this test reads at once, and the shadow test from the next frame on
OcclusionTestCounts test_occlusion(std::span<const PrimaryHit> hits, std::span<const PrimaryHit> above, bool last_row,
                                   const SceneTriangles& triangles, Modes& modes,
                                   const OcclusionTestOptions& options = {});

/// Whether a ray hits a triangle at t >= 0, borders included [Moller and Trumbore 1997].
bool intersects(const glm::vec3& origin, const glm::vec3& direction, const glm::vec3 (&triangle)[3]);

}   // namespace gnomon::shadow_culling
