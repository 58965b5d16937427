// SPDX-License-Identifier: Apache-2.0
// Makes a point to shade from a pixel's triangle, as src/shading/surface.cpp does. Included after
// gpu_scene/scene_data.glsl, with `positions` and `normals` (three floats per vertex), `tangents` (four) and `indices`
// declared.

#include "shading/lobe_shared.h"

struct Surface {
    vec3 position;
    vec3 geometric_normal;
    vec3 normal;
    vec3 smooth_normal;    // of the smooth horizon (ray/smooth_surface.h)
    float smooth_height;   // of the smooth surface above the triangle
    vec3 to_viewer;
    bool front;
    uint model;
    vec3 diffuse, specular, ambient, emissive, transmitted;
    float roughness;   // of metallic-roughness; else Phong's exponent
    float coverage, ior;
    float uncovered;   // of what is straight behind
    bool thin;
    float distance;
};

// The triangle, and the place on it where the ray meets it.
struct Triangle {
    uint object;
    uvec3 corner;   // vertices of the mesh
    vec3 p[3];
    float u, v;
    vec2 along, across;   // the pixel's footprint, as steps in u and v
};

vec3 fetch3(uint which, uint vertex)   // 0: position, 1: normal
{
    const uint at = 3 * vertex;
    return which == 0 ? vec3(positions.at[at], positions.at[at + 1], positions.at[at + 2])
                      : vec3(normals.at[at], normals.at[at + 1], normals.at[at + 2]);
}

vec3 unit_or(vec3 v, vec3 otherwise)
{
    const float square = dot(v, v);
    return square > 0 && !isinf(square) ? v * (1 / sqrt(square)) : otherwise;
}

bool has(Triangle t, GpuTextureUse use)
{
    return use.texture != GNOMON_NONE && objects.at[t.object].texcoords[use.texcoord] != GNOMON_NONE;
}

vec4 look_up(Triangle t, GpuTextureUse use)
{
    const uint first = objects.at[t.object].texcoords[use.texcoord];
    const vec2 t0 = texcoords.at[first + t.corner.x], t1 = texcoords.at[first + t.corner.y],
               t2 = texcoords.at[first + t.corner.z];
    const vec2 a = t1 - t0, b = t2 - t0;
    return sample_ellipse(use.texture, apply(use, (1 - t.u - t.v) * t0 + t.u * t1 + t.v * t2),
                          apply_to_step(use, t.along.x * a + t.along.y * b),
                          apply_to_step(use, t.across.x * a + t.across.y * b));
}

// The textures of a material. They are looked up in one loop, because compilers expand a look-up wherever it is called,
// which makes some of them take seconds.
const int k_base_color = 0, k_metallic_roughness = 1, k_emissive = 2, k_occlusion = 3, k_normals = 4, k_own_textures = 5;

// One where there is no texture.
void look_up_own(Triangle t, GpuMaterial m, out vec4 texel[k_own_textures])
{
    const GpuTextureUse uses[k_own_textures] =
        GpuTextureUse[k_own_textures](m.base_color_texture, m.metallic_roughness_texture, m.emissive_texture,
                                      m.occlusion_texture, m.normal_texture);
    for (int i = 0; i < k_own_textures; ++i) {
        const GpuTextureUse use = uses[i];
        vec4 found = vec4(1);
        if (has(t, use)) found = look_up(t, use);
        texel[i] = found;
    }
}

// Finds the footprint, as find_footprint in src/shading/surface.cpp.
void find_footprint(inout Triangle t, float double_area, vec3 normal, vec3 direction, float width)
{
    const float k_least_sine = 1e-4, k_least_cosine = 0.02;
    t.along = t.across = vec2(0);
    if (!(double_area > 0)) return;
    const vec3 e1 = t.p[1] - t.p[0], e2 = t.p[2] - t.p[0];
    vec3 forward = direction, sideward = cross(normal, direction);
    float square = dot(sideward, sideward);
    if (square < k_least_sine * k_least_sine) {
        forward = e1;
        sideward = cross(normal, e1);
        square = dot(sideward, sideward);
        if (!(square > 0)) return;
    }
    const float across = width / (double_area * sqrt(square));
    const float along = across / max(abs(dot(normal, direction)), k_least_cosine);
    t.along = along * vec2(dot(e2, sideward), -dot(e1, sideward));
    t.across = across * vec2(-dot(e2, forward), dot(e1, forward));
}

// The directions of red and of green of a normal map, as in shading/surface.cpp; false where there are none.
bool find_tangents(Triangle t, GpuTextureUse use, bool front, vec3 normal, out vec3 tangent, out vec3 bitangent)
{
    const uint own = objects.at[t.object].tangents;
    if (own != GNOMON_NONE) {
        const mat3 to_world = mat3(objects.at[t.object].to_world);
        vec3 sum = vec3(0);
        float sense = 0;
        for (int c = 0; c < 3; ++c) {
            const vec4 at = tangents.at[own + t.corner[c]];
            const float weight = c == 0 ? max(0, 1 - t.u - t.v) : c == 1 ? t.u : t.v;
            const vec3 turned = to_world * at.xyz;
            sum += weight * unit_or(turned, at.xyz);
            sense += weight * at.w;
        }
        tangent = unit_or(sum - normal * dot(normal, sum), vec3(0));
        const bool mirrored = objects.at[t.object].mirrored != 0;
        bitangent = cross(normal, tangent) * (((sense < 0) != mirrored) == front ? -1 : 1);
        return tangent != vec3(0);
    }
    const uint first = objects.at[t.object].texcoords[use.texcoord];
    const vec2 t0 = texcoords.at[first + t.corner.x];
    const vec2 a = apply_to_step(use, texcoords.at[first + t.corner.y] - t0),
               b = apply_to_step(use, texcoords.at[first + t.corner.z] - t0);
    const float determinant = a.x * b.y - a.y * b.x;
    if (determinant == 0) return false;
    const vec3 e1 = t.p[1] - t.p[0], e2 = t.p[2] - t.p[0];
    const vec3 along_u = (e1 * b.y - e2 * a.y) / determinant, along_v = (e2 * a.x - e1 * b.x) / determinant;
    tangent = unit_or(along_u - normal * dot(normal, along_u), vec3(0));
    bitangent = cross(normal, tangent);
    if (dot(bitangent, along_v) > 0) bitangent = -bitangent;
    return tangent != vec3(0);
}

vec3 mapped_normal(Triangle t, GpuTextureUse use, vec4 texel, float normal_scale, bool front, vec3 normal)
{
    vec3 tangent, bitangent;
    if (!find_tangents(t, use, front, normal, tangent, bitangent)) return normal;
    // A bump on the front is a dent on the back.
    const float scale = front ? normal_scale : -normal_scale;
    const vec3 n = (2 * texel.xyz - 1) * vec3(scale, scale, 1);
    return unit_or(tangent * n.x + bitangent * n.y + normal * n.z, normal);
}

/// @param found  by look_up_own()
void fill_material(Triangle t, GpuMaterial m, vec4 found[k_own_textures], inout Surface s)
{
    s.model = m.model;
    s.coverage = 1;
    s.uncovered = 0;
    s.thin = false;
    s.ior = 1;
    s.transmitted = s.ambient = s.emissive = s.diffuse = s.specular = vec3(0);
    const vec4 texel = found[k_base_color];
    if (m.model == GNOMON_MODEL_WHITTED) {
        s.diffuse = m.base_color * texel.xyz;
        s.ambient = m.ambient * texel.xyz;
        s.specular = m.specular;
        s.roughness = m.shine;
        if (m.transmittance > 0) {
            s.transmitted = vec3(m.transmittance);
            s.ior = m.ior;
        }
        return;
    }
    vec3 base = m.base_color;
    float alpha = m.alpha;
    const uint color = objects.at[t.object].colors;
    if (color != GNOMON_NONE) {
        const vec4 c = (1 - t.u - t.v) * colors.at[color + t.corner.x] + t.u * colors.at[color + t.corner.y] +
                       t.v * colors.at[color + t.corner.z];
        base *= c.xyz;
        alpha *= c.w;
    }
    base *= texel.xyz;
    alpha *= texel.w;
    const float metallic = m.metallic * found[k_metallic_roughness].z;
    const float roughness = m.roughness * found[k_metallic_roughness].y;
    s.emissive = m.emissive * found[k_emissive].xyz;
    if (m.alpha_mode == GNOMON_ALPHA_BLEND) s.coverage = clamp(alpha, 0, 1);
    s.uncovered = 1 - s.coverage;
    s.roughness = clamp(roughness, 0, 1);
    if (m.model == GNOMON_MODEL_UNLIT) {
        s.emissive = base;
        return;
    }
    const float f0 = (m.ior - 1) / (m.ior + 1);
    s.specular = mix(vec3(f0 * f0), base, metallic);
    s.diffuse = base * ((1 - metallic) * (1 - m.transmission));
    s.transmitted = base * ((1 - metallic) * m.transmission);
    s.ior = m.ior;
    s.ambient = s.diffuse;
    if (has(t, m.occlusion_texture))
        s.ambient *= 1 + m.occlusion_strength * (found[k_occlusion].x - 1);
}

// Finds where the ray meets the triangle's plane [Moller and Trumbore 1997]; the triangle's middle where it is seen
// edge-on.
void meet(inout Triangle t, vec3 origin, vec3 direction, out float distance)
{
    const vec3 e1 = t.p[1] - t.p[0], e2 = t.p[2] - t.p[0];
    const vec3 across = cross(direction, e2);
    const float determinant = dot(e1, across);
    const vec3 from = origin - t.p[0];
    const vec3 other = cross(from, e1);
    t.u = dot(from, across) / determinant;
    t.v = dot(direction, other) / determinant;
    distance = dot(e2, other) / determinant;
    if (determinant == 0 || isnan(t.u + t.v + distance) || isinf(t.u + t.v + distance)) {
        t.u = t.v = 1 / 3.0;
        distance = dot((t.p[0] + t.p[1] + t.p[2]) / 3 - origin, direction);
    }
    // Clamp, because the pixel's centre may lie beyond an edge by rounding.
    t.u = clamp(t.u, 0, 1);
    t.v = clamp(t.v, 0, 1);
}

/// @param cone_width, cone_spread  of the pixel's ray at its origin
Surface surface_at(uint draw, uint primitive, vec3 origin, vec3 direction, float cone_width, float cone_spread,
                   out Triangle t)
{
    t.object = draws.at[draw].object;
    const uint object = t.object;
    const uint at = objects.at[object].first_index + 3 * (draws.at[draw].first_triangle + primitive);
    t.corner = uvec3(indices.at[at], indices.at[at + 1], indices.at[at + 2]);
    const mat4 to_world = objects.at[object].to_world;
    for (int c = 0; c < 3; ++c)
        t.p[c] = vec3(to_world * vec4(fetch3(0, objects.at[object].positions + t.corner[c]), 1));

    Surface s;
    meet(t, origin, direction, s.distance);
    const float w = max(0, 1 - t.u - t.v);
    s.position = w * t.p[0] + t.u * t.p[1] + t.v * t.p[2];
    s.to_viewer = -direction;

    // Find which side was met. A mirroring transform reverses the winding, not inside and outside.
    const vec3 normal = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
    const float double_area = sqrt(dot(normal, normal));
    vec3 outward = double_area > 0 ? normal / double_area : -direction;
    if (objects.at[object].mirrored != 0) outward = -outward;
    s.front = dot(outward, direction) < 0;
    s.geometric_normal = s.front ? outward : -outward;
    s.normal = s.smooth_normal = s.geometric_normal;
    s.smooth_height = 0;
    const uint first = objects.at[object].normals;
    if (first != GNOMON_NONE) {
        // Normalise at the corners first, as baked vertices are: a non-uniform scale would weight them differently.
        const mat3 turn = mat3(objects.at[object].normal_x, objects.at[object].normal_y, objects.at[object].normal_z);
        vec3 turned = vec3(0), lift = vec3(0);
        for (int c = 0; c < 3; ++c) {
            const vec3 n = turn * fetch3(1, first + t.corner[c]);
            const vec3 unit = unit_or(n, n);
            const float weight = c == 0 ? w : c == 1 ? t.u : t.v, above = dot(t.p[c] - s.position, unit);
            turned += weight * unit;
            if (dot(unit, s.geometric_normal) > 0 ? above > 0 : above < 0) lift += weight * above * unit;
        }
        s.normal = unit_or(s.front ? turned : -turned, s.geometric_normal);
        const float away = dot(s.normal, s.to_viewer);
        const vec3 bent = away < GNOMON_LOBE_LEAST_VIEW
                              ? unit_or(s.normal - (away - GNOMON_BENT_VIEW) * s.to_viewer, s.geometric_normal)
                              : s.normal;
        if (dot(bent, s.geometric_normal) > 0.25) s.smooth_normal = bent;
        // As in ray/smooth_surface.cpp, at most half of the triangle's shortest altitude.
        const float longest = max(max(distance(t.p[0], t.p[1]), distance(t.p[1], t.p[2])), distance(t.p[2], t.p[0]));
        const float height = length(lift), most = longest > 0 ? 0.5 * double_area / longest : 0;
        if (height > most) lift *= most / height;
        s.smooth_height = dot(lift, s.smooth_normal);
    }

    find_footprint(t, double_area, s.geometric_normal, direction, cone_width + s.distance * cone_spread);
    const GpuMaterial material = materials.at[draws.at[draw].material];
    vec4 texels_found[k_own_textures];
    look_up_own(t, material, texels_found);
    if (has(t, material.normal_texture))
        s.normal = mapped_normal(t, material.normal_texture, texels_found[k_normals], material.normal_scale, s.front,
                                 s.normal);
    const float facing = dot(s.normal, s.to_viewer);
    if (facing < GNOMON_LOBE_LEAST_VIEW)
        s.normal = unit_or(s.normal - (facing - GNOMON_BENT_VIEW) * s.to_viewer, s.geometric_normal);
    fill_material(t, material, texels_found, s);
    return s;
}
