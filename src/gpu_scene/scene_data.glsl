// SPDX-License-Identifier: Apache-2.0
// The scene's buffers, and texture sampling as in src/scene/texture.cpp. Shaders that include it first define the
// bindings: GNOMON_OBJECTS ... (see below).
#extension GL_EXT_scalar_block_layout : require
#include "gpu_scene/gpu_scene_shared.h"
#include "scene/footprint_shared.h"

layout(binding = GNOMON_OBJECTS, scalar) readonly buffer Objects { GpuObject at[]; } objects;
layout(binding = GNOMON_DRAWS, scalar) readonly buffer Draws { GpuDraw at[]; } draws;
layout(binding = GNOMON_MATERIALS, scalar) readonly buffer Materials { GpuMaterial at[]; } materials;
layout(binding = GNOMON_TEXTURES, scalar) readonly buffer Textures { GpuTexture at[]; } textures;
layout(binding = GNOMON_TEXELS) uniform samplerBuffer texels;
layout(binding = GNOMON_TEXCOORDS, scalar) readonly buffer Texcoords { vec2 at[]; } texcoords;
layout(binding = GNOMON_COLORS, scalar) readonly buffer Colors { vec4 at[]; } colors;

const uint k_repeat = 0u, k_mirror = 1u;  // scene::Wrap; otherwise clamp
const uint k_nearest = 0u;                 // scene::Filter
const float k_no_sample_more = GNOMON_FOOTPRINT_NO_SAMPLE_MORE, k_one_level = GNOMON_FOOTPRINT_ONE_LEVEL;
const float k_far = GNOMON_FOOTPRINT_FAR;

// The use's transform without its offset, for differences of coordinates.
vec2 apply_to_step(GpuTextureUse use, vec2 uv)
{
    const vec2 s = uv * use.scale;
    return vec2(use.rotation_cos * s.x + use.rotation_sin * s.y, use.rotation_cos * s.y - use.rotation_sin * s.x);
}

vec2 apply(GpuTextureUse use, vec2 uv)
{
    return apply_to_step(use, uv) + use.offset;
}

// Reduces a coordinate to one period before it becomes a texel index.
float reduce(float x, uint wrap)
{
    if (isnan(x) || isinf(x)) return 0;
    if (wrap == k_repeat) return x - floor(x);
    if (wrap == k_mirror) return x - 2 * floor(0.5 * x);
    return clamp(x, -1, 2);
}

int wrap_texel(int i, int size, uint wrap)
{
    if (wrap == k_mirror) {
        const int period = 2 * size;
        i %= period;
        if (i < 0) i += period;
        return i < size ? i : period - 1 - i;
    }
    if (wrap == k_repeat) {
        if (i < 0) i += size;
        if (i >= size) i -= size;
    }
    return clamp(i, 0, size - 1);
}

vec4 level_sample(uint texture_id, int level, vec2 uv, uint filtering)
{
    const int first = int(textures.at[texture_id].first[level]);
    const ivec2 size = ivec2(max(textures.at[texture_id].width >> level, 1u), max(textures.at[texture_id].height >> level, 1u));
    const uint wrap_u = textures.at[texture_id].wrap_u, wrap_v = textures.at[texture_id].wrap_v;
    if (filtering == k_nearest) {
        const ivec2 at = ivec2(floor(uv * vec2(size)));
        return texelFetch(texels, first + wrap_texel(at.y, size.y, wrap_v) * size.x + wrap_texel(at.x, size.x, wrap_u));
    }
    const vec2 at = uv * vec2(size) - 0.5;
    const vec2 low = floor(at), w = at - low;
    const ivec2 i = ivec2(low);
    const int x0 = wrap_texel(i.x, size.x, wrap_u), x1 = wrap_texel(i.x + 1, size.x, wrap_u);
    const int y0 = first + wrap_texel(i.y, size.y, wrap_v) * size.x;
    const int y1 = first + wrap_texel(i.y + 1, size.y, wrap_v) * size.x;
    const vec4 top = texelFetch(texels, y0 + x0) * (1 - w.x) + texelFetch(texels, y0 + x1) * w.x;
    const vec4 bottom = texelFetch(texels, y1 + x0) * (1 - w.x) + texelFetch(texels, y1 + x1) * w.x;
    return top * (1 - w.y) + bottom * w.y;
}

vec2 reduced(uint texture_id, vec2 uv)
{
    return vec2(reduce(uv.x, textures.at[texture_id].wrap_u), reduce(uv.y, textures.at[texture_id].wrap_v));
}

/// @param footprint  in texels, as in scene::Texture::sample
vec4 texture_sample(uint texture_id, vec2 uv, float footprint)
{
    uv = reduced(texture_id, uv);
    const int levels = int(textures.at[texture_id].levels);
    const uint minify = textures.at[texture_id].minify;
    if (!(footprint > 1) || levels == 1)
        return level_sample(texture_id, 0, uv, footprint > 1 ? minify : textures.at[texture_id].magnify);
    const float lod = min(log2(footprint), float(levels - 1));
    const int fine = int(lod);
    const float blend = lod - float(fine);
    const vec4 a = level_sample(texture_id, fine, uv, minify);
    if (blend == 0 || fine + 1 >= levels) return a;
    return a * (1 - blend) + level_sample(texture_id, fine + 1, uv, minify) * blend;
}

vec4 row_sample(uint texture_id, int level, vec2 uv, vec2 diameter, int count, uint filtering)
{
    const vec2 by = diameter / float(count);
    const vec2 first = uv - 0.5 * float(count - 1) * by;
    vec4 sum = vec4(0);
    for (int i = 0; i < count; ++i)
        sum += level_sample(texture_id, level, reduced(texture_id, first + float(i) * by), filtering);
    return sum / float(count);
}

/// Samples over an ellipse with two conjugate diameters in uv units, as scene::sample_ellipse does.
vec4 sample_ellipse(uint texture_id, vec2 uv, vec2 diameter, vec2 other)
{
    // Measure the ellipse in texels of the finest level.
    const vec2 size = vec2(textures.at[texture_id].width, textures.at[texture_id].height);
    const vec2 along = diameter * size, across = other * size;
    const float area = abs(along.x * across.y - along.y * across.x);
    float square = dot(along, along);
    if (dot(across, across) > square) {
        square = dot(across, across);
        diameter = other;
    }
    if (!(abs(uv.x) + abs(uv.y) < k_far && square < k_far * k_far)) return texture_sample(texture_id, uv, sqrt(square));
    // Choose the footprint of each sample, and their number.
    const float k_longest = GNOMON_FOOTPRINT_STRETCH * GNOMON_FOOTPRINT_STRETCH;
    const float most = float(GNOMON_FOOTPRINT_SAMPLES);
    const int levels = int(textures.at[texture_id].levels);
    float footprint = square;
    int count = 1;
    if (square > 1 && levels > 1) {
        footprint = area;
        if (square > k_longest * area) {
            footprint = max(k_longest * area * area, square * square / (most * most)) / square;
            const float wanted = sqrt(square / max(1, footprint));
            count = int(clamp(ceil(wanted - k_no_sample_more), 1, most));
        }
    }
    // Blend the two levels whose texel sizes enclose the footprint's.
    const uint filtering = footprint > 1 ? textures.at[texture_id].minify : textures.at[texture_id].magnify;
    if (filtering == k_nearest) return texture_sample(texture_id, uv, sqrt(footprint));
    const float lod = footprint > 1 ? min(0.5 * log2(footprint), float(levels - 1)) : 0;
    const int fine = int(lod);
    const float beyond = lod - float(fine);
    const float blend = clamp((beyond - k_one_level) / (1 - 2 * k_one_level), 0, 1);
    vec4 sum = vec4(0);
    if (blend < 1) sum = row_sample(texture_id, fine, uv, diameter, count, filtering);
    if (!(blend > 0)) return sum;
    const int needed = int(ceil(0.5 * (1 + beyond) * float(count) - k_no_sample_more));
    return sum * (1 - blend) + row_sample(texture_id, fine + 1, uv, diameter, needed, filtering) * blend;
}

/// Alpha of the finest level, which decides on the holes of masked surfaces.
float texture_alpha(uint texture_id, vec2 uv)
{
    return level_sample(texture_id, 0, reduced(texture_id, uv), textures.at[texture_id].magnify).w;
}
