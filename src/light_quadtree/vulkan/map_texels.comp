// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Converts ids to texels of a light map: position, normal, depth, area and flux where the texel's ray hits its
// triangle, by the formulas of LightMap::cast_tile and diffuse.cpp.
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
#include "gpu_scene/light.glsl"
#include "light_quadtree/vulkan/map_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 7, scalar) readonly buffer Positions { float at[]; } positions;
layout(binding = 8, scalar) readonly buffer Indices { uint at[]; } indices;
layout(binding = 9, scalar) readonly buffer Lights { GpuLight at[]; } lights;
layout(binding = 10, scalar) readonly buffer Views { GpuMapView at[]; } views;
layout(binding = 11) uniform utexture2D ids;
layout(binding = 12, scalar) writeonly buffer Nodes { GpuNode at[]; } nodes;
layout(push_constant, scalar) uniform Push { TexelPush push; };

#include "light_quadtree/vulkan/map_nodes.glsl"

const float k_pi = 3.14159265358979;

vec3 position_of(uint vertex)
{
    return vec3(positions.at[3 * vertex], positions.at[3 * vertex + 1], positions.at[3 * vertex + 2]);
}

vec3 exitance_per_irradiance(uint object, GpuMaterial m, uvec3 corner, vec3 weight)
{
    if (m.model == GNOMON_MODEL_UNLIT) return vec3(0);
    vec4 base = vec4(m.base_color, 1), other = vec4(1);
    for (int which = 0; which < 2; ++which) {
        const GpuTextureUse use = which == 0 ? m.base_color_texture : m.metallic_roughness_texture;
        if (use.texture == GNOMON_NONE || objects.at[object].texcoords[use.texcoord] == GNOMON_NONE) continue;
        const uint first = objects.at[object].texcoords[use.texcoord];
        const vec2 uv = weight.x * texcoords.at[first + corner.x] + weight.y * texcoords.at[first + corner.y] +
                        weight.z * texcoords.at[first + corner.z];
        const vec4 texel = texture_sample(use.texture, apply(use, uv), 0);
        if (which == 0)
            base *= texel;
        else
            other = texel;
    }
    if (m.model == GNOMON_MODEL_WHITTED) return k_pi * base.xyz;
    const uint color = objects.at[object].colors;
    if (color != GNOMON_NONE)
        base *= weight.x * colors.at[color + corner.x] + weight.y * colors.at[color + corner.y] +
                weight.z * colors.at[color + corner.z];
    return base.xyz * ((1 - m.metallic * other.z) * (1 - m.transmission));
}

GpuNode texel_at(GpuMapView view, uvec2 at, uvec2 id)
{
    GpuNode texel = GpuNode(vec3(0), vec3(0), 0, 0, vec3(0), 0);
    const vec2 clip = (vec2(at) + 0.5) * (2.0 / float(1u << view.levels)) - 1;
    const vec3 off = clip.x * view.across + clip.y * view.down;
    const vec3 along = view.perspective != 0 ? view.forward + off : view.forward;
    const vec3 origin = view.perspective != 0 ? view.origin : view.origin + off;
    const float reach = length(along);
    const vec3 direction = along / reach;

    const GpuDraw draw = draws.at[id.x - 1];
    const uint first = objects.at[draw.object].first_index + 3 * (draw.first_triangle + id.y);
    const uvec3 corner = uvec3(indices.at[first], indices.at[first + 1], indices.at[first + 2]);
    const mat4 to_world = objects.at[draw.object].to_world;
    vec3 p[3];
    for (int c = 0; c < 3; ++c)
        p[c] = vec3(to_world * vec4(position_of(objects.at[draw.object].positions + corner[c]), 1));

    // Intersect the ray with the triangle's plane; use the triangle's centroid if it is seen edge-on.
    const vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    const vec3 normal = cross(e1, e2);
    const float size = length(normal);
    if (!(size > 0)) return texel;
    const vec3 across = cross(direction, e2), from = origin - p[0], other = cross(from, e1);
    const float determinant = dot(e1, across);
    float u = dot(from, across) / determinant, v = dot(direction, other) / determinant;
    float t = dot(e2, other) / determinant;
    if (determinant == 0 || isnan(u + v + t) || isinf(u + v + t)) {
        u = v = 1 / 3.0;
        t = dot((p[0] + p[1] + p[2]) / 3 - origin, direction);
    }
    u = clamp(u, 0, 1), v = clamp(v, 0, 1);
    const vec3 weight = vec3(max(0, 1 - u - v), u, v);
    texel.position = weight.x * p[0] + weight.y * p[1] + weight.z * p[2];
    if (view.leaves_out != 0) {
        const vec4 near = view.near_clip * vec4(texel.position, 1);
        if (abs(near.x) <= 1 && abs(near.y) <= 1) return GpuNode(vec3(0), vec3(0), 0, 0, vec3(0), 0);
    }
    texel.normal = normal / size;
    float cosine = -dot(texel.normal, direction);
    if (cosine < 0) texel.normal = -texel.normal, cosine = -cosine;

    // Compute the texel's area on the surface, and the flux that leaves it.
    const float facing_area = view.perspective != 0
                                  ? view.cell * length(view.forward) / (reach * reach * reach) * t * t
                                  : view.cell;
    texel.depth = dot(texel.position - view.origin, normalize(view.forward)) / view.depth_range;
    texel.area = facing_area / max(cosine, push.least_cosine);
    vec3 to_light, irradiance;
    if (!illuminate(lights.at[view.light], texel.position, to_light, irradiance)) irradiance = vec3(0);
    texel.flux = exitance_per_irradiance(draw.object, materials.at[draw.material], corner, weight) * irradiance * facing_area;
    texel.members = 1;
    return texel;
}

void main()
{
    const GpuMapView view = views.at[push.view];
    const uvec2 at = gl_GlobalInvocationID.xy + uvec2(view.dirty[0], view.dirty[1]);
    if (at.x >= view.dirty[2] || at.y >= view.dirty[3]) return;
    const uvec2 id = texelFetch(ids, ivec2(at), 0).xy;
    const uint node = node_of(view, view.levels, at.x, at.y);
    if (id.x == 0 || view.on == 0)
        nodes.at[node] = GpuNode(vec3(0), vec3(0), 0, 0, vec3(0), 0);
    else
        nodes.at[node] = texel_at(view, at, id);
}
