// SPDX-License-Identifier: Apache-2.0
#version 460
// Copies the levels of the cut to an image, for the gather as printed: the light cluster maps [Ki and Oh 2007, 3.1].
// View by view, level by level, node by node; three texels per node, in the layout of clusters, and the node's share.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light_quadtree/vulkan/map_shared.h"

layout(local_size_x = 64) in;
layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, scalar) readonly buffer Nodes { GpuNode at[]; } nodes;
layout(binding = 2, scalar) readonly buffer Shares { uint at[]; } shares;
layout(binding = 3, rgba32f) uniform writeonly image2D levels;
layout(push_constant, scalar) uniform Push { LevelsPush push; };

#include "light_quadtree/vulkan/map_nodes.glsl"

void main()
{
    const float k_per_pi = 0.318309886183791;
    const uint a_view = first_of_level(push.start, push.limit + 1);
    const uint at = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    if (at >= a_view * push.views) return;
    const GpuMapView view = views.at[at / a_view];
    uint level = push.start;
    while (at % a_view >= first_of_level(push.start, level + 1)) ++level;
    if (level > view.levels) return;
    const uint i = at % a_view - first_of_level(push.start, level);
    const uint id = node_of(view, level, i & ((1u << level) - 1), i >> level);
    const GpuNode node = nodes.at[id];
    const ivec2 place = ivec2(3 * (at % GNOMON_NODES_A_ROW), at / GNOMON_NODES_A_ROW);
    imageStore(levels, place, vec4(node.position, node.area * k_per_pi));
    imageStore(levels, place + ivec2(1, 0), vec4(node.normal, node.flux.x));
    imageStore(levels, place + ivec2(2, 0), vec4(node.flux.yz, float(shares.at[id]), 0));
}
