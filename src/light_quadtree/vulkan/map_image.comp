// SPDX-License-Identifier: Apache-2.0
#version 460
// Copies the changed part of the map's finest level to an image for sampling: views below one another, three texels per
// node, in the layout of clusters.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light_quadtree/vulkan/map_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, scalar) readonly buffer Nodes { GpuNode at[]; } nodes;
layout(binding = 2, rgba32f) uniform writeonly image2D texels;
layout(push_constant, scalar) uniform Push { MapImagePush push; };

#include "light_quadtree/vulkan/map_nodes.glsl"

void main()
{
    const float k_per_pi = 0.318309886183791;
    const uint v = gl_GlobalInvocationID.z;
    const GpuMapView view = views.at[v];
    const uvec2 first = push.all != 0 ? uvec2(0) : uvec2(view.dirty[0], view.dirty[1]);
    const uvec2 end = push.all != 0 ? uvec2(1u << view.levels) : uvec2(view.dirty[2], view.dirty[3]);
    const uvec2 at = gl_GlobalInvocationID.xy + first;
    if (at.x >= end.x || at.y >= end.y) return;
    const GpuNode node = nodes.at[node_of(view, view.levels, at.x, at.y)];
    const ivec2 place = ivec2(3 * at.x, at.y + (v << view.levels));
    imageStore(texels, place, vec4(node.position, node.area * k_per_pi));
    imageStore(texels, place + ivec2(1, 0), vec4(node.normal, node.flux.x * k_per_pi));
    imageStore(texels, place + ivec2(2, 0), vec4(node.flux.yz * k_per_pi, 0, 0));
}
