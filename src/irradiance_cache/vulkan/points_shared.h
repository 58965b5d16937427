// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_IRRADIANCE_CACHE_POINTS_SHARED_H
#define GNOMON_IRRADIANCE_CACHE_POINTS_SHARED_H
// The emitters' tree and surface points as shaders see them. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(irradiance_cache)

// Invocations that work on one point together: those of eight quads.
#define GNOMON_POINT_LANES 32
// Nodes of a cut that there is room for; longer ones are the processor's.
#define GNOMON_CUT_ROOM 1024
// As point_kernels.h.
#define GNOMON_WEIGHT_BITS 14
#define GNOMON_WEIGHT_SHIFT 16
#define GNOMON_WEIGHT_BIAS (63u << 23)

/// As EmitterQuad.
struct GpuQuad {
    float x[4], y[4], z[4];
    float radius[4];
    float nx[4], ny[4], nz[4];
    float area[4];
    float flux[4];
};

/// As CutRequest.
struct GpuCutRequest {
    vec3 origin;
    float error;
    vec3 normal;
    float estimate;
};

/// Of one point: where its cut begins, and its length, perhaps more than there is room for.
struct GpuCut {
    uint first, count;
};
struct GpuCutNode {
    uint node;
    float weight;
};

/// As MovingSpheres::Node.
struct GpuMovingSphere {
    vec3 centre;
    float radius;
    uint next, single;
};

struct GpuSumRequest {
    vec3 origin;
    uint first, count;   // in the store
};

/// By colour.
struct GpuPointLight {
    vec3 r, g, b;
};

/// As PointSums::Crossed.
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
