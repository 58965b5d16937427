// SPDX-License-Identifier: Apache-2.0
#version 460
// The cut through the trees [Ki and Oh 2007, 3.2], compacted into one list in a fixed order: level by level, view by
// view, children in the order of their parents. A work group handles one level of one view; a first pass counts, a
// second writes.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "light_quadtree/vulkan/map_shared.h"

#define GNOMON_GROUP 256
layout(local_size_x = GNOMON_GROUP) in;
layout(binding = 0, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 1, scalar) readonly buffer Nodes { GpuNode at[]; } nodes;
layout(binding = 2, scalar) readonly buffer Shares { uint at[]; } shares;
layout(binding = 3, scalar) buffer Counts { uint at[]; } counts;  // by group; then the total
layout(binding = 4, scalar) writeonly buffer Clusters { GpuCluster at[]; } clusters;
layout(push_constant, scalar) uniform Push { CutPush push; };

#include "light_quadtree/vulkan/map_nodes.glsl"

shared uint scan[GNOMON_GROUP];
shared uint sum;

const uint k_none = 0xffffffffu;
const float k_per_pi = 0.318309886183791;

// The i-th node of a level if it is in the cut: no ancestor takes all of the light, it takes a part of the rest or is
// at the limit, and it is not dark. `part`: of the node's light.
uint chosen(GpuMapView view, uint level, uint limit, uint i, out float part)
{
    const float whole = float(GNOMON_WHOLE_SHARE);
    part = 1;
    const uint depth = level - push.start;
    const uint top = i >> (2 * depth);
    uint x = top & ((1u << push.start) - 1), y = top >> push.start;
    for (uint l = 0; l < depth; ++l) {
        const uint share = shares.at[node_of(view, push.start + l, x, y)];
        if (share == GNOMON_WHOLE_SHARE) return k_none;
        part *= float(GNOMON_WHOLE_SHARE - share) / whole;
        const uint child = (i >> (2 * (depth - 1 - l))) & 3;
        x = 2 * x + (child & 1), y = 2 * y + (child >> 1);
    }
    const uint id = node_of(view, level, x, y);
    const uint share = level != limit ? shares.at[id] : GNOMON_WHOLE_SHARE;
    if (share == 0) return k_none;
    part *= float(share) / whole;
    return nodes.at[id].flux == vec3(0) ? k_none : id;
}

void main()
{
    const uint group = gl_WorkGroupID.x, me = gl_LocalInvocationID.x;
    const uint level = push.start + group / push.views;
    const GpuMapView view = views.at[group % push.views];
    const uint limit = min(push.limit, view.levels);
    const uint candidates = view.on != 0 && level <= limit ? 1u << (2 * level) : 0;
    if (me == 0) sum = 0;
    barrier();

    if (push.write == 0) {
        uint own = 0;
        float part;
        for (uint i = me; i < candidates; i += GNOMON_GROUP) own += chosen(view, level, limit, i, part) == k_none ? 0 : 1;
        atomicAdd(sum, own);
        barrier();
        if (me == 0) counts.at[group] = sum;
        return;
    }

    // Find the offset of this group's clusters.
    uint before = 0;
    for (uint g = me; g < group; g += GNOMON_GROUP) before += counts.at[g];
    atomicAdd(sum, before);
    barrier();
    uint at = sum;
    for (uint first = 0; first < candidates; first += GNOMON_GROUP) {
        const uint i = first + me;
        float part = 0;
        const uint id = i < candidates ? chosen(view, level, limit, i, part) : k_none;
        scan[me] = id == k_none ? 0 : 1;
        barrier();
        for (uint reach = 1; reach < GNOMON_GROUP; reach *= 2) {
            const uint left = me >= reach ? scan[me - reach] : 0;
            barrier();
            scan[me] += left;
            barrier();
        }
        if (id != k_none) {
            const GpuNode node = nodes.at[id];
            const float power = k_per_pi * part;
            clusters.at[at + scan[me] - 1] =
                GpuCluster(node.position, node.area * k_per_pi, node.normal, node.flux.x * power,
                           node.flux.y * power, node.flux.z * power, id, level);
        }
        at += scan[GNOMON_GROUP - 1];
        barrier();
    }
    if (me == 0 && group + 1 == gl_NumWorkGroups.x) counts.at[group + 1] = at;
}
