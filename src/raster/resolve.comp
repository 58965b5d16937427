// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Makes surfaces from ids: fills the G-buffer for one layer, adds emission, ambient light and the background, and
// stores the weight of the surfaces behind this layer.
//
// Reflection and refraction are left out, as in the traced frame at max depth 0; but surfaces behind a transparent one
// are seen straight through it. Where the frame keeps what lies behind the scene apart, the image's fourth component
// says how much of it is seen.
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

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 7, scalar) readonly buffer Positions { float at[]; } positions;
layout(binding = 8, scalar) readonly buffer Normals { float at[]; } normals;
layout(binding = 25, scalar) readonly buffer Tangents { vec4 at[]; } tangents;
layout(binding = 9, scalar) readonly buffer Indices { uint at[]; } indices;
layout(binding = 10, scalar) readonly buffer Frame { RasterFrame frame; };
layout(binding = 11) uniform samplerBuffer environment;
layout(binding = 12) uniform utexture2D opaque_ids;
layout(binding = 13) uniform utexture2D peeled_ids;
layout(binding = 14, rgba32f) uniform image2D color;
layout(binding = 15, rgba32f) uniform image2D through;   // w: the part of it that is seen past no glass
layout(binding = 16, rgba32f) uniform writeonly image2D share;   // w: 1: its light counts as what lies behind
layout(binding = 17, rgba32f) uniform writeonly image2D g_position;    // w: depth along the view; 0: nothing
layout(binding = 18, rgba32f) uniform writeonly image2D g_normal;      // w: roughness, or Phong's exponent
layout(binding = 19, rgba32f) uniform writeonly image2D g_geometric;   // w: coverage
layout(binding = 24, rgba32f) uniform writeonly image2D g_smooth;      // w: height
layout(binding = 20, rgba32f) uniform writeonly image2D g_diffuse;     // w: shading model
layout(binding = 21, rgba32f) uniform writeonly image2D g_specular;    // w: index behind over before, of what refracts; else 0
layout(binding = 22, rg32ui) uniform writeonly uimage2D g_ids;         // object + 1 (0: nothing), triangle of the mesh
layout(binding = 23, scalar) readonly buffer Layers { GpuLayers at[]; } layers;
layout(push_constant, scalar) uniform Push { ResolvePush push; };

#include "raster/background.glsl"
#include "raster/mirror.glsl"
#include "raster/surface.glsl"
#include "raster/layers.glsl"
#include "raster/image_light.glsl"

// Mirrored light of rough surfaces, taken from the background alone (Continuation::unresolved_weight).
vec3 unresolved_mirror(Surface s)
{
    if (s.model != GNOMON_MODEL_METALLIC_ROUGHNESS || s.transmitted != vec3(0) || s.specular == vec3(0)) return vec3(0);
    if (frame.surroundings_apart != 0) return vec3(0);
    const float cosine = clamp(dot(s.normal, s.to_viewer), 0, 1);
    const vec3 fresnel = rough_fresnel(s.specular, s.roughness, cosine);
    const float traced = traced_part(s.roughness);
    vec3 reflected = -s.to_viewer + 2 * cosine * s.normal;
    const float above = dot(reflected, s.geometric_normal);
    if (above <= 0) reflected += (1e-3 - above) * s.geometric_normal;
    return fresnel * (1 - traced) * s.coverage * background_ambient(normalize(reflected));
}

// Ambient light, in full or as it is beside indirect light (ambient_light in shading.cpp).
vec3 ambient_light(Surface s)
{
    const bool whitted = s.model == GNOMON_MODEL_WHITTED;
    const bool backdrop = whitted && s.diffuse == vec3(0) && s.specular == vec3(0) && s.transmitted == vec3(0);
    vec3 result = frame.stand_in != 0 || backdrop ? s.ambient * frame.ambient : vec3(0);
    if (frame.background == GNOMON_BACKGROUND_SKY)
        result += (whitted ? s.diffuse : s.ambient) *
                  (frame.stand_in != 0 ? background_ambient(s.normal) : frame.background_color);
    return result;
}

// Weight of the surfaces straight behind.
vec3 passes(Surface s)
{
    vec3 result = vec3(s.uncovered);
    if (s.transmitted != vec3(0)) {
        const float cosine = clamp(dot(s.normal, s.to_viewer), 0, 1);
        const float fresnel = fresnel_dielectric(cosine, s.front || s.thin ? s.ior : 1 / s.ior);
        result += s.coverage * s.transmitted * (1 - fresnel);
    }
    return result;
}

void nothing(ivec2 at)
{
    imageStore(share, at, vec4(0));
    imageStore(g_ids, at, uvec4(0));
    imageStore(g_position, at, vec4(0));
    imageStore(g_normal, at, vec4(0));
    imageStore(g_geometric, at, vec4(0));
    imageStore(g_smooth, at, vec4(0));
    imageStore(g_diffuse, at, vec4(0));
    imageStore(g_specular, at, vec4(0));
}

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(frame.width) || at.y >= int(frame.height)) return;
    const vec4 reaches = push.first != 0 ? vec4(1) : imageLoad(through, at);
    const vec3 here = reaches.xyz;
    if (here == vec3(0)) {
        nothing(at);
        return;
    }

    // Make the pixel's ray, as View::ray does.
    const float sx = 2 * (float(at.x) + push.sample_offset.x) / float(frame.width) - 1 + frame.shift.x;
    const float sy = 1 - 2 * (float(at.y) + push.sample_offset.y) / float(frame.height) + frame.shift.y;
    vec3 origin = frame.eye, direction = frame.forward;
    if (frame.orthographic != 0)
        origin += sx * frame.right + sy * frame.up;
    else
        direction = normalize(frame.forward + sx * frame.right + sy * frame.up);

    uvec2 id = push.peeled != 0 ? texelFetch(peeled_ids, at, 0).xy : uvec2(0);
    const bool before_opaque = id.x != 0;
    if (!before_opaque) id = texelFetch(opaque_ids, at, 0).xy;
    const vec4 sum = imageLoad(color, at);
    if (id.x == 0) {
        nothing(at);
        const float apart = frame.backdrop_apart != 0 ? reaches.w : 0;
        imageStore(color, at, sum + push.weight * vec4((1 - apart) * here * background_radiance(direction),
                                                       apart * seen_of(here)));
        imageStore(through, at, vec4(0));
        return;
    }
    const uint draw = id.x - 1;
    Triangle triangle;
    Surface s = surface_at(draw, id.y, origin, direction, frame.pixel_width, frame.pixel_spread, triangle);
    if (materials.at[draws.at[draw].material].layered != 0) add_layers(triangle, draws.at[draw].material, s);
    bool behind = false;
    vec3 unlit_behind = vec3(0);
    if (s.model == GNOMON_MODEL_CATCHER) {
        // It shows what is behind it where nothing keeps light from it (show_behind in shading.cpp).
        s.model = GNOMON_MODEL_METALLIC_ROUGHNESS;
        s.specular = vec3(0);
        behind = frame.backdrop_apart != 0 && reaches.w > 0.5;
        if (behind) {
            const bool lit = min(frame.open_irradiance.x, min(frame.open_irradiance.y, frame.open_irradiance.z)) > 0;
            s.diffuse = s.ambient = lit ? 3.14159265 / frame.open_irradiance : vec3(0);
            unlit_behind = lit ? vec3(0) : vec3(1);
        } else if (frame.open_irradiance != vec3(0))
            s.diffuse = s.ambient = background_radiance(direction) * 3.14159265 / max(frame.open_irradiance, vec3(1e-6));
    }

    vec3 own = s.emissive * s.coverage + unlit_behind;
    own += ambient_light(s) * s.coverage + unresolved_mirror(s);
    imageStore(color, at, sum + image_light(push.weight * here * own, behind));
    imageStore(share, at, vec4(push.weight * here, behind ? 1 : 0));
    const vec3 passed = before_opaque ? passes(s) : vec3(0);
    const float bent = max(passed.x, max(passed.y, passed.z)) - s.uncovered;
    imageStore(through, at, vec4(here * passed, bent > 0 ? reaches.w * s.uncovered / (s.uncovered + bent) : reaches.w));
    imageStore(g_position, at, vec4(s.position, dot(s.position - frame.eye, frame.forward)));
    imageStore(g_normal, at, vec4(s.normal, s.roughness));
    imageStore(g_geometric, at, vec4(s.geometric_normal, s.coverage));
    imageStore(g_smooth, at, vec4(s.smooth_normal, s.smooth_height));
    imageStore(g_diffuse, at, vec4(s.diffuse, float(s.model)));
    imageStore(g_specular, at, vec4(s.specular, s.transmitted == vec3(0) ? 0 : s.front || s.thin ? s.ior : 1 / s.ior));
    imageStore(g_ids, at, uvec4(draws.at[draw].object + 1, draws.at[draw].first_triangle + id.y, 0, 0));
}
