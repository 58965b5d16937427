// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sets the bit of a receiver's texel where its depth passes against the depth of everything [Oh and Shin 2004, 2].
#include "light_views/vulkan/caster_shared.h"
#include "shadow_textures/vulkan/textures_shared.h"

layout(early_fragment_tests) in;
layout(location = 0) flat in uint object;
layout(binding = 1, scalar) readonly buffer Places { TexturePlace places[]; };
layout(binding = 2, scalar) buffer Textures { uint textures[]; };
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };

void main()
{
    TexturePlace place = places[caster.place + object];
    uvec2 at = uvec2(ivec2(gl_FragCoord.xy) - place.corner);
    atomicOr(textures[place.first_word + at.y * place.row_words + at.x / 32u], 1u << (at.x % 32u));
}
