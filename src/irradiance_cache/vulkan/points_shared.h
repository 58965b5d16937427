// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_IRRADIANCE_CACHE_POINTS_SHARED_H
#define GNOMON_IRRADIANCE_CACHE_POINTS_SHARED_H
// The light tree and cache points as shaders see them. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(irradiance_cache)

// Invocations per point: one for each node of eight quads.
#define GNOMON_POINT_LANES 32
// Room for the nodes of a cut; longer cuts are made by the CPU.
#define GNOMON_CUT_ROOM 4096
// The packing of visible nodes, as in point_kernels.h.
#define GNOMON_WEIGHT_BITS 14
#define GNOMON_WEIGHT_SHIFT 16
#define GNOMON_WEIGHT_BIAS (63u << 23)

/// Same layout as VirtualLightQuad.
struct GpuQuad {
    float x[4], y[4], z[4];
    float radius[4];
    float nx[4], ny[4], nz[4];
    float area[4];
    float flux[4];
};

/// Same layout as CutRequest.
struct GpuCutRequest {
    vec3 origin;
    float error;
    vec3 normal;
    float estimate;
};

/// Where the cut of a point begins, and its length, which may exceed the room for it.
struct GpuCut {
    uint first, count;
};
struct GpuCutNode {
    uint node;
    float weight;
};

/// A MovingSpheres::Node.
struct GpuMovingSphere {
    vec3 centre;
    float radius;
    uint next, single;
};

struct GpuSumRequest {
    vec3 origin;
    uint first, count;   // in the store
};

/// Summed light by colour.
struct GpuPointLight {
    vec3 r, g, b;
};

/// Same layout as PointSums::Crossed.
struct GpuCrossed {
    uint point, place, seen;
};

/// A node and its present flux.
struct GpuNodeFlux {
    uint node;
    vec3 flux;
};

struct PointCutPush {
    uint points, roots;
    float nearest, negligible;
};

struct PointSumPush {
    uint points, spheres, most_crossed, unused;
};

struct PointFluxPush {
    uint count;
};

#ifdef __cplusplus
GNOMON_MEMBERS(GpuQuad, x, y, z, radius, nx, ny, nz, area, flux)
GNOMON_MEMBERS(GpuCutRequest, origin, error, normal, estimate)
GNOMON_MEMBERS(GpuCut, first, count)
GNOMON_MEMBERS(GpuCutNode, node, weight)
GNOMON_MEMBERS(GpuMovingSphere, centre, radius, next, single)
GNOMON_MEMBERS(GpuSumRequest, origin, first, count)
GNOMON_MEMBERS(GpuPointLight, r, g, b)
GNOMON_MEMBERS(GpuCrossed, point, place, seen)
GNOMON_MEMBERS(GpuNodeFlux, node, flux)
GNOMON_MEMBERS(PointCutPush, points, roots, nearest, negligible)
GNOMON_MEMBERS(PointSumPush, points, spheres, most_crossed, unused)
GNOMON_MEMBERS(PointFluxPush, count)
#endif

GNOMON_SHARED_END
#endif
