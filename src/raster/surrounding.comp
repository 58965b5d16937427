// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Adds the light of surroundings, which the host found at each pixel's surface, to the image.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "raster/raster_shared.h"
#include "raster/image_light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform texture2D surroundings;
layout(binding = 1) uniform texture2D share;
layout(binding = 2, rgba32f) uniform image2D color;
layout(binding = 3, rgba32f) uniform image2D direct;
layout(push_constant, scalar) uniform Push { SurroundingPush push; };

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(color);
    if (at.x >= size.x || at.y >= size.y) return;
    const vec4 part = texelFetch(share, at, 0);
    if (part.xyz == vec3(0)) return;
    const vec3 arrives = part.xyz * texelFetch(surroundings, at, 0).xyz;
    imageStore(color, at, imageLoad(color, at) + image_light(arrives, part.w > 0));
    if (push.layers != 0) imageStore(direct, at, imageLoad(direct, at) + vec4(arrives, 0));
}
