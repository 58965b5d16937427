// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Adds the direct light of a batch of lights to the image, from the G-buffer. Formulas: src/shading/shading.cpp and
// src/scene/light.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "gpu_scene/light.glsl"
#include "raster/raster_shared.h"
#include "raster/weighted.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, scalar) readonly buffer Frame { RasterFrame frame; };
layout(binding = 1, scalar) readonly buffer Lights { GpuLight at[]; } lights;
layout(binding = 2, rgba32f) uniform image2D color;
layout(binding = 3, rgba32f) uniform image2D direct;
layout(binding = 4) uniform texture2D share;
layout(binding = 5) uniform texture2D g_position;
layout(binding = 6) uniform texture2D g_normal;
layout(binding = 7) uniform texture2D g_geometric;
layout(binding = 12) uniform texture2D g_smooth;
layout(binding = 8) uniform texture2D g_diffuse;
layout(binding = 9) uniform texture2D g_specular;
layout(binding = 10) uniform texture2DArray visibility;   // one layer a light of the batch: 1 is lit
layout(binding = 11, scalar) buffer Lit { float at[]; } lit_layers;   // light by light, pixel by pixel; see ShadePush
layout(push_constant, scalar) uniform Push { ShadePush push; };

const float k_pi = 3.14159265358979;

struct Point {
    vec3 position, normal, smooth_normal, to_viewer, diffuse, specular;
    uint model;
    float roughness, coverage;
};

float soften_terminator(float cos_horizon, float cos_shading, float cos_between)
{
    if (cos_between >= 0.99999) return 1;
    const float g = min(1, cos_horizon / max(cos_shading * cos_between, 1e-6));
    return g * (1 + g * (1 - g));
}

vec3 schlick(vec3 f0, float cosine)
{
    const float x = 1 - clamp(cosine, 0, 1);
    const float x2 = x * x;
    return f0 + (vec3(1) - f0) * (x2 * x2 * x);
}

// A surface that catches shadows; without a highlight.
vec3 matte(Point p, float cosine)
{
    return p.diffuse * (cosine / k_pi);
}

vec3 phong(Point p, vec3 to_light, float cosine)
{
    vec3 result = p.diffuse * cosine;
    if (p.roughness > 0 && p.specular != vec3(0)) {
        const float aligned = dot(2 * cosine * p.normal - to_light, p.to_viewer);
        if (aligned > 0 && p.roughness * (aligned - 1) > -7) result += p.specular * pow(aligned, p.roughness);
    }
    return result;
}

vec3 ggx(Point p, vec3 to_light, float cosine)
{
    const vec3 between = normalize(to_light + p.to_viewer);
    const float n_h = clamp(dot(p.normal, between), 0, 1);
    const float n_v = max(dot(p.normal, p.to_viewer), 1e-4);
    const float v_h = clamp(dot(p.to_viewer, between), 0, 1);
    const vec3 fresnel = schlick(p.specular, v_h);
    const float alpha = max(p.roughness * p.roughness, 2e-3);
    const float a2 = alpha * alpha;
    const float d = n_h * n_h * (a2 - 1) + 1;
    const float distribution = a2 / (k_pi * d * d);
    const float reach =
        0.5 / (cosine * sqrt(n_v * n_v * (1 - a2) + a2) + n_v * sqrt(cosine * cosine * (1 - a2) + a2));
    return (p.diffuse * (vec3(1) - fresnel) / k_pi + fresnel * (distribution * reach)) * cosine;
}

vec3 reflect_light(Point p, vec3 to_light, bool of_environment)
{
    const float cosine = dot(p.normal, to_light), cos_horizon = dot(p.smooth_normal, to_light);
    if (cosine <= 0 || cos_horizon <= 0) return vec3(0);
    if (p.model == GNOMON_MODEL_CATCHER) return matte(p, cosine) * p.coverage;
    const float soft = soften_terminator(cos_horizon, cosine, dot(p.normal, p.smooth_normal)) * p.coverage;
    if (of_environment) {
        vec3 reflectance = p.diffuse / k_pi;
        if (p.model != GNOMON_MODEL_WHITTED)
            reflectance *= vec3(1) - schlick(p.specular, dot(p.to_viewer, normalize(to_light + p.to_viewer)));
        return reflectance * (cosine * soft);
    }
    return (p.model == GNOMON_MODEL_WHITTED ? phong(p, to_light, cosine) : ggx(p, to_light, cosine)) * soft;
}

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(frame.width) || at.y >= int(frame.height)) return;
    const vec4 part = texelFetch(share, at, 0);
    const vec4 diffuse = texelFetch(g_diffuse, at, 0);
    if (part == vec4(0) || uint(diffuse.w) == GNOMON_MODEL_UNLIT) return;
    const vec4 normal = texelFetch(g_normal, at, 0);
    Point p;
    p.position = texelFetch(g_position, at, 0).xyz;
    p.normal = normal.xyz, p.roughness = normal.w;
    p.smooth_normal = texelFetch(g_smooth, at, 0).xyz, p.coverage = texelFetch(g_geometric, at, 0).w;
    p.diffuse = diffuse.xyz, p.model = uint(diffuse.w);
    p.specular = texelFetch(g_specular, at, 0).xyz;
    p.to_viewer = frame.orthographic != 0 ? -frame.forward : normalize(frame.eye - p.position);

    vec3 sum = vec3(0);
    for (uint l = 0; l < push.light_count; ++l) {
        vec3 to_light, irradiance;
        const GpuLight light = lights.at[push.first_light + l];
        if (!illuminate(light, p.position, to_light, irradiance)) continue;
        const float lit = push.shadowed != 0 ? texelFetch(visibility, ivec3(at, int(l)), 0).x : 1;
        if (!(lit > 0) || dot(p.normal, to_light) <= 0 || dot(p.smooth_normal, to_light) <= 0) continue;
        sum += lit * irradiance * reflect_light(p, to_light, light.of_environment != 0);
        const uint bound = l - push.first_lit;   // wraps below the first
        if (bound < push.lit_count && irradiance != vec3(0))
            lit_layers.at[bound * push.lit_pixels + uint(at.y) * frame.width + uint(at.x)] += (part.x + part.w) * lit;
    }
    if (push.colors == 0) return;
    imageStore(color, at, imageLoad(color, at) + weighted(part, sum));
    if (push.layers != 0) imageStore(direct, at, imageLoad(direct, at) + weighted(part, sum));
}
