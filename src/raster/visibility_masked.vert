// SPDX-License-Identifier: Apache-2.0
#version 460
// As visibility.vert, with the inputs of the alpha test.
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
#include "raster/raster_shared.h"

layout(push_constant, scalar) uniform Push { DrawPush push; };
layout(location = 0) in vec3 position;
layout(location = 0) flat out uint draw;
layout(location = 1) out vec2 texcoord;
layout(location = 2) out float alpha;
invariant gl_Position;

void main()
{
    draw = gl_InstanceIndex;
    const uint object = draws.at[draw].object, material = draws.at[draw].material;
    const vec3 world = vec3(objects.at[object].to_world * vec4(position, 1));
    gl_Position = push.clip_from_offset * vec4(world - push.eye, 1);

    const uint vertex = uint(gl_VertexIndex) - objects.at[object].positions;
    const GpuTextureUse use = materials.at[material].base_color_texture;
    const uint set = objects.at[object].texcoords[use.texture == GNOMON_NONE ? 0 : use.texcoord];
    texcoord = use.texture == GNOMON_NONE || set == GNOMON_NONE ? vec2(0) : apply(use, texcoords.at[set + vertex]);
    alpha = materials.at[material].alpha;
    if (objects.at[object].colors != GNOMON_NONE) alpha *= colors.at[objects.at[object].colors + vertex].w;
}
