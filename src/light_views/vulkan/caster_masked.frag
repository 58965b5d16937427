// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The same for alpha-tested surfaces: discards fragments where the material's alpha is below its cutoff.
#include "light_views/vulkan/caster_shared.h"

layout(location = 0) flat in uint object;
layout(location = 1) in vec2 uv;
layout(location = 0) out uint item;
layout(binding = 1) uniform sampler2DArray static_depth;
layout(binding = 2) uniform usampler2DArray static_item;
layout(binding = 3, scalar) readonly buffer AlphaMaterials { AlphaMaterial alpha_materials[]; };
layout(binding = 4, scalar) readonly buffer AlphaTexels { uint alpha_texels[]; };
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };
#include "light_views/vulkan/alpha_test.glsl"

void main()
{
    if (!passes_alpha_test(alpha_materials[caster.material], uv)) discard;
    item = object + 1u;
    if (caster.ties != 0u) {
        ivec3 at = ivec3(gl_FragCoord.xy, caster.page);
        if (texelFetch(static_depth, at, 0).x == gl_FragCoord.z) item = max(item, texelFetch(static_item, at, 0).x);
    }
}
