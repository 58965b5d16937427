// SPDX-License-Identifier: Apache-2.0
#version 460
// Doubles numbers; their count is in `limits`.
layout(local_size_x = 64) in;
layout(binding = 0, std430) readonly buffer Source { uint source[]; };
layout(binding = 1, std430) buffer Target { uint target[]; };
struct Item { vec3 place; float weight; uint flags; };
layout(binding = 2, std430) readonly buffer Items { Item items[]; };
layout(push_constant) uniform Limits { uint count; uint factor; } limits;
void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i < limits.count) target[i] = limits.factor * source[i] + items[0].flags;
}
