// SPDX-License-Identifier: Apache-2.0
#version 460
// One level of the pyramid above changed texels, in all views at once: each node from its four children, and whether it
// may represent them [Ki and Oh 2007, 3.1]. As mean_of and share_of (light_node.h), in the same order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light_quadtree/vulkan/map_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, scalar) buffer Nodes { GpuNode at[]; } nodes;
layout(binding = 2, scalar) writeonly buffer Shares { uint at[]; } shares;
layout(push_constant, scalar) uniform Push { NodePush push; };

#include "light_quadtree/vulkan/map_nodes.glsl"

// As share_of (light_node.h).
uint share_of(GpuNode four[4], GpuNode mean)
{
    if (mean.members == 0) return GNOMON_WHOLE_SHARE;
    float most = 0;
    for (int c = 0; push.margin > 0 && c < 4; ++c) {
        if (four[c].members == 0) return 0;
        most = max(most, abs(four[c].depth - mean.depth) / max(push.depth_threshold, 1e-20));
        most = max(most, (1 - dot(four[c].normal, mean.normal)) / max(1 - push.normal_threshold, 1e-20));
    }
    if (push.margin > 0)
        return uint(min(1, max(0, (1 + push.margin - most) / (2 * push.margin))) * float(GNOMON_WHOLE_SHARE) + 0.5);
    for (int c = 0; c < 4; ++c) {
        if (four[c].members == 0) return 0;
        if (!(abs(four[c].depth - mean.depth) < push.depth_threshold)) return 0;
        if (!(dot(four[c].normal, mean.normal) > push.normal_threshold)) return 0;
    }
    return GNOMON_WHOLE_SHARE;
}

void main()
{
    const GpuMapView view = views.at[gl_GlobalInvocationID.z];
    if (view.dirty[0] >= view.dirty[2] || view.dirty[1] >= view.dirty[3] || push.level >= view.levels) return;
    const uint up = view.levels - push.level;
    const uint x = gl_GlobalInvocationID.x + (view.dirty[0] >> up), y = gl_GlobalInvocationID.y + (view.dirty[1] >> up);
    if (x > (view.dirty[2] - 1) >> up || y > (view.dirty[3] - 1) >> up) return;

    GpuNode four[4];
    for (uint c = 0; c < 4; ++c) four[c] = nodes.at[node_of(view, push.level + 1, 2 * x + (c & 1), 2 * y + (c >> 1))];
    precise vec3 position = vec3(0), normal = vec3(0), flux = vec3(0);
    precise float depth = 0, area = 0;
    uint members = 0;
    for (int c = 0; c < 4; ++c) {
        const float count = float(four[c].members);
        position += count * four[c].position;
        normal += count * four[c].normal;
        depth += count * four[c].depth;
        area += four[c].area;
        flux += four[c].flux;
        members += four[c].members;
    }
    if (members != 0) {
        const float scale = 1 / float(members);
        position *= scale;
        normal *= scale;
        depth *= scale;
    }
    const GpuNode mean = GpuNode(position, normal, depth, area, flux, members);
    const uint id = node_of(view, push.level, x, y);
    nodes.at[id] = mean;
    shares.at[id] = share_of(four, mean);
}
