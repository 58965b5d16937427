// SPDX-License-Identifier: Apache-2.0
#version 460
// A triangle at a given depth, translated per instance.
layout(location = 0) in vec3 position;
layout(location = 0) flat out uint instance;
void main()
{
    instance = uint(gl_InstanceIndex);
    gl_Position = vec4(position.xy, position.z + 0.25 * float(gl_InstanceIndex), 1);
}
