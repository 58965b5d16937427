// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Computes the visibility of lights at each pixel from positions, normals and object numbers; one layer per light.
#include "shadow_textures/vulkan/lookup_shared.h"
#include "shadow_textures/vulkan/textures_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D positions;    // world space
layout(binding = 1) uniform sampler2D normals;      // geometric, unit, on the viewer's side
layout(binding = 2) uniform usampler2D objects;  // object + 1; 0: none
layout(binding = 3) uniform sampler2DArray light_depth;
layout(binding = 4) uniform usampler2DArray light_item;
layout(binding = 5, scalar) readonly buffer ViewRecords { ViewRecord view_records[]; };
layout(binding = 6, scalar) readonly buffer LightRecords { LightRecord light_records[]; };
layout(binding = 7, scalar) readonly buffer Places { TexturePlace places[]; };
layout(binding = 8, scalar) readonly buffer Textures { uint textures[]; };
layout(binding = 9, r8) writeonly uniform image2DArray visibility;
layout(binding = 10, scalar) readonly buffer Casts { uint casts[]; };  // by object: 1 if it casts shadows
layout(binding = 11, scalar) buffer Counts { LookupCounts counts; };
layout(binding = 12) uniform sampler2D smooth_normals;   // of the smooth horizon; w: height of the smooth surface
layout(push_constant, scalar) uniform Constants { LookupConstants lookup; };
#include "shadow_textures/vulkan/lookup.glsl"
#include "shadow_textures/vulkan/smooth_horizon.glsl"

void main()
{
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= lookup.size.x || pixel.y >= lookup.size.y) return;
    uint light = gl_GlobalInvocationID.z;
    uint object = texelFetch(objects, ivec2(pixel), 0).x;
    float seen = 0.0;
    if (object != 0u) {
        uint number = lookup.first_light + light;
        vec3 point = texelFetch(positions, ivec2(pixel), 0).xyz, normal = texelFetch(normals, ivec2(pixel), 0).xyz;
        if (lookup.as_printed == 0u) move_between_horizons(number, texelFetch(smooth_normals, ivec2(pixel), 0), point, normal);
        seen = light_visibility(number, point, normal, object - 1u);
        if (lookup.as_printed != 0u && faces_light(number, point, normal)) {
            float compared = seen;
            seen = light_visibility_as_printed(number, point, normal, object - 1u);
            atomicAdd(counts.results, 1u);
            if ((seen >= 0.5) != (compared >= 0.5)) atomicAdd(counts.wrong, 1u);
        }
    }
    imageStore(visibility, ivec3(pixel, light), vec4(seen));
}
