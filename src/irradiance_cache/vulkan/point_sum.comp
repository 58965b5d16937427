// SPDX-License-Identifier: Apache-2.0
#version 460
// Sums the present light of a point's visible nodes, by a work group. Nodes whose path crosses the bounds of a dynamic
// object are listed instead. The reference implementation is sum_seen() and find_changed() in
// src/irradiance_cache/light_tree/point_kernels.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "irradiance_cache/vulkan/points_shared.h"

layout(local_size_x = GNOMON_POINT_LANES) in;
layout(binding = 0, scalar) readonly buffer Places { vec4 at[]; } places;
layout(binding = 1, scalar) readonly buffer Flux { vec3 at[]; } flux;   // by node
layout(binding = 2, scalar) readonly buffer Store { uint at[]; } store;
layout(binding = 3, scalar) readonly buffer Spheres { GpuMovingSphere at[]; } spheres;
layout(binding = 4, scalar) readonly buffer Requests { GpuSumRequest at[]; } requests;
layout(binding = 5, scalar) writeonly buffer Lights { GpuPointLight at[]; } lights;
layout(binding = 6, scalar) buffer Count { uint crossed; } count;
layout(binding = 7, scalar) writeonly buffer Crossed { GpuCrossed at[]; } crossed;
layout(push_constant, scalar) uniform Push { PointSumPush push; };

const float k_tiny = 1e-30;
shared GpuPointLight sums[GNOMON_POINT_LANES];

bool passes_dynamic(vec3 origin, vec3 way)
{
    const float inverse = 1 / max(dot(way, way), k_tiny);
    for (uint m = 0; m < push.spheres;) {
        const vec3 centre = spheres.at[m].centre - origin;
        const float along = clamp(dot(centre, way) * inverse, 0, 1);
        const vec3 off = centre - along * way;
        const float radius = spheres.at[m].radius;
        const bool met = dot(off, off) <= radius * radius;
        if (met && spheres.at[m].single != 0) return true;
        m = met ? m + 1 : spheres.at[m].next;
    }
    return false;
}

void main()
{
    const uint point = gl_WorkGroupID.x, lane = gl_LocalInvocationID.x;
    const GpuSumRequest request = requests.at[point];
    GpuPointLight light = GpuPointLight(vec3(0), vec3(0), vec3(0));
    for (uint k = lane; k < request.count; k += GNOMON_POINT_LANES) {
        const uint seen = store.at[request.first + k];
        const uint node = seen >> GNOMON_WEIGHT_BITS;
        const vec3 arriving = flux.at[node];
        if (arriving == vec3(0)) continue;
        const vec3 way = places.at[node].xyz - request.origin;
        if (passes_dynamic(request.origin, way)) {
            const uint at = atomicAdd(count.crossed, 1);
            if (at < push.most_crossed) crossed.at[at] = GpuCrossed(point, k, seen);
            continue;
        }
        const uint code = seen & ((1u << GNOMON_WEIGHT_BITS) - 1);
        const float weight = uintBitsToFloat((code << GNOMON_WEIGHT_SHIFT) + GNOMON_WEIGHT_BIAS);
        const vec3 direction = way * (weight / sqrt(max(dot(way, way), k_tiny)));
        light.r += arriving.x * direction;
        light.g += arriving.y * direction;
        light.b += arriving.z * direction;
    }
    sums[lane] = light;
    barrier();
    if (lane >= 3) return;
    vec3 sum = vec3(0);   // of one colour, in a fixed order
    for (uint i = 0; i < GNOMON_POINT_LANES; ++i) sum += lane == 0 ? sums[i].r : lane == 1 ? sums[i].g : sums[i].b;
    if (lane == 0) lights.at[point].r = sum;
    if (lane == 1) lights.at[point].g = sum;
    if (lane == 2) lights.at[point].b = sum;
}
