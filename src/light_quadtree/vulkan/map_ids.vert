// SPDX-License-Identifier: Apache-2.0
#version 460
// Transforms a vertex to a light's view.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "light_quadtree/vulkan/map_shared.h"

layout(binding = 0, scalar) readonly buffer Objects { GpuObject at[]; } objects;
layout(binding = 1, scalar) readonly buffer Draws { GpuDraw at[]; } draws;
layout(push_constant, scalar) uniform Push { MapDrawPush push; };
layout(location = 0) in vec3 position;
layout(location = 0) flat out uint draw;
invariant gl_Position;

void main()
{
    draw = gl_InstanceIndex;
    const mat4 to_world = objects.at[draws.at[draw].object].to_world;
    gl_Position = push.clip_from_world * vec4(vec3(to_world * vec4(position, 1)), 1);
}
