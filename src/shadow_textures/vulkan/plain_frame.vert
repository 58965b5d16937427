// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Transforms a caster to the camera's view.
#include "shadow_textures/vulkan/plain_shared.h"

layout(location = 0) in vec3 position;
layout(location = 0) flat out uint object;
layout(location = 1) out vec3 point;   // world space
layout(binding = 0, scalar) readonly buffer Matrices { mat4 matrices[]; };
layout(push_constant, scalar) uniform Constants { PlainConstants frame; };

void main()
{
    object = uint(gl_InstanceIndex);
    vec4 world = matrices[object] * vec4(position, 1);
    point = world.xyz;
    gl_Position = frame.clip_from_world * world;
}
