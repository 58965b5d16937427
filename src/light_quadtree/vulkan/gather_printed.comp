// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Bounced light by the quad-tree as printed [Ki and Oh 2007, 3.2]: one pass a level, in which every receiver looks at all
// nodes of the level. A node lights it if all its ancestors from the start level on are invalid, and it is valid or at
// the limit level. Passes add to the image of those before them, so that the sum is that of the compacted cut, to the
// bit.
// DEVIATION(Ki 2007, 5): images of 32-bit floats and one pass a level. The paper has 16-bit integers, an image a level,
// and four passes at level 4, because loops of its shaders ended after 256 iterations.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "light_quadtree/vulkan/map_shared.h"

layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, rgba32f) uniform readonly image2D levels;  // written by map_levels.comp
layout(push_constant, scalar) uniform Push { GatherPush push; };
#include "light_quadtree/vulkan/kernel.glsl"
#include "light_quadtree/vulkan/map_nodes.glsl"
#define GNOMON_ACROSS GNOMON_CLUSTERS_ACROSS
#define GNOMON_DOWN GNOMON_CLUSTERS_DOWN
#define GNOMON_TOGETHER (GNOMON_ACROSS * GNOMON_DOWN)
#define GNOMON_IMAGES 2
#define GNOMON_ADDS (push.level > push.start)

void all_light(vec3 at[GNOMON_TOGETHER], vec3 normal[GNOMON_TOGETHER], inout vec3 sum[GNOMON_TOGETHER])
{
    const float k_per_pi = 0.318309886183791, whole = float(GNOMON_WHOLE_SHARE);
    const uint a_view = first_of_level(push.start, push.limit + 1), depth = push.level - push.start;
    for (uint v = 0; v < push.views; ++v) {
        const uint limit = min(push.limit, views.at[v].levels);
        if (views.at[v].on == 0 || push.level > limit) continue;
        for (uint i = 0; i < 1u << (2 * push.level); ++i) {
            // Check the ancestors, from the start level on.
            const uint top = i >> (2 * depth);
            uint x = top & ((1u << push.start) - 1), y = top >> push.start;
            float part = 1;
            for (uint l = push.start; l < push.level && part > 0; ++l) {
                const uint node = v * a_view + first_of_level(push.start, l) + (y << l) + x;
                const ivec2 place = ivec2(3 * (node % GNOMON_NODES_A_ROW), node / GNOMON_NODES_A_ROW);
                part *= (whole - imageLoad(levels, place + ivec2(2, 0)).z) / whole;
                const uint child = (i >> (2 * (push.level - 1 - l))) & 3;
                x = 2 * x + (child & 1), y = 2 * y + (child >> 1);
            }
            if (!(part > 0)) continue;

            // Add the node's light.
            const uint node = v * a_view + first_of_level(push.start, push.level) + (y << push.level) + x;
            const ivec2 place = ivec2(3 * (node % GNOMON_NODES_A_ROW), node / GNOMON_NODES_A_ROW);
            const vec4 a = imageLoad(levels, place), b = imageLoad(levels, place + ivec2(1, 0)),
                       c = imageLoad(levels, place + ivec2(2, 0));
            const float share = push.level == limit ? whole : c.z;
            if (share == 0 || vec3(b.w, c.xy) == vec3(0)) continue;
            const float power = k_per_pi * (part * (share / whole));
            [[unroll]] for (int r = 0; r < GNOMON_TOGETHER; ++r)
                add_light(a.xyz, b.xyz, a.w, vec3(b.w, c.xy) * power, at[r], normal[r], sum[r]);
        }
    }
}
#include "light_quadtree/vulkan/gather.glsl"
