// SPDX-License-Identifier: Apache-2.0
#version 460
// Frustum culling, one invocation per draw. Every draw keeps its index; hidden or culled draws get no instances. Thus
// the order of drawing, and with it the image, does not depend on culling.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"

layout(local_size_x = 64) in;
layout(binding = 0, scalar) readonly buffer Objects { GpuObject at[]; } objects;
layout(binding = 1, scalar) readonly buffer Draws { GpuDraw at[]; } draws;
layout(binding = 2, scalar) buffer Commands { GpuDrawCommand at[]; } commands;
layout(binding = 3, scalar) buffer Counts { uint drawn; uint triangles; } counts;
layout(push_constant, scalar) uniform Push { CullPush push; };

// Whether a transformed box lies completely outside one of the planes.
bool outside(GpuDraw draw, mat4 m)
{
    const vec3 centre = vec3(m * vec4(draw.centre, 1));
    for (int p = 0; p < 6; ++p) {
        const vec3 n = push.planes[p].xyz;
        const float reach = abs(dot(n, m[0].xyz)) * draw.extent.x + abs(dot(n, m[1].xyz)) * draw.extent.y +
                            abs(dot(n, m[2].xyz)) * draw.extent.z;
        if (dot(n, centre) + push.planes[p].w < -reach) return true;
    }
    return false;
}

void main()
{
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.draws) return;
    const GpuDraw draw = draws.at[i];
    const bool drawn = objects.at[draw.object].shown != 0 && !outside(draw, objects.at[draw.object].to_world);
    commands.at[i].instance_count = drawn ? 1 : 0;
    if (drawn) {
        atomicAdd(counts.drawn, 1);
        atomicAdd(counts.triangles, draw.count);
    }
}
