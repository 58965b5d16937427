// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Transforms a caster's vertices to a light view. Every pipeline that draws into a light view, or compares depths with
// one, uses this shader, because equal depths must be equal bit for bit.
#include "light_views/vulkan/caster_shared.h"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 texcoord;
layout(location = 0) flat out uint object;
layout(location = 1) out vec2 uv;
layout(binding = 0, scalar) readonly buffer Matrices { mat4 matrices[]; };
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };
invariant gl_Position;

void main()
{
    object = uint(gl_InstanceIndex);
    uv = texcoord;
    gl_Position = caster.clip_from_world * (matrices[object] * vec4(position, 1));
}
