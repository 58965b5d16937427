// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Bounced light by sampling the map about the receiver's own place in it [Dachsbacher and Stamminger 2005, 4.2]. As
// rsm.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "light_quadtree/vulkan/map_shared.h"

layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, scalar) readonly buffer Nodes { GpuNode at[]; } nodes;
layout(binding = 2, scalar) readonly buffer Pattern { GpuSample at[]; } pattern;
layout(push_constant, scalar) uniform Push { GatherPush push; };
#include "light_quadtree/vulkan/kernel.glsl"
#include "light_quadtree/vulkan/map_nodes.glsl"
#define GNOMON_ACROSS 1
#define GNOMON_DOWN 1
#define GNOMON_TOGETHER 1   // each pixel has samples of its own
#define GNOMON_IMAGES 3

void all_light(vec3 at[GNOMON_TOGETHER], vec3 normal[GNOMON_TOGETHER], inout vec3 sum[GNOMON_TOGETHER])
{
    const float k_per_pi = 0.318309886183791;
    for (uint v = 0; v < push.views; ++v) {
        if (views.at[v].on == 0) continue;
        const uint levels = views.at[v].levels, texels = node_of(views.at[v], levels, 0, 0);
        const float side = float(1u << levels);
        const vec4 clip = views.at[v].clip_from_world * vec4(at[0], 1);
        const vec2 place = clip.w > 0 ? clamp(clip.xy / clip.w * 0.5 + 0.5, 0, 1) * side : vec2(0.5 * side);
        for (uint s = 0; s < push.samples; ++s) {
            const GpuSample point = pattern.at[s];
            const vec2 there = place + vec2(point.x, point.y);
            if (any(lessThan(there, vec2(0))) || any(greaterThanEqual(there, vec2(side)))) continue;
            const uvec2 texel = uvec2(there);
            const GpuNode light = nodes.at[texels + (texel.y << levels) + texel.x];
            const float share = point.weight * k_per_pi;
            add_light(light.position, light.normal, light.area * share, light.flux * share, at[0], normal[0], sum[0]);
        }
    }
}
#include "light_quadtree/vulkan/gather.glsl"
