// SPDX-License-Identifier: Apache-2.0
#pragma once
// Certificates: proofs about all shadow rays from a part of a triangle at once.
//
//   NONE  no static triangle intersects the shaft to the light: every ray is free.
//   FULL  one connected patch of static triangles closes the shaft's cross-section: every ray is occluded. The patch is
//         flooded from a known occluder over every edge that intersects the shaft; each such edge must be shared by
//         exactly two triangles and must not be a silhouette seen from the light. Then the patch, projected from the
//         light, covers the cross-section, because its border cannot lie inside.
//
// The receiver is tested like any other triangle; it lies below its own shaft. A failed proof implies nothing. Cost per
// proof: a few microseconds (a tree traversal with a tetrahedron, or up to `max_patch` triangles).

#include "visibility/checks.h"
#include "visibility/shaft.h"
#include "visibility/static_triangles.h"

namespace gnomon::shadow_culling {

using visibility::Check;
using visibility::LeftOut;
using visibility::no_triangle;
using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

struct CertificateOptions {
    visibility::ShaftRules shaft;
    int max_patch = 64;   // triangles of a FULL patch
    double clearance =
        4;   // least distance, in lifts, from a FULL patch to both ends of the rays; more where it is thin
    double end_gap = 1e-3;     // occluders this near the light, as a fraction of its height, prove nothing
    double graze_lifts = 50;   // nothing is certified for a light nearer than this to the receiver's plane, in lifts
    LeftOut left_out;          // for tests
};

/// Proves NONE: no static occluder intersects the shaft.
bool certify_none(const StaticTriangles& triangles, const visibility::Shaft& shaft, const CertificateOptions& options);

/// Proves FULL: the patch around `occluder` closes the shaft. The triangles of a patch are opaque, because across()
/// returns no others.
/// @param occluder   an opaque static triangle that the ray from the part's centroid to the light hits
bool certify_full(const StaticTriangles& triangles, const visibility::Shaft& shaft, TriangleId occluder,
                  const CertificateOptions& options);

}   // namespace gnomon::shadow_culling
