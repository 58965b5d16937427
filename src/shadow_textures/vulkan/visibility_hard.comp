// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Computes the visibility of lights at each pixel with the edges of the casters' triangles; one layer per light.
#include "light_views/vulkan/caster_shared.h"
#include "shadow_textures/vulkan/lookup_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D positions;    // world space
layout(binding = 1) uniform sampler2D normals;      // geometric, unit, on the viewer's side
layout(binding = 2) uniform usampler2D objects;  // object + 1; 0: none
layout(binding = 3, scalar) readonly buffer ViewRecords { ViewRecord view_records[]; };
layout(binding = 4, scalar) readonly buffer LightRecords { LightRecord light_records[]; };
layout(binding = 5, r8) writeonly uniform image2DArray visibility;
layout(binding = 6, scalar) readonly buffer CellTriangles { CellTriangle cell_triangles[]; };
layout(binding = 7, scalar) readonly buffer CasterTexcoords { vec2 caster_texcoords[]; };
layout(binding = 8, scalar) readonly buffer CasterIndices { uint caster_indices[]; };
layout(binding = 9, scalar) readonly buffer CasterOffsets { int caster_offsets[]; };
layout(binding = 10, scalar) readonly buffer AlphaMaterials { AlphaMaterial alpha_materials[]; };
layout(binding = 11, scalar) readonly buffer AlphaTexels { uint alpha_texels[]; };
layout(binding = 12, scalar) readonly buffer CellBases { uint cell_bases[]; };
layout(binding = 13, scalar) readonly buffer StaticFirst { uint static_first[]; };
layout(binding = 14, scalar) readonly buffer StaticBlocks { CellBlock static_blocks[]; };
layout(binding = 15, scalar) readonly buffer StaticEntries { CellEntry static_entries[]; };
layout(binding = 16, scalar) readonly buffer MovingFirst { uint moving_first[]; };
layout(binding = 17, scalar) readonly buffer MovingBlocks { CellBlock moving_blocks[]; };
layout(binding = 18, scalar) readonly buffer MovingEntries { CellEntry moving_entries[]; };
layout(binding = 19) uniform sampler2D smooth_normals;   // of the smooth horizon; w: height of the smooth surface
layout(push_constant, scalar) uniform Constants { LookupConstants lookup; };
#include "light_views/vulkan/alpha_test.glsl"
#include "shadow_textures/vulkan/view_of_light.glsl"
#include "shadow_textures/vulkan/hard_edges.glsl"
#include "shadow_textures/vulkan/smooth_horizon.glsl"

void main()
{
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= lookup.size.x || pixel.y >= lookup.size.y) return;
    uint light = gl_GlobalInvocationID.z;
    uint object = texelFetch(objects, ivec2(pixel), 0).x;
    float seen = 0.0;
    if (object != 0u) {
        const uint number = lookup.first_light + light;
        vec3 point = texelFetch(positions, ivec2(pixel), 0).xyz, normal = texelFetch(normals, ivec2(pixel), 0).xyz;
        move_between_horizons(number, texelFetch(smooth_normals, ivec2(pixel), 0), point, normal);
        seen = hard_visibility(number, point, normal);
    }
    imageStore(visibility, ivec3(pixel, light), vec4(seen));
}
