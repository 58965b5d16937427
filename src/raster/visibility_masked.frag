// SPDX-License-Identifier: Apache-2.0
#version 460
// As visibility.frag, and discards where a masked surface's alpha (texture, factor and vertex colour) is below the
// cutoff.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define GNOMON_OBJECTS 0
#define GNOMON_DRAWS 1
#define GNOMON_MATERIALS 2
#define GNOMON_TEXTURES 3
#define GNOMON_TEXELS 4
#define GNOMON_TEXCOORDS 5
#define GNOMON_COLORS 6
#include "gpu_scene/scene_data.glsl"

layout(location = 0) flat in uint draw;
layout(location = 1) in vec2 texcoord;
layout(location = 2) in float alpha;
layout(location = 0) out uvec2 id;

void main()
{
    const uint material = draws.at[draw].material;
    const GpuTextureUse use = materials.at[material].base_color_texture;
    float covered = alpha;
    if (use.texture != GNOMON_NONE && objects.at[draws.at[draw].object].texcoords[use.texcoord] != GNOMON_NONE)
        covered *= texture_alpha(use.texture, texcoord);
    if (covered < materials.at[material].alpha_cutoff) discard;
    id = uvec2(draw + 1, gl_PrimitiveID);
}
