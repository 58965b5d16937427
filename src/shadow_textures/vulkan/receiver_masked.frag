// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The same for alpha-tested surfaces.
#include "light_views/vulkan/caster_shared.h"
#include "shadow_textures/vulkan/textures_shared.h"

layout(early_fragment_tests) in;
layout(location = 0) flat in uint object;
layout(location = 1) in vec2 uv;
layout(binding = 1, scalar) readonly buffer Places { TexturePlace places[]; };
layout(binding = 2, scalar) buffer Textures { uint textures[]; };
layout(binding = 3, scalar) readonly buffer AlphaMaterials { AlphaMaterial alpha_materials[]; };
layout(binding = 4, scalar) readonly buffer AlphaTexels { uint alpha_texels[]; };
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };
#include "light_views/vulkan/alpha_test.glsl"

void main()
{
    if (!passes_alpha_test(alpha_materials[caster.material], uv)) return;
    TexturePlace place = places[caster.place + object];
    uvec2 at = uvec2(ivec2(gl_FragCoord.xy) - place.corner);
    atomicOr(textures[place.first_word + at.y * place.row_words + at.x / 32u], 1u << (at.x % 32u));
}
