// SPDX-License-Identifier: Apache-2.0
// Fraction of the light that a surface mirrors, as in Continuation (shading/shading.h).

float fresnel_dielectric(float cosine, float eta)
{
    const float sin2 = (1 - cosine * cosine) / (eta * eta);
    if (sin2 >= 1) return 1;
    const float cos_t = sqrt(1 - sin2);
    const float parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
    const float perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

vec3 rough_fresnel(vec3 specular, float roughness, float cosine)
{
    const float f90 = max(max(1 - roughness, specular.x), max(specular.y, specular.z));
    const float x = 1 - cosine;
    return specular + (vec3(f90) - specular) * (x * x * x * x * x);
}

// Fraction of the mirrored light that the traced frame casts rays for; the rest is unresolved.
float traced_part(float roughness)
{
    const float mirror_roughness = 0.12, matte_roughness = 0.45;
    const float t = clamp((roughness - mirror_roughness) / (matte_roughness - mirror_roughness), 0, 1);
    return 1 - t * t * (3 - 2 * t);
}
