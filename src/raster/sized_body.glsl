// SPDX-License-Identifier: Apache-2.0
// Computes the direct light of lights with size at each surface: the closed form (polygon_light.glsl) times the visible
// share. Formulas: src/trace/sized_lighting.cpp. The body of sized.comp and sized_closer.comp.
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "raster/raster_shared.h"
#include "raster/sized_shared.h"
#include "shadow_textures/vulkan/textures_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, scalar) readonly buffer Frame { RasterFrame frame; };
layout(binding = 1, rgba32f) uniform image2D sized;
layout(binding = 2) uniform texture2D share;
layout(binding = 3) uniform texture2D g_position;
layout(binding = 4) uniform texture2D g_normal;
layout(binding = 5) uniform texture2D g_geometric;
layout(binding = 6) uniform texture2D g_diffuse;
layout(binding = 7) uniform texture2D g_specular;
layout(binding = 8) uniform utexture2D g_ids;
layout(binding = 9, scalar) readonly buffer SizedLights { SizedLightRecord sized_lights[]; };
layout(binding = 10, scalar) readonly buffer SizedFaces { SizedFaceRecord sized_faces[]; };
layout(binding = 11, scalar) readonly buffer SizedPlaces { SizedPlaceRecord sized_places[]; };
layout(binding = 12, scalar) readonly buffer SizedCells { vec3 sized_cells[]; };
layout(binding = 13, scalar) readonly buffer LobeFits { LobeFit lobe_fits[]; };
layout(binding = 14, scalar) readonly buffer LobeAlbedos { vec2 lobe_albedos[]; };
layout(binding = 15, scalar) readonly buffer ViewPlaces { SizedPlaceRecord view_places[]; };   // by light of light_records
layout(binding = 16) uniform sampler2DArray light_depth;
layout(binding = 18, scalar) readonly buffer ViewRecords { ViewRecord view_records[]; };
layout(binding = 19, scalar) readonly buffer LightRecords { LightRecord light_records[]; };
#ifndef GNOMON_CLOSER
layout(binding = 17) uniform usampler2DArray light_item;
layout(binding = 20, scalar) readonly buffer Places { TexturePlace places[]; };
layout(binding = 21, scalar) readonly buffer Textures { uint textures[]; };
layout(binding = 22, scalar) readonly buffer Casts { uint casts[]; };
#endif
layout(binding = 24) uniform texture2D g_smooth;
layout(binding = 23, scalar) readonly buffer Shares { vec2 shares[]; };   // light by light, pixel by pixel
layout(push_constant, scalar) uniform Push { SizedPush push; };
#define lookup push.look_up

#include "raster/image_light.glsl"
#include "raster/mirror.glsl"
#include "raster/polygon_light.glsl"
#ifdef GNOMON_CLOSER
#include "shadow_textures/vulkan/view_of_light.glsl"
#include "raster/percentage_closer.glsl"
#else
#include "shadow_textures/vulkan/lookup.glsl"
#include "shadow_textures/vulkan/smooth_horizon.glsl"
#endif

// The fraction of the diffuse layer's light that a refracting glTF surface mirrors instead.
float mirrored_part(Point p, float eta)
{
    return eta > 0 && p.model == GNOMON_MODEL_METALLIC_ROUGHNESS ? fresnel_dielectric(clamp(dot(p.normal, p.to_viewer), 0, 1), eta) : 0;
}

void main()
{
    const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(frame.width) || at.y >= int(frame.height)) return;
    const vec4 part_of_image = texelFetch(share, at, 0);
    const vec3 part = part_of_image.xyz;
    const vec4 diffuse = texelFetch(g_diffuse, at, 0);
    if (part == vec3(0) || uint(diffuse.w) == GNOMON_MODEL_UNLIT) {
        imageStore(sized, at, vec4(0));   // in every batch
        return;
    }
    const vec4 normal = texelFetch(g_normal, at, 0), geometric = texelFetch(g_geometric, at, 0),
               specular = texelFetch(g_specular, at, 0);
    Point p;
    p.position = texelFetch(g_position, at, 0).xyz;
    p.normal = normal.xyz, p.roughness = normal.w;
    p.geometric = geometric.xyz, p.coverage = geometric.w;
    const vec4 smooth_at = texelFetch(g_smooth, at, 0);
    p.smooth_normal = smooth_at.xyz;
    p.diffuse = diffuse.xyz, p.model = uint(diffuse.w);
    p.specular = specular.xyz;
    p.to_viewer = frame.orthographic != 0 ? -frame.forward : normalize(frame.eye - p.position);
    p.lift = GNOMON_LIFT_PER_COORDINATE * largest_of(p.position);
    const uint object = texelFetch(g_ids, at, 0).x - 1;

    // Reflections are not traced, so that the lobes of smooth surfaces show lights as well.
    const bool has_lobe = p.model == GNOMON_MODEL_METALLIC_ROUGHNESS && p.specular != vec3(0) && specular.w == 0 &&
                          dot(p.normal, p.to_viewer) >= GNOMON_LOBE_LEAST_VIEW;
    p.roughness = max(p.roughness, GNOMON_LOBE_LEAST_ROUGHNESS);
    Lobe lobe;
    lobe.to_cosine = mat3(1), lobe.scale = 0, lobe.albedo = vec3(0);
    if (has_lobe) lobe = lobe_of(p);
    const vec3 below = has_lobe ? vec3(1) - glossy_albedo(p) : vec3(1 - mirrored_part(p, specular.w));
    const vec3 reflectance = p.diffuse * below * (p.coverage / k_pi);
    if (!has_lobe && reflectance == vec3(0)) {
        imageStore(sized, at, vec4(0));
        return;
    }

    vec3 sum = vec3(0);
    const uint pixel = uint(at.y) * frame.width + uint(at.x);
    for (uint l = 0; l < push.lights; ++l) {
        const SizedLightRecord light = sized_lights[push.first_light + l];
        if (below_horizon(p, light)) continue;
        vec2 share_here = vec2(0);
        if (light.proven != 0) {
            share_here = shares[l * frame.width * frame.height + pixel];
            if (share_here == vec2(0)) continue;
        }
        // Sum the places that have views: what they bring, and what of it is visible. Of a distant cluster, sum all
        // places; of a light with a cone, all places with and without it.
        const bool distant = is_distant(p, light, push.far);
        Unshadowed arrives = Unshadowed(vec3(0), vec3(0));
        if (!distant) arrives = unshadowed(p, light, lobe, has_lobe);
        if (!distant && arrives.irradiance == vec3(0) && arrives.lobe == vec3(0)) continue;
        vec3 whole[2] = vec3[2](vec3(0), vec3(0)), seen[2] = vec3[2](vec3(0), vec3(0));
        vec3 everywhere[2] = vec3[2](vec3(0), vec3(0)), within[2] = vec3[2](vec3(0), vec3(0));
        const uint places = distant || has_cone(light) ? light.place_count : 0;
        for (uint i = 0; i < places + light.view_count; ++i) {
            vec3 irradiance, reflected;
            const bool viewed = i >= places;
            SizedPlaceRecord place;
            const uint number = viewed ? light.first_view + i - places : light.first_place + i;
            if (viewed)
                place = view_places[number];
            else
                place = sized_places[number];
            const float roughness = viewed ? max(p.roughness, push.least_roughness) : p.roughness;
            float share;
            if (!place_weight(p, light, place, has_lobe, roughness, irradiance, reflected, share)) continue;
            if (!viewed) {
                everywhere[0] += irradiance, everywhere[1] += reflected;
                within[0] += share * irradiance, within[1] += share * reflected;
                continue;
            }
            irradiance *= share, reflected *= share;
            whole[0] += irradiance, whole[1] += reflected;
#ifndef GNOMON_CLOSER
            vec3 point = p.position, facing = p.geometric;
            move_between_horizons(number, smooth_at, point, facing);
            const float visible = light_visibility(number, point, facing, object);
            seen[0] += visible * irradiance, seen[1] += visible * reflected;
#endif
        }
        if (distant) arrives = Unshadowed(within[0], within[1]);
        if (!distant && has_cone(light)) limit_to_cone(within, everywhere, arrives);
        for (uint k = 0; k < 2; ++k)
            for (uint c = 0; c < 3; ++c) seen[k][c] = whole[k][c] > 0 ? min(seen[k][c] / whole[k][c], 1) : 0;
#ifdef GNOMON_CLOSER
        if (push.unshadowed == 0) seen[0] = seen[1] = vec3(percentage_closer(p, light));
#endif
        if (light.proven != 0) seen[0] = vec3(share_here.x), seen[1] = vec3(share_here.y);
        if (push.unshadowed != 0) seen[0] = seen[1] = vec3(1);
        sum += reflectance * arrives.irradiance * seen[0] + arrives.lobe * seen[1];
    }
    vec4 result = image_light(part * sum, part_of_image.w > 0);
    if (push.continued != 0) result += imageLoad(sized, at);
    imageStore(sized, at, result);
}
