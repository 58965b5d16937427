// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Bounced light by sampling the map around the receiver's projection in it [Dachsbacher and Stamminger 2005, 4.2]. Same
// method as rsm.cpp. The map and the pattern are read as images.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "light_quadtree/vulkan/map_shared.h"

layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, rgba32f) uniform readonly image2D texels;  // written by map_image.comp
layout(binding = 2, rgba32f) uniform readonly image2D pattern;   // x, y, weight
layout(push_constant, scalar) uniform Push { GatherPush push; };
#include "light_quadtree/vulkan/kernel.glsl"
#define GNOMON_ACROSS GNOMON_SAMPLES_ACROSS
#define GNOMON_DOWN GNOMON_SAMPLES_DOWN
#define GNOMON_TOGETHER (GNOMON_ACROSS * GNOMON_DOWN)  // pixels that use each loaded sample
#define GNOMON_IMAGES 3

void all_light(vec3 at[GNOMON_TOGETHER], vec3 normal[GNOMON_TOGETHER], inout vec3 sum[GNOMON_TOGETHER])
{
    for (uint v = 0; v < push.views; ++v) {
        if (views.at[v].on == 0) continue;
        const mat4 to_clip = views.at[v].clip_from_world;
        const int side = 1 << views.at[v].levels, top = int(v) * side;
        vec2 place[GNOMON_TOGETHER];
        [[unroll]] for (int i = 0; i < GNOMON_TOGETHER; ++i) {
            const vec4 clip = to_clip * vec4(at[i], 1);
            place[i] = clip.w > 0 ? clamp(clip.xy / clip.w * 0.5 + 0.5, 0, 1) * side : vec2(0.5 * side);
        }
        for (uint s = 0; s < push.samples; ++s) {
            const vec3 point =
                imageLoad(pattern, ivec2(s % GNOMON_SAMPLES_A_ROW, s / GNOMON_SAMPLES_A_ROW)).xyz;
            [[unroll]] for (int i = 0; i < GNOMON_TOGETHER; ++i) {
                const vec2 there = place[i] + point.xy;
                if (any(lessThan(there, vec2(0))) || any(greaterThanEqual(there, vec2(side)))) continue;
                const ivec2 texel = ivec2(3 * int(there.x), top + int(there.y));
                const vec4 a = imageLoad(texels, texel), b = imageLoad(texels, texel + ivec2(1, 0));
                const vec3 power = vec3(b.w, imageLoad(texels, texel + ivec2(2, 0)).xy);
                add_light(a.xyz, b.xyz, a.w * point.z, power * point.z, at[i], normal[i], sum[i]);
            }
        }
    }
}
#include "light_quadtree/vulkan/gather.glsl"
