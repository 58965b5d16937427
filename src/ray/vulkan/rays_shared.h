// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_RAY_RAYS_SHARED_H
#define GNOMON_RAY_RAYS_SHARED_H
// Rays on the device, as shaders see them. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(ray)

/// One geometry of a bottom level: a run of a mesh's triangles, of one material where that decides on holes.
struct GpuRayGeometry {
    uint first_triangle;   // of the mesh
    uint material;
};

/// Of tracing a queue, whose arrays lie one after the other: origin x, y, z, near end, direction x, y, z, far end.
struct RayPush {
    uint count;
    uint apart;    // floats from one array to the next
    uint mask;     // of instances that are asked
    float reach;   // rays from beyond, or of longer directions, meet nothing: k_largest_coordinate
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
