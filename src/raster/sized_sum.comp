// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Adds the direct light of lights with size to the image.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "raster/sized_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform texture2D sized;
layout(binding = 1, rgba32f) uniform image2D color;
layout(binding = 2, rgba32f) uniform image2D direct;
layout(push_constant, scalar) uniform Push { SizedSumPush push; };

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(color);
    if (at.x >= size.x || at.y >= size.y) return;
    const vec4 arrives = texelFetch(sized, at, 0);
    imageStore(color, at, imageLoad(color, at) + arrives);
    if (push.layers != 0) imageStore(direct, at, imageLoad(direct, at) + arrives);
}
