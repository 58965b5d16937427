// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Writes a caster's item where it is nearer than the buffer's contents, or equally near.
#include "light_views/vulkan/caster_shared.h"

layout(location = 0) flat in uint object;
layout(location = 0) out uint item;
layout(binding = 1) uniform sampler2DArray static_depth;
layout(binding = 2) uniform usampler2DArray static_item;
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };

void main()
{
    item = object + 1u;
    if (caster.ties != 0u) {
        ivec3 at = ivec3(gl_FragCoord.xy, caster.page);
        if (texelFetch(static_depth, at, 0).x == gl_FragCoord.z) item = max(item, texelFetch(static_item, at, 0).x);
    }
}
