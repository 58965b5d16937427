// SPDX-License-Identifier: Apache-2.0
#pragma once
// Proofs about all shadow rays from a piece of a triangle at once.
//
//   NONE  no static triangle meets the shaft to the light: every ray is free.
//   FULL  one connected patch of static triangles closes the shaft's cross-section: every ray is occluded. The patch is
//         flooded from a triangle known to be in the way, over every edge that meets the shaft; each such edge must be
//         shared by exactly two triangles and not be a silhouette seen from the light. Then the patch, projected from
//         the light, covers the cross-section: its edge cannot lie inside.
// The receiver is a triangle like any other: it lies below its own shaft. A failed proof says nothing. Cost of one: a
// few microseconds (a tree walk with a tetrahedron, or up to `max_patch` triangles).

#include "shadow_culling/certified/checks.h"
#include "shadow_culling/certified/static_triangles.h"
#include "visibility/shaft.h"

namespace gnomon::shadow_culling {

struct CertificateOptions {
    visibility::ShaftRules shaft;
    int max_patch = 64;        // triangles of a FULL patch
    double clearance = 4;      // lifts that a FULL patch keeps from where rays start and end; more where it is thin
    double end_gap = 1e-3;     // occluders this near the light, as a fraction of its height, prove nothing
    double graze_lifts = 50;   // a light this near to the receiver's plane grazes it: nothing is certified
    LeftOut left_out;          // for tests
};

/// No static blocker meets the shaft.
bool certify_none(const StaticTriangles& triangles, const visibility::Shaft& shaft, const CertificateOptions& options);

/// The patch around `occluder` closes the shaft. The triangles of a patch are opaque: across() leads to no others.
/// @param occluder   an opaque static triangle that the ray from the piece's centroid to the light meets
bool certify_full(const StaticTriangles& triangles, const visibility::Shaft& shaft, TriangleId occluder,
                  const CertificateOptions& options);

}   // namespace gnomon::shadow_culling
