// SPDX-License-Identifier: Apache-2.0
#version 460
// Transforms one vertex of one draw. The offset from the eye is computed first, because far from the origin it is exact
// where a product of matrices is not.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "raster/raster_shared.h"

layout(binding = 0, scalar) readonly buffer Objects { GpuObject at[]; } objects;
layout(binding = 1, scalar) readonly buffer Draws { GpuDraw at[]; } draws;
layout(push_constant, scalar) uniform Push { DrawPush push; };
layout(location = 0) in vec3 position;
layout(location = 0) flat out uint draw;
invariant gl_Position;

void main()
{
    draw = gl_InstanceIndex;
    const uint object = draws.at[draw].object;
    const vec3 world = vec3(objects.at[object].to_world * vec4(position, 1));
    gl_Position = push.clip_from_offset * vec4(world - push.eye, 1);
}
