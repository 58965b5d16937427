// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Depth pass for alpha-tested casters between a receiver and the light.
#include "light_views/vulkan/caster_shared.h"

layout(location = 1) in vec2 uv;
layout(binding = 3, scalar) readonly buffer AlphaMaterials { AlphaMaterial alpha_materials[]; };
layout(binding = 4, scalar) readonly buffer AlphaTexels { uint alpha_texels[]; };
layout(push_constant, scalar) uniform Constants { CasterConstants caster; };
#include "light_views/vulkan/alpha_test.glsl"

void main()
{
    if (!passes_alpha_test(alpha_materials[caster.material], uv)) discard;
}
