// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_RAY_RAYS_SHARED_H
#define GNOMON_RAY_RAYS_SHARED_H
// Structures of the ray-tracing shaders. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(ray)

/// One geometry of a BLAS: a run of a mesh's triangles, of one material if that has holes.
struct GpuRayGeometry {
    uint first_triangle;   // of the mesh
    uint material;
};

/// Push constants for a queue of rays, whose arrays follow each other: origin x, y, z, near end, direction x, y, z, far
/// end.
struct RayPush {
    uint count;
    uint apart;    // floats from one array to the next
    uint mask;     // of instances that are tested
    float reach;   // rays with larger coordinates or directions hit nothing: k_largest_coordinate
};

// Instance masks.
#define GNOMON_RAYS_STATIC 1u
#define GNOMON_RAYS_DYNAMIC 2u

#ifdef __cplusplus
GNOMON_MEMBERS(GpuRayGeometry, first_triangle, material)
GNOMON_MEMBERS(RayPush, count, apart, mask, reach)
#endif

GNOMON_SHARED_END
#endif
