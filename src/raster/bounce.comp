// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Adds indirect light to the image, from the irradiance at each pixel's surface. Formula:
// reflect_irradiance in src/shading/shading.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "raster/mirror.glsl"
#include "raster/raster_shared.h"
#include "raster/weighted.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, scalar) readonly buffer Frame
{
    RasterFrame frame;
};
layout(binding = 1, rgba32f) uniform image2D color;
layout(binding = 2, rgba32f) uniform image2D indirect;
layout(binding = 3) uniform texture2D share;
layout(binding = 4) uniform texture2D g_position;
layout(binding = 5) uniform texture2D g_normal;
layout(binding = 6) uniform texture2D g_geometric;
layout(binding = 7) uniform texture2D g_diffuse;
layout(binding = 8) uniform texture2D g_specular;
layout(binding = 9) uniform texture2D irradiance;
layout(push_constant, scalar) uniform Push
{
    BouncePush push;
};

const float k_pi = 3.14159265358979;

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(frame.width) || at.y >= int(frame.height)) return;
    const vec4 part = texelFetch(share, at, 0);
    const vec4 diffuse = texelFetch(g_diffuse, at, 0);
    const uint model = uint(diffuse.w);
    if (part == vec4(0) || diffuse.xyz == vec3(0) || model == GNOMON_MODEL_UNLIT) return;
    const float coverage = texelFetch(g_geometric, at, 0).w;
    vec3 radiance = diffuse.xyz * (coverage / k_pi) * texelFetch(irradiance, at, 0).xyz;
    if (model == GNOMON_MODEL_METALLIC_ROUGHNESS) {
        // Leave out the light that mirror rays bring.
        const vec4 normal = texelFetch(g_normal, at, 0), specular = texelFetch(g_specular, at, 0);
        const vec3 position = texelFetch(g_position, at, 0).xyz;
        const vec3 to_viewer = frame.orthographic != 0 ? -frame.forward : normalize(frame.eye - position);
        const float cosine = clamp(dot(normal.xyz, to_viewer), 0, 1);
        vec3 mirrored = vec3(0);
        if (specular.w > 0)
            mirrored = vec3(fresnel_dielectric(cosine, specular.w));
        else if (specular.xyz != vec3(0))
            mirrored = rough_fresnel(specular.xyz, normal.w, cosine) * traced_part(normal.w);
        radiance *= max(vec3(1) - coverage * mirrored, vec3(0));
    }
    imageStore(color, at, imageLoad(color, at) + weighted(part, radiance));
    if (push.layers != 0) imageStore(indirect, at, imageLoad(indirect, at) + weighted(part, radiance));
}
