// SPDX-License-Identifier: Apache-2.0
// What rasterised frames show of the layers of materials (src/shading/layers.cpp), as far as one diffuse and one
// specular lobe can: specular, iridescence and transmission as they are; clearcoat as a part of the specular lobe, sheen
// as a part of the diffuse one; absorption over the material's thickness. Anisotropy and dispersion are left out.
// Bodies are seen through without refraction and total reflection. Included after surface.glsl.
#include "shading/sheen_shared.h"

float pow5(float x)
{
    const float x2 = x * x;
    return x2 * x2 * x;
}

float schlick_scalar(float f0, float cosine)
{
    return f0 + (1 - f0) * pow5(1 - clamp(cosine, 0, 1));
}

float f0_of(float inside, float outside)
{
    const float r = (inside - outside) / (inside + outside);
    return r * r;
}

// What the eye makes of an interference of this path difference in nanometres, linear RGB.
vec3 sensitivity(float path, vec3 shift)
{
    const float phase = 6.28318530718 * path * 1e-9;
    const vec3 value = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13), place = vec3(1.6810e+06, 1.7953e+06, 2.2084e+06),
               width = vec3(4.3278e+09, 9.3046e+09, 6.6121e+09);
    vec3 xyz = value * sqrt(6.28318530718 * width) * cos(place * phase + shift) * exp(-phase * phase * width);
    xyz.x += 9.7470e-14 * sqrt(6.28318530718 * 4.5282e+09) * cos(2.2399e+06 * phase + shift.x) *
             exp(-4.5282e+09 * phase * phase);
    xyz /= 1.0685e-7;
    return vec3(dot(vec3(3.2404542, -1.5371385, -0.4985314), xyz), dot(vec3(-0.9692660, 1.8760108, 0.0415560), xyz),
                dot(vec3(0.0556434, -0.2040259, 1.0572252), xyz));
}

// As thin_film_reflectance in src/shading/layers.cpp.
vec3 thin_film_reflectance(vec3 f0, float cosine, float thin_film_ior, float nanometres)
{
    const float k_pi = 3.14159265358979;
    const float t = clamp(nanometres / 0.03, 0, 1);
    const float thin_film = mix(1, thin_film_ior, t * t * (3 - 2 * t));
    const float sine2 = (1 - cosine * cosine) / (thin_film * thin_film);
    if (sine2 > 1) return vec3(1);
    const float cos_inside = sqrt(1 - sine2);
    const float first = schlick_scalar(f0_of(thin_film, 1), cosine), through = 1 - first;
    const float first_shift = thin_film < 1 ? 0 : k_pi;
    vec3 second, shift;
    for (int c = 0; c < 3; ++c) {
        const float root = sqrt(clamp(f0[c], 0, 0.9999));
        const float base = (1 + root) / (1 - root);
        second[c] = schlick_scalar(f0_of(base, thin_film), cos_inside);
        shift[c] = first_shift + (base < thin_film ? k_pi : 0);
    }
    const float path = 2 * thin_film * nanometres * cos_inside;
    const vec3 both = clamp(first * second, 1e-5, 0.9999), amplitude = sqrt(both);
    const vec3 rest = through * through * second / (vec3(1) - both);
    vec3 result = vec3(first) + rest, harmonic = rest - vec3(through);
    for (int m = 1; m <= 2; ++m) {
        harmonic *= amplitude;
        result += harmonic * (2 * sensitivity(float(m) * path, float(m) * shift));
    }
    return clamp(result, 0, 1);
}

// The textures of layers, looked up in one loop as those of materials are.
const int k_specular_color = 0, k_specular = 1, k_transmission = 2, k_thickness = 3, k_iridescence = 4,
          k_iridescence_thickness = 5, k_sheen_color = 6, k_sheen_roughness = 7, k_clearcoat = 8,
          k_clearcoat_roughness = 9, k_metal = 10, k_layer_textures = 11;

void look_up_layers(Triangle t, GpuMaterial m, GpuLayers l, out vec4 texel[k_layer_textures])
{
    const GpuTextureUse uses[k_layer_textures] = GpuTextureUse[k_layer_textures](
        l.specular_color_texture, l.specular_texture, l.transmission_texture, l.thickness_texture,
        l.iridescence_texture, l.iridescence_thickness_texture, l.sheen_color_texture, l.sheen_roughness_texture,
        l.clearcoat_texture, l.clearcoat_roughness_texture, m.metallic_roughness_texture);
    for (int i = 0; i < k_layer_textures; ++i) {
        const GpuTextureUse use = uses[i];
        vec4 found = vec4(1);
        if (has(t, use)) found = look_up(t, use);
        texel[i] = found;
    }
}

const float k_sheen_albedos[GNOMON_SHEEN_ROWS * GNOMON_SHEEN_COLUMNS] =
    float[GNOMON_SHEEN_ROWS * GNOMON_SHEEN_COLUMNS](GNOMON_SHEEN_ALBEDOS);

float sheen_albedo(float cosine, float roughness)
{
    const float down = clamp((roughness - 0.1) / 0.9, 0, 1) * float(GNOMON_SHEEN_ROWS - 1);
    const float across = cosine * float(GNOMON_SHEEN_COLUMNS - 1);
    const int r = min(int(down), GNOMON_SHEEN_ROWS - 2), c = min(int(across), GNOMON_SHEEN_COLUMNS - 2);
    const int at = r * GNOMON_SHEEN_COLUMNS + c;
    return mix(mix(k_sheen_albedos[at], k_sheen_albedos[at + 1], across - float(c)),
               mix(k_sheen_albedos[at + GNOMON_SHEEN_COLUMNS], k_sheen_albedos[at + GNOMON_SHEEN_COLUMNS + 1],
                   across - float(c)),
               down - float(r));
}

#include "raster/emission_cone.glsl"

void add_layers(Triangle t, uint material, inout Surface s)
{
    if (s.model != GNOMON_MODEL_METALLIC_ROUGHNESS) return;
    const GpuMaterial m = materials.at[material];
    const GpuLayers l = layers.at[material];
    const float cosine = clamp(dot(s.normal, s.to_viewer), 0, 1);
    s.thin = true;   // light passes straight
    if (l.emission_outer != GNOMON_NO_CONE) {
        const vec3 axis = normalize(mat3(objects.at[t.object].to_world) * vec3(0, 0, -1));
        s.emissive *= share_of_cone(dot(s.to_viewer, axis), l.emission_outer, l.emission_inner);
    }
    vec4 found[k_layer_textures];
    look_up_layers(t, m, l, found);

    // Split the specular reflectance into the dielectric's part and the metal's, and scale the first.
    const float metallic = m.metallic * found[k_metal].z;
    const float f0 = (m.ior - 1) * (m.ior - 1) / ((m.ior + 1) * (m.ior + 1));
    const vec3 color = l.specular_color * found[k_specular_color].xyz;
    const float strength = l.specular * found[k_specular].w;
    s.specular += (1 - metallic) * (strength * min(f0 * color, vec3(1)) - vec3(f0));
    s.specular = max(s.specular, vec3(0));

    // Move light between the diffuse and the transmitted part as the texture says.
    if (has(t, l.transmission_texture)) {
        const float left = found[k_transmission].x;
        s.diffuse += s.transmitted * (1 - left);
        s.ambient += s.transmitted * (1 - left);
        s.transmitted *= left;
    }
    if (l.thin_walled == 0 && !s.front) s.transmitted *= exp(-l.absorption * (l.thickness * found[k_thickness].y));

    const float thin_film = l.iridescence * found[k_iridescence].x;
    if (thin_film > 0) {
        const float thickness = mix(l.iridescence_thickness_least, l.iridescence_thickness_most,
                                    found[k_iridescence_thickness].y);
        const float rise = min(pow5(1 - cosine), 0.9999);
        const vec3 seen = thin_film_reflectance(s.specular, cosine, l.iridescence_ior, thickness);
        s.specular = mix(s.specular, clamp((seen - rise) / (1 - rise), 0, 1), thin_film);
    }

    const vec3 sheen = l.sheen_color * found[k_sheen_color].xyz;
    if (sheen != vec3(0)) {
        const float albedo = sheen_albedo(cosine, l.sheen_roughness * found[k_sheen_roughness].w);
        const float left = 1 - albedo * max(sheen.x, max(sheen.y, sheen.z));
        s.diffuse = s.diffuse * left + sheen * albedo;
        s.ambient = s.ambient * left + sheen * albedo;
        s.specular *= left;
        s.transmitted *= left;
    }

    // The coat joins the specular lobe, whose width lies between both.
    const float coat = l.clearcoat * found[k_clearcoat].x;
    if (coat > 0) {
        const float mirrored = coat * schlick_scalar(0.04, cosine);
        const float coat_roughness = clamp(l.clearcoat_roughness * found[k_clearcoat_roughness].y, 0, 1);
        const float base = max(s.specular.x, max(s.specular.y, s.specular.z)) * (1 - mirrored);
        s.diffuse *= 1 - mirrored;
        s.ambient *= 1 - mirrored;
        s.emissive *= 1 - mirrored;
        s.transmitted *= 1 - mirrored;
        s.specular = s.specular * (1 - mirrored) + vec3(mirrored);
        s.roughness = mix(s.roughness, coat_roughness, mirrored / max(mirrored + base, 1e-6));
    }
}
