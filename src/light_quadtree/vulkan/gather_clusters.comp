// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Bounced light by the quad-tree: every receiver gathers the same list of clusters.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "light_quadtree/vulkan/map_shared.h"

layout(binding = 0, scalar) readonly buffer Counts { uint at[]; } counts;
layout(binding = 1, rgba32f) uniform readonly image2D clusters;  // GpuCluster, three texels per cluster
layout(push_constant, scalar) uniform Push { GatherPush push; };
#include "light_quadtree/vulkan/kernel.glsl"
#define GNOMON_ACROSS GNOMON_CLUSTERS_ACROSS
#define GNOMON_DOWN GNOMON_CLUSTERS_DOWN
#define GNOMON_TOGETHER (GNOMON_ACROSS * GNOMON_DOWN)
#define GNOMON_IMAGES 2

void all_light(vec3 at[GNOMON_TOGETHER], vec3 normal[GNOMON_TOGETHER], inout vec3 sum[GNOMON_TOGETHER])
{
    const uint count = counts.at[push.total];
    for (uint c = 0; c < count; ++c) {
        const ivec2 place = ivec2(3 * (c % GNOMON_CLUSTERS_A_ROW), c / GNOMON_CLUSTERS_A_ROW);
        const vec4 a = imageLoad(clusters, place), b = imageLoad(clusters, place + ivec2(1, 0));
        const vec3 power = vec3(b.w, imageLoad(clusters, place + ivec2(2, 0)).xy);
        [[unroll]] for (int i = 0; i < GNOMON_TOGETHER; ++i)
            add_light(a.xyz, b.xyz, a.w, power, at[i], normal[i], sum[i]);
    }
}
#include "light_quadtree/vulkan/gather.glsl"
