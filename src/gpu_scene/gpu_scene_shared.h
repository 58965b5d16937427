// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_GPU_SCENE_SHARED_H
#define GNOMON_GPU_SCENE_SHARED_H
// The scene's structures for shaders. Layout: scalar, which equals C++'s.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(gpu_scene)

// The value for absence: no texture, no normals, no texture coordinates.
#define GNOMON_NONE 0xffffffffu

/// One object (instance of a mesh). Vertex arrays are indexed from the start of their buffers.
struct GpuObject {
    mat4 to_world;
    vec3 normal_x, normal_y, normal_z;   // columns of the inverse transpose, not normalised
    uint shown;                          // SceneState::object_there
    uint mirrored;                       // the winding in world space is the reverse of the mesh's
    uint positions;
    uint normals;        // or none
    uint texcoords[2];   // each or none
    uint colors;         // or none
    uint first_index;    // of the mesh's triangles
    uint tangents;       // or none
};

/// One part of one object; an indirect draw with the same index.
struct GpuDraw {
    uint object;
    uint material;
    uint first_triangle;   // of the part, in the mesh
    uint count;            // of triangles
    vec3 centre;           // of its bounds, in the object's space
    vec3 extent;           // half the bounds' size
};

struct GpuTextureUse {
    uint texture;   // or none
    uint texcoord;
    vec2 offset, scale;
    float rotation_cos, rotation_sin;
};

#define GNOMON_MODEL_METALLIC_ROUGHNESS 0u
#define GNOMON_MODEL_WHITTED 1u
#define GNOMON_MODEL_UNLIT 2u
#define GNOMON_MODEL_CATCHER 3u   // metallic-roughness, and scene::Material::catches_shadows
#define GNOMON_ALPHA_OPAQUE 0u
#define GNOMON_ALPHA_MASK 1u
#define GNOMON_ALPHA_BLEND 2u

struct GpuMaterial {
    vec3 base_color;
    float alpha;
    vec3 emissive;
    float alpha_cutoff;
    vec3 ambient;
    float metallic;
    vec3 specular;
    float roughness;
    float shine, transmittance, transmission, ior;
    float normal_scale, occlusion_strength;
    uint model, alpha_mode;
    uint layered;   // its GpuLayers counts
    GpuTextureUse base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture, emissive_texture;
};

/// What rasterised frames use of scene::MaterialLayers; one for each material.
#define GNOMON_NO_CONE -2.0f   // as the cosine of the outer angle: emission in all directions

struct GpuLayers {
    vec3 specular_color;
    float specular;
    vec3 sheen_color;
    float sheen_roughness;
    vec3 absorption;   // per metre
    float thickness;
    float clearcoat, clearcoat_roughness;
    float iridescence, iridescence_ior, iridescence_thickness_least, iridescence_thickness_most;
    uint thin_walled;
    float emission_outer, emission_inner;   // cosines of the emission's cone; outer GNOMON_NO_CONE: none
    GpuTextureUse specular_texture, specular_color_texture, clearcoat_texture, clearcoat_roughness_texture,
        sheen_color_texture, sheen_roughness_texture, iridescence_texture, iridescence_thickness_texture,
        transmission_texture, thickness_texture;
};

#define GNOMON_MAX_LEVELS 16

/// A texture; texels of all levels are in one buffer of linear half floats.
struct GpuTexture {
    uint width, height, levels;
    uint wrap_u, wrap_v;    // as scene::Wrap
    uint magnify, minify;   // as scene::Filter
    uint first[GNOMON_MAX_LEVELS];
};

#define GNOMON_LIGHT_POINT 0u
#define GNOMON_LIGHT_SPOT 1u
#define GNOMON_LIGHT_DIRECTIONAL 2u

#define GNOMON_SPOT_SMOOTH 0u
#define GNOMON_SPOT_COSINE 1u
#define GNOMON_SPOT_SMOOTH_COSINE 2u

struct GpuLight {
    vec3 color;
    uint type;
    vec3 position;
    float range;
    vec3 direction;
    uint shown;
    float cos_inner, cos_outer;
    uint constant_falloff;   // else inverse square
    uint profile;            // GNOMON_SPOT_...
    uint of_environment;
};

/// VkDrawIndexedIndirectCommand.
struct GpuDrawCommand {
    uint index_count, instance_count, first_index;
    int vertex_offset;
    uint first_instance;
};

/// Results of one culling.
struct CullCounts {
    uint drawn;
    uint triangles;
};

/// The view against which draws are culled, as push constants.
struct CullPush {
    vec4 planes[6];   // a point is inside where dot(xyz, p) + w >= 0
    uint draws;
    uint classes;   // unused: keeps the size a multiple of 8
};

#ifdef __cplusplus
GNOMON_MEMBERS(GpuObject, to_world, normal_x, normal_y, normal_z, shown, mirrored, positions, normals, texcoords,
               colors, first_index, tangents)
GNOMON_MEMBERS(GpuDraw, object, material, first_triangle, count, centre, extent)
GNOMON_MEMBERS(GpuTextureUse, texture, texcoord, offset, scale, rotation_cos, rotation_sin)
GNOMON_MEMBERS(GpuMaterial, base_color, alpha, emissive, alpha_cutoff, ambient, metallic, specular, roughness, shine,
               transmittance, transmission, ior, normal_scale, occlusion_strength, model, alpha_mode, layered,
               base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture, emissive_texture)
GNOMON_MEMBERS(GpuLayers, specular_color, specular, sheen_color, sheen_roughness, absorption, thickness, clearcoat,
               clearcoat_roughness, iridescence, iridescence_ior, iridescence_thickness_least,
               iridescence_thickness_most, thin_walled, emission_outer, emission_inner, specular_texture,
               specular_color_texture, clearcoat_texture, clearcoat_roughness_texture, sheen_color_texture,
               sheen_roughness_texture, iridescence_texture, iridescence_thickness_texture, transmission_texture,
               thickness_texture)
GNOMON_MEMBERS(GpuTexture, width, height, levels, wrap_u, wrap_v, magnify, minify, first)
GNOMON_MEMBERS(GpuLight, color, type, position, range, direction, shown, cos_inner, cos_outer, constant_falloff,
               profile, of_environment)
GNOMON_MEMBERS(GpuDrawCommand, index_count, instance_count, first_index, vertex_offset, first_instance)
GNOMON_MEMBERS(CullCounts, drawn, triangles)
GNOMON_MEMBERS(CullPush, planes, draws, classes)
#endif

GNOMON_SHARED_END
#endif
