// SPDX-License-Identifier: Apache-2.0
#pragma once
// Surface reflection: Phong for AFF [Whitted 1980], GGX for glTF [Walter et al. 2007; Khronos glTF 2.0, appendix B],
// and the reflected and refracted rays that continue from a surface.
//
// AFF's convention has no pi: radiance = diffuse * irradiance. Its images are therefore uniformly pi times brighter
// than radiometry prescribes.

#include "shading/surface.h"

namespace gnomon::shading {

/// Radiance towards the viewer by light from one direction. It is black where the light is below the smooth horizon
/// (SurfacePoint::smooth_normal). Where a normal map turns the normal, the light fades out above this horizon
/// [Chiang et al. 2019].
/// @param to_light    unit
/// @param irradiance  on a surface that faces the light
glm::vec3 reflect_light(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance);

/// The same for a light that approximates a part of the environment: diffuse reflection only, because reflected rays
/// and Continuation::unresolved_weight account for the rest. Includes pi for AFF surfaces too, because the environment
/// is radiance.
glm::vec3 reflect_surroundings(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance);

/// Reflection of ambient light: that of the sky, unoccluded, and the scene's own, which approximates bounced light (AFF
/// `am`).
/// @param stand_in  false where both are computed; then only AFF surfaces that reflect no other light have an ambient
///                  term
/// @param further  a sky's own colour stands in for light of further bounces
glm::vec3 ambient_light(const SurfacePoint& s, const scene::Scene& scene, bool stand_in, bool further = true);

/// Makes a surface that catches shadows show what is behind it where nothing keeps light from it, and less of it
/// elsewhere: its reflectance becomes that of a diffuse surface which would look so.
/// @param behind  radiance from beyond the scene, along the ray that sees the surface
/// @param open    irradiance of the surface if nothing of the scene hid light from it; above 0
void show_behind(SurfacePoint& s, const glm::vec3& behind, const glm::vec3& open);

/// The rays that continue from a surface, each with the weight of its radiance. A weight of zero: no such ray.
struct Continuation {
    glm::vec3 reflected_weight{0}, reflected{0};
    glm::vec3 refracted_weight{0}, refracted{0};
    glm::vec3 straight_weight{0};     // through the uncovered part of a BLEND surface
    glm::vec3 unresolved_weight{0};   // of the background reflected by rough surfaces, without a ray
    glm::vec3 lobe_weight{0};         // of what the rays of a rough surface's lobe bring (lobe_rays.h)
    // The coat's part of two of them.
    float coat_reflected = 0, coat_unresolved = 0;
};
Continuation continue_from(const SurfacePoint& s);

/// The fraction of a lobe of this perceptual roughness for which one mirrored ray is traced.
float traced_part(float roughness);

/// What a diffuse layer reflects towards the viewer of irradiance from many directions.
inline glm::vec3 reflect_diffusely(const glm::vec3& diffuse, float coverage, const glm::vec3& irradiance)
{
    return diffuse * (coverage * static_cast<float>(1 / k_pi)) * irradiance;
}

/// Diffuse radiance towards the viewer by light from many directions. For glTF surfaces, light that is accounted for by
/// reflected rays and Continuation::unresolved_weight is not counted again. Includes pi for AFF surfaces too, because
/// the incoming light is radiance.
/// @param indirect      irradiance from other surfaces
/// @param surroundings  irradiance from the background and from emissive surfaces
glm::vec3 reflect_irradiance(const SurfacePoint& s, const Continuation& next, const glm::vec3& indirect,
                             const glm::vec3& surroundings);

/// Fresnel reflectance of unpolarised light at a dielectric boundary.
/// @param cosine  of the angle of incidence, 0 to 1
/// @param eta     index behind the boundary over index before; returns 1 on total reflection
float fresnel_dielectric(float cosine, float eta);

}   // namespace gnomon::shading
