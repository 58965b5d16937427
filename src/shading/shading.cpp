// SPDX-License-Identifier: Apache-2.0
#include "shading/shading.h"

#include <algorithm>

#include "shading/layers.h"

namespace gnomon::shading {

namespace {

constexpr float k_inverse_pi = static_cast<float>(1 / k_pi);
constexpr float k_faintest_highlight = -7;    // exponent: e^-7 is below 1/1000
constexpr float k_min_alpha = 2e-3f;          // smallest GGX alpha; at 0, the highlight of a point light would vanish
constexpr float k_mirror_roughness = 0.12f;   // up to here reflections are sharp, and one ray gets all of them
constexpr float k_matte_roughness = 0.45f;    // from here on reflections are too blurred for one ray

// Fades out light above the shading normal's horizon but near that of vertex normals [Chiang et al. 2019, eq. 4].
// DEVIATION(Chiang2019, eq. 4): the horizon is the smooth one, not the triangle's, which would show facets.
float soften_terminator(float cos_horizon, float cos_shading, float cos_between)
{
    if (cos_between >= 0.99999f) return 1;
    const float g = std::min(1.0f, cos_horizon / std::max(cos_shading * cos_between, 1e-6f));
    return g * (1 + g * (1 - g));
}

glm::vec3 schlick(const glm::vec3& f0, float cosine, float f90 = 1)
{
    const float x = 1 - std::clamp(cosine, 0.0f, 1.0f);
    const float x2 = x * x;
    return f0 + (glm::vec3(f90) - f0) * (x2 * x2 * x);
}

glm::vec3 phong(const SurfacePoint& s, const glm::vec3& to_light, float cosine)
{
    glm::vec3 result = s.diffuse * cosine;
    if (s.shine > 0 && s.specular != glm::vec3(0)) {
        const glm::vec3 mirrored = 2 * cosine * s.normal - to_light;
        const float aligned = glm::dot(mirrored, s.to_viewer);
        // Skip the power where it is below a quarter of a step of 8 bits: a^n <= e^(n (a - 1)).
        if (aligned > 0 && s.shine * (aligned - 1) > k_faintest_highlight)
            result += s.specular * std::pow(aligned, s.shine);
    }
    return result;
}

glm::vec3 ggx(const SurfacePoint& s, const glm::vec3& to_light, float cosine)
{
    const glm::vec3 half = glm::normalize(to_light + s.to_viewer);
    const float n_h = std::clamp(glm::dot(s.normal, half), 0.0f, 1.0f);
    const float n_v = std::max(glm::dot(s.normal, s.to_viewer), 1e-4f);
    const float v_h = std::clamp(glm::dot(s.to_viewer, half), 0.0f, 1.0f);
    const glm::vec3 fresnel = schlick(s.specular, v_h, s.f90);

    // D: Trowbridge-Reitz. V: height-correlated Smith, which includes 1 / (4 n_l n_v) [glTF 2.0, B.3.2].
    const float alpha = std::max(s.roughness * s.roughness, k_min_alpha);
    const float a2 = alpha * alpha;
    const float d = n_h * n_h * (a2 - 1) + 1;
    const float distribution = a2 / (static_cast<float>(k_pi) * d * d);
    const float visibility =
        0.5f / (cosine * std::sqrt(n_v * n_v * (1 - a2) + a2) + n_v * std::sqrt(cosine * cosine * (1 - a2) + a2));
    const float lobe = s.layers.anisotropy > 0 ? anisotropic_lobe(s, to_light) : distribution * visibility;
    return (s.diffuse * (glm::vec3(1) - fresnel) * k_inverse_pi + fresnel * lobe) * cosine;
}

// Computes a mirror direction. A shading normal may send it below the surface; it is moved back to just above.
glm::vec3 mirrored(const SurfacePoint& s, const glm::vec3& normal)
{
    const glm::vec3 direction = -s.to_viewer;
    const float cosine = std::clamp(glm::dot(normal, s.to_viewer), 0.0f, 1.0f);
    glm::vec3 result = direction + 2 * cosine * normal;
    if (const float above = glm::dot(result, s.geometric_normal); above <= 0)
        result += (1e-3f - above) * s.geometric_normal;
    return glm::normalize(result);
}

// The dielectric's Fresnel reflectance, between the surface's own reflectance at normal incidence and at grazing
// angles.
glm::vec3 scaled_fresnel(const SurfacePoint& s, float fresnel)
{
    const float root = (s.ior - 1) / (s.ior + 1), f0 = root * root;
    const float t = f0 < 1 ? std::clamp((fresnel - f0) / (1 - f0), 0.0f, 1.0f) : 1;
    return glm::clamp(s.specular + (glm::vec3(s.f90) - s.specular) * t, 0.0f, 1.0f);
}

// Adds what the coat mirrors. There is one mirror ray for coat and base; it follows the one that reflects more.
void add_coat(const SurfacePoint& s, Continuation& c)
{
    if (!(s.layers.coat > 0)) return;
    const float traced = traced_part(s.layers.coat_roughness);
    c.coat_reflected = s.layers.coat * traced;
    c.coat_unresolved = s.layers.coat * (1 - traced);
    if (c.coat_reflected >= std::max({c.reflected_weight.x, c.reflected_weight.y, c.reflected_weight.z}))
        c.reflected = mirrored(s, s.layers.coat_normal);
    c.reflected_weight += c.coat_reflected;
    c.unresolved_weight += c.coat_unresolved;
}

}   // namespace

float traced_part(float roughness)
{
    const float t = std::clamp((roughness - k_mirror_roughness) / (k_matte_roughness - k_mirror_roughness), 0.0f, 1.0f);
    return 1 - t * t * (3 - 2 * t);
}

float fresnel_dielectric(float cosine, float eta)
{
    const float sin2 = (1 - cosine * cosine) / (eta * eta);
    if (sin2 >= 1) return 1;
    const float cos_t = std::sqrt(1 - sin2);
    const float parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
    const float perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

glm::vec3 reflect_light(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance)
{
    const float cosine = glm::dot(s.normal, to_light);
    const float cos_horizon = glm::dot(s.smooth_normal, to_light);
    if (cosine <= 0 || cos_horizon <= 0) return glm::vec3(0);
    const float soft = soften_terminator(cos_horizon, cosine, glm::dot(s.normal, s.smooth_normal));
    if (s.catches_shadows) return s.diffuse * irradiance * (k_inverse_pi * cosine * s.coverage);
    const glm::vec3 reflectance =
        s.model == scene::ShadingModel::whitted ? phong(s, to_light, cosine) : ggx(s, to_light, cosine);
    const glm::vec3 result = reflectance * irradiance * (soft * s.coverage);
    return s.layered ? result + reflect_layers(s, to_light) * irradiance * soft : result;
}

glm::vec3 reflect_surroundings(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance)
{
    const float cosine = glm::dot(s.normal, to_light);
    const float cos_horizon = glm::dot(s.smooth_normal, to_light);
    if (cosine <= 0 || cos_horizon <= 0) return glm::vec3(0);
    const float soft = soften_terminator(cos_horizon, cosine, glm::dot(s.normal, s.smooth_normal));
    glm::vec3 reflectance = s.diffuse * k_inverse_pi;
    if (s.model != scene::ShadingModel::whitted && !s.catches_shadows) {
        const glm::vec3 half = glm::normalize(to_light + s.to_viewer);
        reflectance *= glm::vec3(1) - schlick(s.specular, glm::dot(s.to_viewer, half), s.f90);
    }
    return reflectance * irradiance * (cosine * soft * s.coverage);
}

glm::vec3 ambient_light(const SurfacePoint& s, const scene::Scene& scene, bool stand_in, bool further)
{
    // A backdrop, such as an image behind windows, has an ambient colour and no other, so it is visible without light.
    const bool backdrop = s.model == scene::ShadingModel::whitted && s.diffuse == glm::vec3(0) &&
                          s.specular == glm::vec3(0) && s.transmitted == glm::vec3(0);
    glm::vec3 result = stand_in || backdrop ? s.ambient * scene.ambient : glm::vec3(0);
    const glm::vec3& albedo = s.model == scene::ShadingModel::whitted ? s.diffuse : s.ambient;
    if (stand_in && scene.background.kind == scene::Background::Kind::sky)
        result += albedo * scene.background.ambient(s.normal);
    // A sky's own colour approximates the light of further bounces where they are not computed.
    if (!stand_in && further && scene.background.kind == scene::Background::Kind::sky)
        result += albedo * scene.background.color;
    return result * s.coverage;
}

glm::vec3 reflect_irradiance(const SurfacePoint& s, const Continuation& next, const glm::vec3& indirect,
                             const glm::vec3& surroundings)
{
    const glm::vec3 reflectance = s.diffuse * (s.coverage * k_inverse_pi);
    if (s.model == scene::ShadingModel::whitted) return reflectance * (indirect + surroundings);
    if (s.layered) {
        // The base's parts of what is reflected, of the light that reaches it.
        const float below = s.coverage > 0 ? 1 / s.coverage : 0;
        const glm::vec3 traced = (next.reflected_weight - next.coat_reflected) * below;
        const glm::vec3 blurred = (next.unresolved_weight - next.coat_unresolved) * below;
        const glm::vec3 rest = glm::clamp(glm::vec3(1) - traced, 0.0f, 1.0f);
        const glm::vec3 sheen = s.layers.sheen * (s.layers.sheen_albedo * k_inverse_pi);
        return reflectance * (rest * indirect + glm::max(rest - blurred, glm::vec3(0)) * surroundings) +
               sheen * (indirect + surroundings);
    }
    // Subtract the reflected light. Unresolved reflections bring only the background, so subtract them only from that.
    const glm::vec3 not_traced = glm::max(glm::vec3(1) - next.reflected_weight - next.lobe_weight, glm::vec3(0));
    const glm::vec3 not_mirrored = glm::max(not_traced - next.unresolved_weight, glm::vec3(0));
    return reflectance * (not_traced * indirect + not_mirrored * surroundings);
}

void show_behind(SurfacePoint& s, const glm::vec3& behind, const glm::vec3& open)
{
    s.diffuse = behind * static_cast<float>(k_pi) / open;
    s.ambient = s.diffuse;
    s.specular = glm::vec3(0);
    s.roughness = 1;
}

Continuation continue_from(const SurfacePoint& s)
{
    Continuation c;
    const glm::vec3 direction = -s.to_viewer;
    const float cosine = std::clamp(glm::dot(s.normal, s.to_viewer), 0.0f, 1.0f);
    c.straight_weight = glm::vec3(s.uncovered);
    const bool refracts = s.transmitted != glm::vec3(0);
    if (s.specular == glm::vec3(0) && !refracts && !(s.layered && s.layers.coat > 0)) return c;
    c.reflected = mirrored(s, s.layered ? mirror_normal(s) : s.normal);

    if (refracts) {
        const bool thin = s.layers.thin;
        const float eta = s.front || thin ? s.ior : 1 / s.ior;
        const float fresnel = fresnel_dielectric(cosine, eta);
        // AFF glass has a reflection colour besides its index; it is weighted by what Fresnel reflection leaves.
        const bool whitted = s.model == scene::ShadingModel::whitted;
        c.reflected_weight = whitted ? glm::vec3(fresnel) + s.specular * (1 - fresnel) : glm::vec3(fresnel);
        glm::vec3 passing(1 - fresnel);
        if (s.layered) {
            c.reflected_weight = scaled_fresnel(s, fresnel);
            passing = glm::vec3(1) - c.reflected_weight;
        }
        if (thin) {
            c.refracted_weight = s.transmitted * passing;
            c.refracted = direction;
        } else if (fresnel < 1) {
            c.refracted_weight = s.transmitted * passing;
            const float ratio = 1 / eta;
            const float cos_t = std::sqrt(std::max(0.0f, 1 - ratio * ratio * (1 - cosine * cosine)));
            c.refracted = glm::normalize(ratio * direction + (ratio * cosine - cos_t) * s.normal);
            if (const float below = glm::dot(c.refracted, s.geometric_normal); below >= 0)
                c.refracted = glm::normalize(c.refracted - (1e-3f + below) * s.geometric_normal);
        }
    } else if (s.model == scene::ShadingModel::whitted) {
        c.reflected_weight = s.specular;
    } else if (s.model == scene::ShadingModel::metallic_roughness) {
        const float f90 = s.f90 * std::max({1 - s.roughness, s.specular.x, s.specular.y, s.specular.z});
        const glm::vec3 fresnel = schlick(s.specular, cosine, f90);
        const float traced = traced_part(s.roughness);
        c.reflected_weight = fresnel * traced;
        c.unresolved_weight = fresnel * (1 - traced);
    }
    c.reflected_weight *= s.coverage;
    c.refracted_weight *= s.coverage;
    c.unresolved_weight *= s.coverage;
    if (s.layered) add_coat(s, c);
    return c;
}

}   // namespace gnomon::shading
